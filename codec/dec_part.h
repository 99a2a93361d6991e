// One part of a model as far as its chunks have come: base, bit-planes, coefficients, and the mesh that they give.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "codec/dec_attribute.h"
#include "codec/dec_base.h"
#include "codec/entropy/dec_block.h"
#include "codec/entropy/progressive_mesh.h"
#include "codec/part_units.h"
#include "codec/transform/integer.h"
#include "codec/transform/tables.h"
#include "codec/workers.h"

namespace mvw {

class PartDecoder {
 public:
    /// workers: decode tiles side by side; must outlive this.
    PartDecoder(const PartInfo& info, std::uint8_t transform, std::uint8_t layers, const Limits& limits,
                Workers& workers);

    /// Takes in one chunk's payload, or, where it is not whole, the beginning of one. What has to wait for other chunks
    /// is kept (a beginning is dropped), what is ready is decoded when its coefficients are asked for, all tiles then
    /// at once. Malformed where the payload contradicts FORMAT.md 4; then nothing has changed. Chunks already there,
    /// above the limits or of unknown channels are ignored, and so are a block's planes from one on that turns out
    /// damaged only then, behind a good checksum (an encoder's fault, or a forgery).
    Result<void> take(const ChunkId& id, ByteSpan payload, bool whole);

    [[nodiscard]] bool has_base() const { return base_.has_value(); }
    [[nodiscard]] const BaseMesh* base() const { return base_ ? &base_->mesh : nullptr; }
    /// Of positions, then of attributes, each in hierarchical order, as far as blocks have come.
    [[nodiscard]] std::vector<std::span<const Vec3f>> coefficients();
    /// Finest level of which a detail has come, of positions or attributes.
    [[nodiscard]] unsigned detail_level() const { return detail_level_; }
    /// Lowest error that a chunk taken in has stated.
    [[nodiscard]] std::uint8_t error_code() const { return error_code_; }
    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
    /// Finest level that is handed out.
    [[nodiscard]] unsigned finest_level() const { return finest_; }

    /// Adds the part's mesh at min(level, finest_level()) to `out`: positions center + diagonal * p. Needs has_base().
    /// Asked again for a level, it synthesises only what chunks have changed since: work in proportion to their tiles
    /// and levels, but for the copy handed out.
    void append_mesh(unsigned level, const Vec3& center, double diagonal, Mesh& out);
    /// Colours of materials, as far as the base says them.
    [[nodiscard]] std::span<const MaterialColor> material_colors() const { return base_->params.colors; }

 private:
    struct Block {
        explicit Block(unsigned components) : decoder(components) {}
        BlockDecoder decoder;
        std::unique_ptr<BlockShape> shape;  // while planes can still come; the fast profile needs none
        unsigned plane = kMaxPlanes;        // lowest one taken in
        bool cut = false;                   // a beginning of it only: no other can follow
        bool changed = false;               // since its values were last stored
    };
    enum class Readiness { Ready, Waits, Known };

