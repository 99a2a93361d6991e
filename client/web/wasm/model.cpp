#include "client/web/wasm/model.h"

#include <algorithm>

#include "codec/transform/transform.h"

namespace mvw::web {
namespace {

Limits browser_limits(std::uint64_t memory_bytes) {
    Limits limits;
    limits.max_memory_bytes = memory_bytes;
    limits.max_vertices = 1u << 23;
    limits.max_base_faces = 1u << 21;
    limits.max_chunks = 1u << 20;
    return limits;
}

void field(std::string& json, const char* name, const std::string& value) {
    json += json.back() == '{' ? "\"" : ",\"";
    json += name;
    json += "\":" + value;
}

}  // namespace

Model::Model(std::uint64_t memory_bytes) : limits_(browser_limits(memory_bytes)), decoder_(limits_) {}

Result<void> Model::feed(ByteSpan bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    const Result<void> fed = decoder_.feed(bytes);
    const FileHeader* header = decoder_.header();
    if (header == nullptr) return fed;
    file_bytes_ = header->file_bytes();
    if (fed.ok() && !indexed_ && bytes_.size() == header->file_bytes())
        (void)take_index(ByteSpan(bytes_).subspan(header->index_offset)).ok();
    return fed;
}

Result<void> Model::take_index(ByteSpan bytes) {
    const FileHeader* header = decoder_.header();
    if (header == nullptr) return Error{Errc::InvalidArgument, 0, "the index came before the header"};
    const Result<Toc> toc = read_toc(*header, bytes, header->file_bytes(), limits_);
    if (!toc.ok()) return toc.error();
    if (!indexed_) list_chunks(*toc);
    return {};
}

void Model::list_chunks(const Toc& toc) {
    indexed_ = true;
    for (const ChunkEntry& c : toc.chunks) {
        const double end = static_cast<double>(c.offset + c.length);
        chunks_.push_back({c.id, c.crc32c, end, static_cast<std::size_t>(c.offset), c.length});
        points_.push_back({end, c.error});
    }
}

void Model::take(const client::Opened& opened) {
    if (decoder_.header() != nullptr) return;
    (void)decoder_.feed_header(opened.header).ok();
    bytes_ = opened.header;
    chunk_count_ = opened.chunk_count;
    file_bytes_ = opened.file_bytes;
}

void Model::take(client::Received& chunk) {
    (void)decoder_.feed_chunk(chunk.id, chunk.payload, chunk.crc32c).ok();
    const std::size_t at = bytes_.size();
    bytes_.insert(bytes_.end(), chunk.payload.begin(), chunk.payload.end());
    chunks_.push_back({chunk.id, chunk.crc32c, static_cast<double>(bytes_.size()), at, chunk.payload.size()});
    // Out of file order an error is stated for more than has come: it is shown once the rest has.
    const double error = points_.empty() ? 1.0 : points_.back()[1];
    points_.push_back({static_cast<double>(bytes_.size()), std::min<double>(error, chunk.error)});
}

void Model::take(const client::Restarted&) {
    *this = Model(limits_.max_memory_bytes);
}

bool Model::complete() const {
    return chunk_count_ > 0 ? chunks_.size() == chunk_count_ : file_bytes_ > 0 && bytes_.size() == file_bytes_;
}

/// The one of everything, or one that is given the chunks of the view; it is kept, because sliders move step by step.
Result<const Decoder*> Model::decoder_of(const View& view) {
    const bool all_bytes = view.bytes >= static_cast<double>(bytes_.size());
    if (decoder_.header() == nullptr || (all_bytes && view.layer + 1u >= decoder_.header()->layers)) return &decoder_;
    if (chunks_.empty()) {  // no index yet: the beginning as a file of its own
        subset_.emplace(limits_);
        subset_chunks_ = 0;
        const auto size = static_cast<std::size_t>(std::min<double>(view.bytes, static_cast<double>(bytes_.size())));
        if (const Result<void> fed = subset_->feed(ByteSpan(bytes_).first(size)); !fed.ok()) return fed.error();
        subset_->finish();
        return &*subset_;
    }
    const auto wanted =
        static_cast<std::size_t>(std::partition_point(chunks_.begin(), chunks_.end(),
                                                      [&](const Chunk& c) { return c.end <= view.bytes && holds(c); }) -
                                 chunks_.begin());
    if (!subset_ || subset_layer_ != view.layer || subset_chunks_ > wanted || subset_chunks_ == 0) {
        subset_.emplace(limits_);
        if (const Result<void> fed = subset_->feed_header(bytes_); !fed.ok()) return fed.error();
        subset_layer_ = view.layer;
        subset_chunks_ = 0;
    }
    for (; subset_chunks_ < wanted; ++subset_chunks_) {
        const Chunk& c = chunks_[subset_chunks_];
        if (in_layers(*decoder_.header(), c.id, view.layer))
            (void)subset_->feed_chunk(c.id, ByteSpan(bytes_).subspan(c.at, c.length), c.crc32c).ok();
    }
    return &*subset_;
}

Result<void> Model::draw(const View& view) {
    const Result<const Decoder*> decoder = decoder_of(view);
    if (!decoder.ok()) return decoder.error();
    client::DrawableOptions options = view.lines;
    options.level = view.level;
    Result<client::Drawable> drawable = make_drawable(**decoder, options);
    if (!drawable.ok()) return drawable.error();
    drawable_ = std::move(*drawable);
    drawn_state_ = (*decoder)->state();
    return {};
}

std::string Model::describe() const {
    const FileHeader* header = decoder_.header();
    if (header == nullptr) return {};
    const unsigned levels = finest_level(*header);
    std::string vertices = "[", faces = "[";
    for (unsigned level = 0; level <= levels; ++level) {
        std::uint64_t V = 0, F = 0;
        for (std::size_t p = 0; p < header->main_parts(); ++p) {
            const PartInfo& part = header->parts[p];
            const unsigned l = std::min<unsigned>(level, part.levels);
            V += vertices_at_level(part.base_vertices, part.base_edges, part.base_faces, l);
            F += std::uint64_t{part.base_faces} << (2 * l);
        }
        vertices += (level == 0 ? "" : ",") + std::to_string(V);
        faces += (level == 0 ? "" : ",") + std::to_string(F);
    }
    const bool known = header->transform < kTransformCount;
    std::string json = "{";
    field(json, "version", std::to_string(header->version));
    field(json, "transform",
          known ? "\"" + std::string(transform_name(TransformKind{header->transform})) + "\"" : "null");
    field(json, "parts", std::to_string(header->main_parts()));
    field(json, "levels", std::to_string(levels));
    field(json, "layers", std::to_string(header->layers));
    field(json, "headerBytes", std::to_string(header->header_bytes));
    field(json, "indexOffset", std::to_string(header->index_offset));
    field(json, "fileBytes", std::to_string(header->file_bytes()));
    field(json, "vertices", vertices + "]");
    field(json, "faces", faces + "]");
    return json + "}";
}

}  // namespace mvw::web
