#include "codec/decoder.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <map>
#include <optional>
#include <string>

#include "codec/container/crc32c.h"
#include "codec/dec_part.h"

namespace mvw {

struct Decoder::State {
    State(const Limits& l, unsigned threads) : limits(l), workers(threads) {}

    Limits limits;
    Workers workers;
    std::optional<FileHeader> header;
    std::vector<PartDecoder> parts;
    DecodeState counts;  // bytes, chunks, damaged; the rest is made on demand
    std::uint64_t revision = 0;
    std::optional<Error> fault;

    // What expect() said, and how far it has come.
    struct Expected {
        float error = 1;
        bool there = false;
    };
    std::map<ChunkId, std::size_t> place;  // in file order
    std::vector<Expected> expected;
    std::size_t first_missing = 0;

    // The stream that feed() reads.
    Bytes pending;
    std::uint64_t position = 0;  // in the file, of pending's first byte
    ChunkId previous;
    bool finished = false;

    Result<void> take_header(ByteSpan bytes);
    Result<void> read_stream();
    Result<bool> read_chunk(ByteSpan rest, std::size_t& used);
    bool take_chunk(const ChunkId& id, ByteSpan payload, bool whole);
    void came(const ChunkId& id);
    /// Whether the closing part's base is there.
    [[nodiscard]] bool is_closed() const {
        return header && header->parts.back().supersedes && parts.back().has_base();
    }
    /// Whether a preview's base is there, and the main parts are not nearer to the input yet; those who ask for a level
    /// get it as soon as these have their bases.
    [[nodiscard]] bool is_previewed(bool any_level) const {
        const std::size_t main = header->main_parts();
        if (main == parts.size() || !header->parts[main].preview || !parts[main].has_base()) return false;
        std::uint8_t code = 0;
        for (std::size_t part = 0; part < main; ++part) {
            if (!parts[part].has_base()) return true;
            code = std::max(code, parts[part].error_code());
        }
        return any_level && code <= parts[main].error_code();
    }
    [[nodiscard]] unsigned finest() const {
        unsigned level = 0;
        for (const PartDecoder& part : parts) level = std::max(level, part.finest_level());
        return level;
    }
    Error lost(const std::string& why) const {
        return {Errc::Malformed, position, "byte " + std::to_string(position) + ": " + why};
    }
};

Decoder::Decoder(const Limits& limits, unsigned threads) : state_(std::make_unique<State>(limits, threads)) {}
Decoder::~Decoder() = default;
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;

Result<void> Decoder::State::take_header(ByteSpan bytes) {
    Result<FileHeader> read = read_header(bytes, limits);
    if (!read.ok()) return read.error();
    header = std::move(*read);
    counts.bytes += header->header_bytes;
    Limits each = limits;  // parts share the ceilings
    each.max_memory_bytes /= header->parts.size();
    each.max_vertices /= header->parts.size();
    for (const PartInfo& part : header->parts)
        parts.emplace_back(part, header->transform, header->layers, each, workers);
    return {};
}

bool Decoder::State::take_chunk(const ChunkId& id, ByteSpan payload, bool whole) {
    const Result<void> taken = parts[id.part].take(id, payload, whole);
    if (whole) ++(taken.ok() ? counts.chunks : counts.damaged);
    ++revision;
    return taken.ok();
}

void Decoder::State::came(const ChunkId& id) {
    const auto it = place.find(id);
    if (it == place.end()) return;
    expected[it->second].there = true;
    while (first_missing < expected.size() && expected[first_missing].there) ++first_missing;
}

/// One chunk out of `rest`; false where more bytes are needed.
Result<bool> Decoder::State::read_chunk(ByteSpan rest, std::size_t& used) {
    ByteReader in(rest);
    const Result<ChunkHead> head = read_chunk_head(in, previous, limits);
    if (!head.ok() && head.error().code == Errc::NeedMoreData) return false;
    if (!head.ok()) return lost(head.error().message);
    if (const Result<void> r = check_chunk_id(*header, head->id); !r.ok()) return lost(r.error().message);
    if (position + in.offset() + head->length > header->index_offset) return lost("a chunk ends behind the last one");
    if (head->length > in.remaining()) return false;
    const ByteSpan fields = rest.first(in.offset() - 2), payload = rest.subspan(in.offset(), head->length);
    if (chunk_check(fields, payload) == head->check) {
        take_chunk(head->id, payload, true);
        counts.bytes += in.offset() + head->length;
    } else {
        ++counts.damaged;
    }
    previous = head->id;
    used = in.offset() + head->length;
    return true;
}

Result<void> Decoder::State::read_stream() {
    std::size_t used = 0;
    if (!header) {
        const Result<void> r = take_header(pending);
        if (!r.ok() && r.error().code == Errc::NeedMoreData) return {};
        if (!r.ok()) return r;
        used = header->header_bytes;
        position = used;
    }
    while (position < header->index_offset) {
        std::size_t bytes = 0;
        const Result<bool> more = read_chunk(ByteSpan(pending).subspan(used), bytes);
        if (!more.ok()) return more.error();
        if (!*more) break;
        used += bytes;
        position += bytes;
    }
    if (position >= header->index_offset) {  // the index serves those who seek
        position += pending.size() - used;
        used = pending.size();
        if (position > header->file_bytes()) return lost("bytes behind the end of the file");
    }
    pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(used));
    return {};
}

