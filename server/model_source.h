// What the server serves, as sessions and transports see it: bytes that can be read at any place, and models among
// them.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "codec/container/toc.h"

namespace mvw::server {

using Fetched = std::function<void(Result<void>)>;

/// Bytes that can be read at any place. Safe to use from several threads.
class ByteSource {
 public:
    virtual ~ByteSource() = default;
    /// Fills `out` with the bytes from `offset`. Io where that fails or the source has become too short.
    virtual Result<void> read(std::uint64_t offset, std::span<std::byte> out) const = 0;
    /// Of the file that holds these very bytes, for sends without a copy; -1 where there is none.
    [[nodiscard]] virtual int descriptor() const { return -1; }
    /// False where fetch() must come before read() or a send by descriptor(): the bytes are not on this machine yet.
    [[nodiscard]] virtual bool ready(std::uint64_t /*offset*/, std::uint64_t /*length*/) const { return true; }
    /// Brings these bytes here. Calls `done` once, from any thread or at once, with Io where that fails.
    virtual void fetch(std::uint64_t /*offset*/, std::uint64_t /*length*/, const Fetched& done) const { done({}); }
};

/// One model, fixed at the moment it was opened; read() is by offsets of its file. Safe to use from several threads.
class ModelSource : public ByteSource {
 public:
    [[nodiscard]] const Toc& toc() const { return toc_; }
    [[nodiscard]] ByteSpan header() const { return header_; }  // the file's first header_bytes
    [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }
    [[nodiscard]] std::uint64_t payload_bytes() const { return payload_bytes_; }

    /// False once the bytes behind this model have been overwritten in place; a file replaced by another of its name
    /// stays what it was.
    [[nodiscard]] virtual bool intact() const = 0;

 protected:
    ModelSource(Toc toc, Bytes header, std::uint64_t file_bytes);

 private:
    Toc toc_;
    Bytes header_;
    std::uint64_t file_bytes_ = 0, payload_bytes_ = 0;
};

using ModelPtr = std::shared_ptr<const ModelSource>;

/// Finds a model by the name that a peer sent. Io: no such model. NeedMoreData: not known yet, wait and ask again.
using OpenModel = std::function<Result<ModelPtr>(std::string_view name)>;
/// Calls `then` once, from any thread or at once, when OpenModel has another answer than NeedMoreData for the name.
using WhenKnown = std::function<void(std::string_view name, const std::function<void()>& then)>;
/// Whether a token allows a model; an error's message is a sentence for the peer. Empty: all is allowed.
using CheckToken = std::function<Result<void>(std::string_view token, std::string_view name)>;

}  // namespace mvw::server
