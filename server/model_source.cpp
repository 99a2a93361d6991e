#include "server/model_source.h"

#include <utility>

namespace mvw::server {

ModelSource::ModelSource(Toc toc, Bytes header, std::uint64_t file_bytes)
    : toc_(std::move(toc)), header_(std::move(header)), file_bytes_(file_bytes) {
    for (const ChunkEntry& chunk : toc_.chunks) payload_bytes_ += chunk.length;
}

}  // namespace mvw::server