Result<void> Decoder::feed(ByteSpan bytes) {
    State& s = *state_;
    if (s.fault) return *s.fault;
    s.pending.insert(s.pending.end(), bytes.begin(), bytes.end());
    const Result<void> r = s.read_stream();
    if (!r.ok()) s.fault = r.error();
    return r;
}

void Decoder::finish() {
    State& s = *state_;
    if (s.finished || s.fault || !s.header || s.position >= s.header->index_offset) return;
    s.finished = true;
    ByteReader in(s.pending);
    const Result<ChunkHead> head = read_chunk_head(in, s.previous, s.limits);
    if (!head.ok() || !check_chunk_id(*s.header, head->id).ok()) return;
    s.take_chunk(head->id, in.bytes(in.remaining()), false);
    s.counts.bytes += s.pending.size();
}

Result<void> Decoder::feed_header(ByteSpan bytes) {
    if (state_->header) return Error{Errc::InvalidArgument, 0, "the header is already there"};
    return state_->take_header(bytes);
}

Result<void> Decoder::feed_chunk(const ChunkId& id, ByteSpan payload, std::uint32_t crc) {
    State& s = *state_;
    if (!s.header) return Error{Errc::InvalidArgument, 0, "a chunk came before the header"};
    if (const Result<void> r = check_chunk_id(*s.header, id); !r.ok()) return r;
    if (payload.size() > s.limits.max_chunk_bytes) return Error{Errc::LimitExceeded, 0, "a chunk is too long"};
    if (crc32c(payload) != crc) {
        ++s.counts.damaged;
        return Error{Errc::Malformed, 0, "a chunk's checksum is wrong"};
    }
    s.counts.bytes += payload.size();
    if (s.take_chunk(id, payload, true)) s.came(id);
    return {};
}

void Decoder::expect(std::span<const ChunkEntry> chunks) {
    State& s = *state_;
    s.place.clear();
    s.expected.clear();
    s.first_missing = 0;
    for (const ChunkEntry& c : chunks) {
        s.place.emplace(c.id, s.expected.size());
        s.expected.push_back({c.error, false});
    }
}

bool Decoder::feed_file(ByteSpan file, const std::function<bool(const ChunkEntry&)>& wanted) {
    const Result<FileHeader> header = read_header(file, state_->limits);
    if (!header.ok() || header->file_bytes() != file.size()) return false;
    const Result<Toc> toc = read_toc(*header, file.subspan(header->index_offset), file.size(), state_->limits);
    if (!toc.ok() || !feed_header(file).ok()) return false;
    expect(toc->chunks);
    for (const ChunkEntry& c : toc->chunks)
        if (!wanted || wanted(c)) (void)feed_chunk(c.id, file.subspan(c.offset, c.length), c.crc32c).ok();
    return true;
}