    Result<void> take_base(ByteSpan payload);
    /// Lays out what there is for base_ as it is now.
    void adopt_base();
    Result<void> take_splits(const ChunkId& id, ByteSpan payload, bool whole);
    void take_waiting_splits();
    Result<void> split(ByteSpan payload, bool whole);
    /// Whether no splits are to come.
    [[nodiscard]] bool is_grown() const { return base_->mesh.vertex_count() == info_.base_vertices; }
    Result<void> take_attributes(ByteSpan payload);
    void retry_all_waiting();
    enum class Taken { Used, Waits, Dropped };
    Result<Taken> take_planes(const ChunkId& id, ByteSpan payload, bool whole);
    Result<Readiness> readiness(const ChunkId& id, const GeometryFront& front);
    Result<bool> queue_planes(const ChunkId& id, const GeometryFront& front, ByteReader& in, bool whole);
    using Tasks = std::vector<std::function<void()>>;
    /// Decodes what has been queued; meanwhile makes ready for a mesh of this level, and does what is asked besides.
    void settle(unsigned level = 0, Tasks besides = {});
    void settle_tile(std::uint32_t tile);
    struct Queued {
        unsigned top;  // plane
        Bytes planes;  // down to the chunk's lowest, as they came
    };
    /// raw: room for the fast profile's planes.
    void decode_planes(const ChunkId& id, const Queued& queued, Bytes& raw);
    template <typename Visit>
    void visit_queue(std::uint32_t tile, Visit visit);
    void retry_waiting(Channel channel, std::uint16_t tile, unsigned level);
    void store_values(const ChunkId& id, const Block& block);
    void store_attribute(std::size_t kind, const ChunkId& id, const BlockDecoder& from);
    void store_integers(const ChunkId& id, const BlockDecoder& from);
    void ensure_coefficients(unsigned level);
    /// out: V(level).
    void place_positions(unsigned level, const Vec3& center, double diagonal, std::span<Vec3> out);
    [[nodiscard]] std::size_t vertex_count(unsigned level) const {
        return static_cast<std::size_t>(vertices_at_level(base_->mesh, level));
    }
    [[nodiscard]] bool needs_transform(unsigned level) const;
    [[nodiscard]] bool needs_attribute_transform(unsigned level) const;
    void make_transform(unsigned level);
    void synthesize(unsigned level);
    void lay_flat(unsigned level);
    void mark_changed(const ChunkId& id);
    [[nodiscard]] std::vector<std::uint32_t> changed_faces() const;
    void append_attributes(unsigned level, std::size_t first_vertex, std::size_t first_face, Mesh& out);
    [[nodiscard]] const Tiling& tiling(unsigned level) const {
        return level < info_.first_tiled_level ? whole_ : tiling_;
    }
    /// Whether blocks of this level look at those one level below.
    [[nodiscard]] bool has_parents(unsigned level) const {
        return level >= 2 && (level != info_.first_tiled_level || info_.tiles == 1);
    }
    [[nodiscard]] unsigned lowest_plane_of(const ChunkId& id) const { return layers_ - 1u - id.layer; }
    /// Of a channel's coefficients: 0 positions, k the attribute k - 1; none where the part has not this channel.
    [[nodiscard]] std::optional<std::size_t> kind_of(Channel channel) const;
    [[nodiscard]] unsigned components_of(Channel channel) const;
    std::unique_ptr<Block>& block(const ChunkId& id, unsigned level) {
        const std::size_t kind = kind_of(id.channel).value();
        return blocks_[(kind * info_.tiles + id.tile) * (finest_ + 1u) + level];
    }
    /// Lowest plane that a block has, kMaxPlanes where none.
    [[nodiscard]] unsigned reached(const ChunkId& id, unsigned level) {
        const std::unique_ptr<Block>& b = block(id, level);
        return b ? b->plane : kMaxPlanes;
    }
    /// Lowest one that is there whole.
    [[nodiscard]] unsigned reached_whole(const ChunkId& id, unsigned level) {
        const unsigned lowest = reached(id, level);
        return lowest < kMaxPlanes && block(id, level)->cut ? lowest + 1 : lowest;
    }

    Workers& workers_;
    PartInfo info_;
    std::uint8_t transform_kind_, layers_;
    std::uint64_t most_vertices_;  // that the limits allow
    unsigned finest_ = 0, detail_level_ = 0;
    std::uint8_t error_code_ = 0;
    std::optional<DecodedBase> base_;
    std::unique_ptr<ProgressiveMesh> splitting_;  // of a progressive part, while splits can come
    std::uint8_t next_splits_ = 0;                // layer
    PartUnits units_;
    bool flat_ = true;                            // facets, of which no details have come
    Tiling whole_, tiling_;                       // of levels below info_.first_tiled_level, and of the others
    std::vector<std::unique_ptr<Block>> blocks_;  // by kind (kind_of), tile and level; null before the first chunk
    std::uint64_t blocks_left_ = 0;               // that memory allows
    std::vector<Vec3f> coefficients_;             // V(level) of the finest level in use; grows
    std::vector<IntegerPoint> integers_;          // likewise, of a lossless part, in units of the grid
    std::vector<AttributeDecoder> attributes_;
    // Chunks by channel (in the place of the part), tile, level, layer: to be decoded, the last of a block maybe a
    // beginning; waiting for others.
    std::map<ChunkId, Queued> queue_;
    std::map<ChunkId, Bytes> waiting_;
    std::shared_ptr<TransformTables> tables_, attribute_tables_;
    std::unique_ptr<PatchTransform> transform_, attribute_transform_;
    unsigned transform_levels_ = 0, attribute_levels_ = 0;
    bool updates_ = false;        // transform_ can update: from the second mesh asked for
    std::vector<Vec3f> surface_;  // last synthesised, of V(level); empty: none
    static constexpr unsigned kUnchanged = 255;
    unsigned changed_level_ = kUnchanged;      // lowest one changed since, ...
    std::vector<std::uint8_t> changed_tiles_;  // ... and flags of the tiles
};

}  // namespace mvw
