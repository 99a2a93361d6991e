// Files and folders for tests of streaming: sound containers whose payloads mean nothing.
#pragma once
#include <filesystem>
#include <string>

#include "codec/bytes.h"
#include "server/model_source.h"

namespace mvw::test {

/// Shape of a made-up file: chunks for every (level, layer, tile) in that order of loops after the base chunk.
struct StreamModelShape {
    unsigned tiles = 4, levels = 3, layers = 4;
    std::size_t payload_bytes = 300;  // of a chunk, give or take a third
    unsigned seed = 1;                // other seeds give other payloads
};

/// A sound .mvw file; each chunk leaves an error a little lower than the one before.
Bytes make_stream_file(const StreamModelShape& shape = {});

/// That file behind the server's interface, in memory; its flags say what has gone wrong with it.
class MemoryModel final : public server::ModelSource {
 public:
    static std::shared_ptr<MemoryModel> make(Bytes file);
    Result<void> read(std::uint64_t offset, std::span<std::byte> out) const override;
    bool intact() const override { return intact_; }

    bool intact_ = true, readable_ = true;

 private:
    MemoryModel(Toc toc, Bytes header, Bytes file);
    Bytes file_;
};

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    [[nodiscard]] std::string path(const std::string& name = "") const;
    /// Beside its name, then renamed: as files should be put where a server reads.
    void put(const std::string& name, ByteSpan bytes) const;
    /// Into the file as it is.
    void overwrite(const std::string& name, ByteSpan bytes) const;

 private:
    std::filesystem::path folder_;
};

}  // namespace mvw::test
