// A model as the session and the transports see it: its table of contents and its bytes.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "codec/container/toc.h"

namespace mvw::server {

/// One model, fixed at the moment it was opened. Safe to use from several threads.
class ModelSource {
 public:
    virtual ~ModelSource() = default;

    [[nodiscard]] const Toc& toc() const { return toc_; }
    [[nodiscard]] ByteSpan header() const { return header_; }  // the file's first header_bytes
    [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }
    [[nodiscard]] std::uint64_t payload_bytes() const { return payload_bytes_; }

    /// Fills `out` with the file's bytes from `offset`. Io where that fails or the file has become too short.
    virtual Result<void> read(std::uint64_t offset, std::span<std::byte> out) const = 0;
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

/// Finds a model by the name that a peer sent. Io: no such model.
using OpenModel = std::function<Result<ModelPtr>(std::string_view name)>;

}  // namespace mvw::server