const FileHeader* Decoder::header() const {
    return state_->header ? &*state_->header : nullptr;
}

DecodeState Decoder::state() const {
    const State& s = *state_;
    DecodeState out = s.counts;
    std::uint8_t code = 0;
    for (const PartDecoder& part : s.parts) {
        out.level = std::max(out.level, part.detail_level());
        code = std::max(code, part.error_code());
        out.waiting += static_cast<std::uint32_t>(part.waiting());
    }
    out.error = error_from_code(code);
    bool all = s.header && !s.fault && s.position >= s.header->index_offset;
    if (!s.expected.empty()) {
        out.error = s.first_missing > 0 ? s.expected[s.first_missing - 1].error : 1;
        all = s.first_missing == s.expected.size();
    }
    out.complete = all && out.damaged == 0 && out.waiting == 0;
    if (out.complete || s.is_closed()) out.level = s.finest();
    return out;
}

std::uint64_t Decoder::revision() const {
    return state_->revision;
}

namespace {

/// Labels stay in order; what is known of one already stays.
void add_colors(std::span<const MaterialColor> from, std::vector<MaterialColor>& to) {
    std::vector<MaterialColor> all;
    std::set_union(to.begin(), to.end(), from.begin(), from.end(), std::back_inserter(all),
                   [](const MaterialColor& a, const MaterialColor& b) { return a.label < b.label; });
    to = std::move(all);
}

}  // namespace

Result<Mesh> Decoder::mesh(unsigned level) const {
    State& s = *state_;
    Mesh out;
    for (std::size_t part = 0; part < s.parts.size(); ++part) {
        if (!shows(part, level)) continue;
        const auto& center = s.header->center;
        s.parts[part].append_mesh(level, {center[0], center[1], center[2]}, s.header->diagonal, out);
        add_colors(s.parts[part].material_colors(), out.material_colors);
    }
    if (out.faces.empty()) return Error{Errc::NeedMoreData, s.position, "no base mesh is there yet"};
    return out;
}

bool Decoder::shows(std::size_t part, unsigned level) const {
    const State& s = *state_;
    if (part >= s.parts.size() || !s.parts[part].has_base()) return false;
    const bool any_level = level > s.finest();
    if (any_level && s.is_closed()) return part + 1 == s.parts.size();
    return s.is_previewed(any_level) ? part == s.header->main_parts() : part < s.header->main_parts();
}

const BaseMesh* Decoder::base(std::size_t part) const {
    return part < state_->parts.size() ? state_->parts[part].base() : nullptr;
}

unsigned Decoder::finest_level(std::size_t part) const {
    return part < state_->parts.size() ? state_->parts[part].finest_level() : 0;
}

std::uint64_t Decoder::coefficient_digest() const {
    std::uint64_t digest = 0xCBF29CE484222325u;
    for (PartDecoder& part : state_->parts)
        for (const std::span<const Vec3f> values : part.coefficients())
            for (const Vec3f& c : values)
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto bits = std::bit_cast<std::uint32_t>(c[k]);
                    for (unsigned shift = 0; shift < 32; shift += 8)
                        digest = (digest ^ ((bits >> shift) & 255)) * 0x100000001B3u;
                }
    return digest;
}

Result<Mesh> decode(ByteSpan file, unsigned level, const Limits& limits, unsigned threads) {
    Decoder decoder(limits, threads);
    const Result<FileHeader> header = read_header(file, limits);
    if (!header.ok()) return header.error();
    if (!decoder.feed_file(file)) {
        (void)decoder.feed(file).ok();
        decoder.finish();
    }
    return decoder.mesh(level);
}

}  // namespace mvw
