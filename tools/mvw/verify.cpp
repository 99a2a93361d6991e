// mvw verify: every checksum, every limit, a full decode.
#include <fmt/core.h>

#include <memory>
#include <optional>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/dec_original.h"
#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

std::string name_of(const ChunkEntry& c) {
    return fmt::format("chunk at byte {} (part {}, tile {}, level {}, layer {})", c.offset, c.id.part, c.id.tile,
                       c.id.level, c.id.layer);
}

/// Each chunk against both of its checksums and the bytes that its head should have.
void check_chunks(const Toc& toc, ByteSpan file, std::vector<std::string>& faults) {
    ChunkId previous;
    for (const ChunkEntry& c : toc.chunks) {
        ByteWriter head;
        write_chunk_head(head, previous, c.id, c.length);
        previous = c.id;
        const ByteSpan payload = file.subspan(c.offset, c.length);
        ByteReader found(file.subspan(c.offset - head.size() - 2));
        const ByteSpan fields = found.bytes(head.size());
        const std::uint16_t check = found.u16();
        if (crc32c(payload) != c.crc32c)
            faults.push_back(name_of(c) + ": its checksum is wrong");
        else if (!std::equal(fields.begin(), fields.end(), head.view().begin()) ||
                 check != chunk_check(fields, payload))
            faults.push_back(name_of(c) + ": the head in front of it is damaged");
    }
}

void check_decode(ByteSpan file, std::vector<std::string>& faults) {
    Decoder decoder;
    std::optional<ChunkEntry> fed;
    std::uint32_t damaged = 0;
    const auto check_last = [&] {
        if (fed && decoder.state().damaged != damaged) faults.push_back(name_of(*fed) + ": it does not decode");
        damaged = decoder.state().damaged;
    };
    (void)decoder.feed_file(file, [&](const ChunkEntry& c) {
        check_last();
        fed = c;
        return true;
    });
    check_last();
    const DecodeState state = decoder.state();
    if (state.waiting > 0)
        faults.push_back(fmt::format("{} chunks wait for others that the file does not have", state.waiting));
    const Result<Mesh> original = decode_original(file);
    if (!original.ok() && original.error().code != Errc::InvalidArgument) faults.push_back(original.error().message);
    if (const Result<Mesh> mesh = decoder.mesh(); !mesh.ok()) faults.push_back(mesh.error().message);
}

std::vector<std::string> faults_of(ByteSpan file) {
    const Result<FileHeader> header = read_header(file);
    if (!header.ok()) return {header.error().message};
    if (file.size() < header->file_bytes())
        return {fmt::format("cut at byte {} of {}", file.size(), header->file_bytes())};
    if (file.size() > header->file_bytes())
        return {fmt::format("{} bytes behind its end at byte {}", file.size() - header->file_bytes(),
                            header->file_bytes())};
    const Result<Toc> toc = read_toc(*header, file.subspan(header->index_offset), file.size());
    if (!toc.ok()) return {toc.error().message};
    std::vector<std::string> faults;
    check_chunks(*toc, file, faults);
    check_decode(file, faults);
    const auto id = content_id_of(file);
    if (!id.ok() || *id != header->content_id) faults.emplace_back("the content id is not that of the content");
    return faults;
}

void verify(const std::string& input) {
    const Result<Bytes> file = read_file(input);
    if (!file.ok()) throw Fatal{kFailure, file.error().message};
    const std::vector<std::string> faults = faults_of(*file);
    if (faults.size() > 1)
        for (std::size_t i = 1; i < faults.size(); ++i) fmt::print("{}: {}\n", input, faults[i]);
    if (!faults.empty()) throw Fatal{kFailure, input + ": " + faults.front()};
    fmt::print("{}: {} bytes, all checksums right, decodes in full\n", input, file->size());
}

}  // namespace

void add_verify(CLI::App& app) {
    auto input = std::make_shared<std::string>();
    CLI::App* command =
        app.add_subcommand("verify", "Checks every checksum and limit of a .mvw file and decodes it in full");
    command->footer("Example: mvw verify bunny.mvw");
    command->add_option("INPUT.mvw", *input, "File to check")->required();
    command->callback([input] { verify(*input); });
}

}  // namespace mvw::cli
