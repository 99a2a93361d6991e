#include "tests/support/stream_models.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <stdexcept>

#include "codec/container/enc_file.h"

namespace mvw::test {
namespace {

Bytes random_bytes(std::mt19937& random, std::size_t size) {
    Bytes bytes(size + 3);
    for (std::size_t i = 0; i < size; i += 4) {
        const auto word = static_cast<std::uint32_t>(random());
        std::memcpy(bytes.data() + i, &word, sizeof word);
    }
    bytes.resize(size);
    return bytes;
}

}  // namespace

Bytes make_stream_file(const StreamModelShape& shape) {
    FileHeader header;
    if (!set_box(header, {0, 0, 0}, 1).ok()) throw std::runtime_error("box");
    header.layers = static_cast<std::uint8_t>(shape.layers);
    PartInfo part;
    part.levels = static_cast<std::uint8_t>(shape.levels);
    part.tiles = static_cast<std::uint16_t>(shape.tiles);
    part.base_faces = 2 * shape.tiles + 2;  // a closed surface: E = 3F/2, V = 2 - F + E
    part.base_edges = part.base_faces * 3 / 2;
    part.base_vertices = 2 + part.base_edges - part.base_faces;
    header.parts = {part};

    std::vector<ChunkId> ids{{}};
    for (std::uint8_t level = 0; level <= shape.levels; ++level)
        for (std::uint8_t layer = 0; layer < shape.layers; ++layer)
            for (std::uint16_t tile = 0; tile < shape.tiles; ++tile)
                ids.push_back({0, tile, level, layer, Channel::Geometry});

    std::mt19937 random(shape.seed);
    std::vector<Bytes> payloads;
    std::vector<ChunkToWrite> chunks;
    payloads.reserve(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const std::size_t third = shape.payload_bytes / 3;
        payloads.push_back(random_bytes(random, shape.payload_bytes - third + random() % (2 * third + 1)));
        chunks.push_back({ids[i], payloads.back(), 0.1f * std::pow(0.98f, static_cast<float>(i))});
    }
    Result<Bytes> file = write_file(header, chunks);
    if (!file) throw std::runtime_error(file.error().message);
    return std::move(file).value();
}

MemoryModel::MemoryModel(Toc toc, Bytes header, Bytes file)
    : ModelSource(std::move(toc), std::move(header), file.size()), file_(std::move(file)) {}

std::shared_ptr<MemoryModel> MemoryModel::make(Bytes file) {
    FileHeader header = read_header(file).value();
    Bytes header_bytes(file.begin(), file.begin() + header.header_bytes);
    Toc toc = read_toc(header, ByteSpan(file).subspan(header.index_offset, header.index_bytes), file.size()).value();
    return std::shared_ptr<MemoryModel>(new MemoryModel(std::move(toc), std::move(header_bytes), std::move(file)));
}

Result<void> MemoryModel::read(std::uint64_t offset, std::span<std::byte> out) const {
    if (!readable_ || offset > file_.size() || out.size() > file_.size() - offset)
        return Error{Errc::Io, offset, "made to fail"};
    std::copy_n(file_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return {};
}

TemporaryFolder::TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "mvw_test_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp");
    folder_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::string TemporaryFolder::path(const std::string& name) const {
    return (folder_ / name).string();
}

void TemporaryFolder::put(const std::string& name, ByteSpan bytes) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    overwrite(name + ".part", bytes);
    std::filesystem::rename(folder_ / (name + ".part"), folder_ / name);
}

void TemporaryFolder::overwrite(const std::string& name, ByteSpan bytes) const {
    std::ofstream out(folder_ / name, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace mvw::test
