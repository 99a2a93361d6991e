#include "codec/dec_part.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <iterator>
#include <string>
#include <utility>

#include "codec/entropy/dec_splits.h"
#include "codec/entropy/packed_planes.h"
#include "codec/tiles.h"

namespace mvw {

namespace {

/// What a vertex costs while its part is decoded: planes, neighbours, coefficients, grids, the mesh handed out.
constexpr std::uint64_t kBytesPerVertex = 192;
/// What an attribute adds to that.
constexpr std::uint64_t kBytesPerAttribute = 96;
constexpr std::uint64_t kBytesPerBaseFace = 160;  // while its mesh is decoded: faces, edges, their map, border
/// What a block costs besides: its adaptive state.
constexpr std::uint64_t kBytesPerBlock = 8192;

constexpr std::array<float, kMaxComponents> kOnes{1, 1, 1, 1};

/// Vertices from which on a synthesis gains by threads.
constexpr std::size_t kWorthThreads = 200'000;

Error malformed(const char* what) {
    return {Errc::Malformed, 0, what};
}

std::uint64_t most_vertices(const Limits& limits) {
    return std::min({limits.max_vertices, limits.max_memory_bytes / kBytesPerVertex, std::uint64_t{kNone}});
}

/// Chunks that hold coefficients, which a part's Base may or may not announce.
bool is_coefficients(Channel channel) {
    return channel == Channel::Geometry || channel == Channel::Color ||
           (channel >= Channel::FirstField && channel <= Channel::LastField);
}

/// Whether every edge is sharp and no curve of them goes on through a vertex: without details all faces are flat.
bool are_facets(const BaseMesh& base, const std::vector<std::uint8_t>& creases) {
    if (creases.empty() || std::find(creases.begin(), creases.end(), 0) != creases.end()) return false;
    std::vector<std::uint8_t> edges_at(base.vertex_count(), 0);
    for (const BaseEdge& e : base.edges())
        for (const std::uint32_t v : e.v) edges_at[v] = static_cast<std::uint8_t>(std::min(edges_at[v] + 1, 3));
    return std::find(edges_at.begin(), edges_at.end(), 2) == edges_at.end();
}

/// Whether coordinates are as small as those of vertices that splits make.
bool fits_splits(const DecodedBase& base) {
    const unsigned bits = base.params.lattice.bits;
    const std::int64_t most = std::int64_t{2} << bits;
    return bits <= kMostSplitBits && std::all_of(base.grid.begin(), base.grid.end(), [most](const GridPoint& p) {
               return std::all_of(p.begin(), p.end(), [most](std::int64_t x) { return -most <= x && x <= most; });
           });
}

unsigned finest_within(const PartInfo& info, std::uint64_t most) {
    unsigned level = info.levels;
    while (level > 0 && vertices_at_level(info.base_vertices, info.base_edges, info.base_faces, level) > most) --level;
    return level;
}

}  // namespace

PartDecoder::PartDecoder(const PartInfo& info, std::uint8_t transform, std::uint8_t layers, const Limits& limits,
                         Workers& workers)
    : workers_(workers),
      info_(info),
      transform_kind_(transform),
      layers_(layers),
      most_vertices_(most_vertices(limits)),
      finest_(finest_within(info, most_vertices_)),
      blocks_left_(limits.max_memory_bytes / kBytesPerBlock) {}

Result<void> PartDecoder::take(const ChunkId& id, ByteSpan payload, bool whole) {
    if (id.channel == Channel::Base) return whole && !base_ ? take_base(payload) : Result<void>{};
    if (id.channel == Channel::Attributes)
        return whole && attributes_.empty() ? take_attributes(payload) : Result<void>{};
    if (id.channel == Channel::Splits) return take_splits(id, payload, whole);
    if (!is_coefficients(id.channel) || id.level > finest_) return {};
    if (id.channel == Channel::Geometry && !info_.has_planes()) return {};
    const ChunkId here{static_cast<std::uint16_t>(id.channel), id.tile, id.level, id.layer, id.channel};
    const Result<Taken> taken = take_planes(here, payload, whole);
    if (!taken.ok()) return taken.error();
    if (*taken != Taken::Used) return {};
    retry_waiting(id.channel, id.tile, id.level);
    if (id.level < finest_) retry_waiting(id.channel, id.tile, id.level + 1u);
    return {};
}

Result<void> PartDecoder::take_base(ByteSpan payload) {
    if (info_.base_vertices > most_vertices_ || info_.base_faces > most_vertices_ * kBytesPerVertex / kBytesPerBaseFace)
        return Error{Errc::LimitExceeded, 0, "the base takes more vertices or memory than the limit"};
    Result<DecodedBase> base = read_base(payload, info_, transform_kind_);
    if (!base.ok()) return base.error();
    if (info_.progressive && info_.base_vertices > most_vertices_ / 2)  // two of them are there for a moment
        return Error{Errc::LimitExceeded, 0, "the triangles take more memory than the limit"};
    if (info_.progressive && !fits_splits(*base)) return malformed(kCannotSplit);
    base_ = std::move(*base);
    error_code_ = base_->params.error_code;
    if (info_.progressive && !is_grown())
        splitting_ = std::make_unique<ProgressiveMesh>(
            ProgressiveMesh{SplitMesh(base_->mesh, base_->materials), {base_->params.lattice, base_->grid}});
    adopt_base();
    take_waiting_splits();
    return {};
}

void PartDecoder::adopt_base() {
    flat_ = flat_ && are_facets(base_->mesh, base_->creases);
    whole_ = Tiling(base_->mesh, std::vector<std::uint16_t>(base_->mesh.face_count(), 0), 1);
    tiling_ = is_grown() ? Tiling(base_->mesh, tile_of_faces(base_->mesh, info_.tiles), info_.tiles) : whole_;
    blocks_.resize((1 + attributes_.size()) * info_.tiles * (finest_ + 1u));
    units_ = PartUnits(base_->mesh, base_->creases, base_->materials, base_->grid, base_->params);
    coefficients_.clear();
    coefficients_.reserve(base_->grid.size());
    for (std::uint32_t v = 0; v < base_->grid.size(); ++v) coefficients_.push_back(units_.origin(v));
    if (base_->params.lossless) integers_ = base_->grid;
    changed_tiles_.assign(info_.tiles, 0);
    retry_all_waiting();
}

/// One after the other, a beginning last.
Result<void> PartDecoder::take_splits(const ChunkId& id, ByteSpan payload, bool whole) {
    if (id.layer < next_splits_) return {};
    if (!base_ || id.layer > next_splits_) {
        const ChunkId key{static_cast<std::uint16_t>(Channel::Splits), 0, 0, id.layer, Channel::Splits};
        if (whole) waiting_.emplace(key, Bytes(payload.begin(), payload.end()));
        return {};
    }
    const Result<void> done = split(payload, whole);
    if (done.ok() && whole) take_waiting_splits();
    return done;
}

void PartDecoder::take_waiting_splits() {
    for (;;) {
        const auto next =
            waiting_.extract(ChunkId{static_cast<std::uint16_t>(Channel::Splits), 0, 0, next_splits_, Channel::Splits});
        if (next.empty() || !split(next.mapped(), true).ok()) return;
    }
}

Result<void> PartDecoder::split(ByteSpan payload, bool whole) {
    if (!splitting_) return malformed(kNoSplits);
    // What follows a beginning or damaged bytes cannot be used.
    std::unique_ptr<ProgressiveMesh> next = std::exchange(splitting_, nullptr);
    ByteReader in(payload);
    const Lattice before = next->at.lattice;
    const SplitsFront front = read_splits_front(in, before);
    if (!in.ok()) return whole ? Result<void>(malformed("a chunk is too short")) : Result<void>{};
    unsigned bits = before.bits;
    bool in_range = !front.rounds.empty() && front.rounds.size() <= kMostSplitRounds;
    for (const Lattice& lattice : front.rounds) {
        in_range &= lattice.bits >= 1 && lattice.bits <= std::min(bits + kMostFinerBits, kMostSplitBits);
        bits = lattice.bits;
    }
    if (!in_range) return malformed("a round of splits is out of range");
    const Result<void> done =
        decode_splits(front.rounds, in.bytes(in.remaining()), whole, info_.base_vertices, info_.base_faces, *next);
    if (!done.ok()) return done;
    Result<BaseMesh> mesh = BaseMesh::create(next->mesh.vertex_count(), next->mesh.faces());
    if (!mesh.ok()) return mesh.error();
    if (mesh->vertex_count() == info_.base_vertices &&
        (mesh->face_count() != info_.base_faces || mesh->edge_count() != info_.base_edges))
        return malformed(kNoSplits);
    base_->mesh = std::move(*mesh);
    base_->grid = next->at.grid;
    base_->materials = next->mesh.materials();
    base_->params.lattice = next->at.lattice;
    if (whole) error_code_ = std::max(error_code_, front.error_code);
    if (!whole) waiting_.clear();  // what a beginning leads to is no mesh that planes are of
    adopt_base();
    // These need not lie on the lattice.
    std::copy(next->unrefined.begin(), next->unrefined.end(),
              coefficients_.end() - static_cast<std::ptrdiff_t>(next->unrefined.size()));
    if (!whole) return {};
    ++next_splits_;
    if (!is_grown()) splitting_ = std::move(next);
    return {};
}

Result<void> PartDecoder::take_attributes(ByteSpan payload) {
    if (info_.progressive) return malformed(kCannotSplit);
    Result<std::vector<AttributeParams>> params = read_attributes(payload, info_);
    if (!params.ok()) return params.error();
    const std::uint64_t V = vertices_at_level(info_.base_vertices, info_.base_edges, info_.base_faces, finest_);
    if (V > most_vertices_ * kBytesPerVertex / (kBytesPerVertex + params->size() * kBytesPerAttribute))
        return Error{Errc::LimitExceeded, 0, "the attributes take more memory than the limit"};
    error_code_ = std::max(error_code_, ByteReader(payload).u8());
    for (AttributeParams& a : *params) attributes_.emplace_back(std::move(a));
    if (!base_) return {};
    blocks_.resize((1 + attributes_.size()) * info_.tiles * (finest_ + 1u));
    retry_all_waiting();
    return {};
}

void PartDecoder::retry_all_waiting() {
    std::vector<ChunkId> blocks;  // parents come first
    for (const auto& [id, payload] : waiting_) {
        if (id.channel == Channel::Splits) continue;
        const bool same = !blocks.empty() && blocks.back().channel == id.channel && blocks.back().tile == id.tile &&
                          blocks.back().level == id.level;
        if (!same) blocks.push_back(id);
    }
    for (const ChunkId& id : blocks) retry_waiting(id.channel, id.tile, id.level);
}

Result<PartDecoder::Readiness> PartDecoder::readiness(const ChunkId& id, const GeometryFront& front) {
    const unsigned low = lowest_plane_of(id);
    if (front.top_plane < low || front.top_plane >= std::min<unsigned>(layers_, kMaxPlanes))
        return malformed("a chunk's planes are out of range");
    if (front.needs_parent && !has_parents(id.level)) return malformed("a chunk needs a level that has no details");
    if (!base_ || !is_grown()) return Readiness::Waits;
    if (!kind_of(id.channel) && attributes_.empty()) return Readiness::Waits;
    if (!kind_of(id.channel)) return malformed("an attribute comes that the part has not");
    const unsigned here = reached(id, id.level);
    const bool started = here < kMaxPlanes;
    if (started && here <= low) return Readiness::Known;
    if (started && block(id, id.level)->cut) return malformed("a chunk follows a beginning of one");
    if (front.starts && started) return malformed("a block starts twice");
    if (!front.starts && here > front.top_plane + 1) return Readiness::Waits;
    if (!front.starts && here != front.top_plane + 1) return malformed("a chunk's planes overlap");
    if (front.needs_parent && reached_whole(id, id.level - 1u) > low + 1) return Readiness::Waits;
    if (!block(id, id.level) && blocks_left_ == 0)
        return Error{Errc::LimitExceeded, 0, "the blocks take more memory than the limit"};
    return Readiness::Ready;
}

Result<PartDecoder::Taken> PartDecoder::take_planes(const ChunkId& id, ByteSpan payload, bool whole) {
    ByteReader in(payload);
    const GeometryFront front = read_geometry_front(in);
    if (!in.ok() && whole) return malformed("a chunk is too short");
    const bool cut = !whole || front.beginning;
    if (!in.ok() || (cut && in.remaining() < front.least_bytes)) return Taken::Dropped;
    const Result<Readiness> ready = readiness(id, front);
    if (!ready.ok()) return ready.error();
    if (*ready == Readiness::Waits && whole) {
        waiting_.emplace(id, Bytes(payload.begin(), payload.end()));
        return Taken::Waits;
    }
    if (*ready != Readiness::Ready) return Taken::Dropped;
    const Result<bool> queued = queue_planes(id, front, in, !cut);
    if (!queued.ok()) return queued.error();
    if (!*queued) return Taken::Dropped;
    if (whole) error_code_ = std::max(error_code_, front.error_code);
    detail_level_ = std::max<unsigned>(detail_level_, id.level);
    if (id.channel == Channel::Geometry && id.level > 0) flat_ = false;
    return Taken::Used;
}

namespace {

/// Reads past the planes from `top` down to `low`. How far down their bytes go, top + 1 where nowhere; Malformed where
/// a whole chunk does not hold them all.
Result<unsigned> lowest_plane_there(ByteReader in, unsigned top, unsigned low, bool whole) {
    unsigned reached = top + 1;
    for (unsigned plane = top + 1; plane-- > low;) {
        const std::uint64_t length = plane == low ? in.remaining() : in.varint();
        if (whole && (!in.ok() || length > in.remaining())) return malformed("a chunk's planes are cut");
        if (!in.ok()) break;
        reached = plane;
        (void)in.bytes(static_cast<std::size_t>(std::min<std::uint64_t>(length, in.remaining())));
    }
    return reached;
}

}  // namespace

/// Takes note of what a ready chunk holds; false where it is cut and holds nothing.
Result<bool> PartDecoder::queue_planes(const ChunkId& id, const GeometryFront& front, ByteReader& in, bool whole) {
    const unsigned low = lowest_plane_of(id);
    const bool fast = base_->params.fast;
    const Result<unsigned> lowest = fast ? low : lowest_plane_there(in, front.top_plane, low, whole);
    if (!lowest.ok()) return lowest.error();
    if (*lowest > front.top_plane || (fast && !whole)) return false;
    const ByteSpan planes = in.bytes(in.remaining());
    if (fast) {
        const std::uint64_t size = block_size(tiling(id.level).tiles[id.tile], id.level) * components_of(id.channel);
        if (!is_packed_planes(planes, static_cast<std::size_t>(size), front.top_plane, low))
            return malformed("packed planes are damaged");
    }
    std::unique_ptr<Block>& place = block(id, id.level);
    if (!place) {
        place = std::make_unique<Block>(components_of(id.channel));
        --blocks_left_;
    }
    place->plane = *lowest;
    place->cut = !whole;
    queue_.emplace(id, Queued{front.top_plane, {planes.begin(), planes.end()}});
    if (const std::size_t kind = *kind_of(id.channel); kind > 0) {
        attributes_[kind - 1].ensure(vertex_count(id.level), vertex_count(0));
    } else {
        ensure_coefficients(id.level);
        mark_changed(id);
    }
    return true;
}

std::optional<std::size_t> PartDecoder::kind_of(Channel channel) const {
    if (channel == Channel::Geometry) return 0;
    for (std::size_t k = 0; k < attributes_.size(); ++k)
        if (attributes_[k].params().channel == channel) return k + 1;
    return {};
}

unsigned PartDecoder::components_of(Channel channel) const {
    const std::size_t kind = *kind_of(channel);
    return kind > 0 ? attributes_[kind - 1].params().components() : 3;
}

std::vector<std::span<const Vec3f>> PartDecoder::coefficients() {
    settle();
    std::vector<std::span<const Vec3f>> all{coefficients_};
    for (const AttributeDecoder& a : attributes_)
        for (const std::vector<Vec3f>& values : a.coefficients()) all.emplace_back(values);
    return all;
}

/// Calls visit(id, queued) for the tile's chunks in the queue, level by level: parents first.
template <typename Visit>
void PartDecoder::visit_queue(std::uint32_t tile, Visit visit) {
    for (unsigned channel = 1; channel <= static_cast<unsigned>(Channel::LastField); ++channel) {
        const ChunkId first{static_cast<std::uint16_t>(channel), static_cast<std::uint16_t>(tile), 0, 0, Channel::Base};
        for (auto it = queue_.lower_bound(first);
             it != queue_.end() && it->first.part == first.part && it->first.tile == first.tile; ++it)
            visit(it->first, it->second);
    }
}

/// Tiles do not look at one another, and the transforms' tables at none of them.
void PartDecoder::settle(unsigned level, Tasks besides) {
    std::vector<std::uint32_t> tiles;
    for (const auto& [id, queued] : queue_) tiles.push_back(id.tile);
    std::sort(tiles.begin(), tiles.end());
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
    Tasks tasks;
    std::atomic<std::size_t> tables_left = 0;
    if (needs_transform(level)) {
        transform_.reset();  // memory
        if (!tables_) tables_ = std::make_shared<TransformTables>(base_->mesh, base_->params.transform, base_->creases);
        const std::size_t jobs = tables_->jobs(level);
        for (std::size_t job = 0; job < jobs; ++job)
            tasks.emplace_back([this, job, level, &tables_left] {
                tables_->make(job);
                if (--tables_left == 0) make_transform(level);
            });
        tables_left = jobs;
        if (jobs == 0) tasks.emplace_back([this, level] { make_transform(level); });
    }
    if (needs_attribute_transform(level)) {
        attribute_transform_.reset();
        if (!attribute_tables_)
            attribute_tables_ = std::make_shared<TransformTables>(base_->mesh, kAttributeTransform,
                                                                  attribute_creases(base_->mesh, base_->materials));
        const std::size_t jobs = attribute_tables_->jobs(level);
        for (std::size_t job = 0; job < jobs; ++job) tasks.emplace_back([this, job] { attribute_tables_->make(job); });
    }
    for (const std::uint32_t tile : tiles) tasks.emplace_back([this, tile] { settle_tile(tile); });
    std::move(besides.begin(), besides.end(), std::back_inserter(tasks));
    std::atomic<std::size_t> next = 0;
    const auto work = [&](unsigned) {
        for (std::size_t at = next++; at < tasks.size(); at = next++) tasks[at]();
    };
    if (tasks.size() <= 1)
        work(0);
    else
        workers_.run(work);
    queue_.clear();
}

void PartDecoder::settle_tile(std::uint32_t tile) {
    Bytes raw;
    visit_queue(tile, [&](const ChunkId& id, const Queued& queued) { decode_planes(id, queued, raw); });
    visit_queue(tile, [&](const ChunkId& id, const Queued&) {
        Block& here = *block(id, id.level);
        if (!here.changed) return;
        here.changed = false;
        store_values(id, here);
        if (here.plane == 0) here.shape.reset();
    });
}

void PartDecoder::decode_planes(const ChunkId& id, const Queued& queued, Bytes& raw) {
    Block& here = *block(id, id.level);
    here.changed = true;
    const unsigned low = lowest_plane_of(id);
    if (base_->params.fast) {
        const auto size = static_cast<std::size_t>(block_size(tiling(id.level).tiles[id.tile], id.level));
        if (unzip_planes(queued.planes, size * components_of(id.channel), queued.top, low, raw))
            (void)here.decoder.unpack(size, queued.top, low, raw).ok();
        return;
    }
    if (!here.shape) here.shape = std::make_unique<BlockShape>(base_->mesh, tiling(id.level), id.tile, id.level);
    const BlockDecoder* parent = nullptr;
    if (has_parents(id.level) && block(id, id.level - 1u)) parent = &block(id, id.level - 1u)->decoder;
    ByteReader in(queued.planes);
    const bool cut = here.cut && low <= here.plane;  // the block's last chunk: what is behind is not there
    for (unsigned plane = queued.top + 1; plane-- > std::max(low, here.plane);) {
        const std::uint64_t length = plane == low ? in.remaining() : in.varint();
        const bool all_there = length <= in.remaining() && !(cut && plane == low);
        const auto bytes = static_cast<std::size_t>(std::min<std::uint64_t>(length, in.remaining()));
        (void)here.decoder.decode_plane(*here.shape, parent, plane, in.bytes(bytes), all_there).ok();
    }
}

void PartDecoder::retry_waiting(Channel channel, std::uint16_t tile, unsigned level) {
    const auto part = static_cast<std::uint16_t>(channel);
    // One block's next chunk at a time; a decoded one may free the next of its own block and those one level finer.
    std::vector<unsigned> levels = {level};
    while (!levels.empty()) {
        const unsigned at = levels.back();
        levels.pop_back();
        const auto it = waiting_.lower_bound(ChunkId{part, tile, static_cast<std::uint8_t>(at), 0, Channel::Base});
        if (it == waiting_.end() || it->first.part != part || it->first.tile != tile || it->first.level != at) continue;
        const auto node = waiting_.extract(it);
        const Result<Taken> taken = take_planes(node.key(), node.mapped(), true);
        if (taken.ok() && *taken == Taken::Waits) continue;
        levels.push_back(at);
        if (taken.ok() && *taken == Taken::Used && at < finest_) levels.push_back(at + 1);
    }
}

void PartDecoder::ensure_coefficients(unsigned level) {
    const std::uint64_t V = vertices_at_level(base_->mesh, level);
    if (coefficients_.size() < V) coefficients_.resize(V);
    if (base_->params.lossless && integers_.size() < V) integers_.resize(V);
}

/// Of one block: tiles do this side by side.
void PartDecoder::store_values(const ChunkId& id, const Block& block) {
    const BlockDecoder& from = block.decoder;
    if (!from.started()) return;
    if (const std::size_t kind = *kind_of(id.channel); kind > 0) return store_attribute(kind, id, from);
    if (base_->params.lossless) return store_integers(id, from);
    const float reconstruction = base_->params.reconstruction_point();
    std::size_t place = 0;
    // A run lies along one edge or inside one face, so it has the same steps all along.
    for (const BlockRun& run : block_runs(base_->mesh, tiling(id.level).tiles[id.tile], id.level)) {
        const Vec3f steps = units_.steps(id.level, run.vertex);
        Vec3f* const to = &coefficients_[run.vertex];
        from.values(reconstruction, std::array{steps.x, steps.y, steps.z}, place, {&to->x, std::size_t{3} * run.count});
        if (id.level == 0) *to = units_.origin(run.vertex) + units_.frame(run.vertex).to_model(*to);
        place += run.count;
    }
}

void PartDecoder::store_attribute(std::size_t kind, const ChunkId& id, const BlockDecoder& from) {
    const unsigned components = components_of(id.channel);
    const std::vector<std::uint32_t> indices = block_indices(base_->mesh, tiling(id.level).tiles[id.tile], id.level);
    std::vector<float> values(indices.size() * components);
    from.values(base_->params.reconstruction_point(), std::span(kOnes).first(components), 0, values);
    attributes_[kind - 1].store(indices, id.level, values);
}

/// Exact once plane 0 has come; before, the middle of what is open.
void PartDecoder::store_integers(const ChunkId& id, const BlockDecoder& from) {
    const std::vector<std::uint32_t> indices = block_indices(base_->mesh, tiling(id.level).tiles[id.tile], id.level);
    std::vector<float> values(indices.size() * 3);
    from.values(base_->params.reconstruction_point(), std::span(kOnes).first(3), 0, values);
    std::vector<std::int32_t> exact(from.lowest_plane() == 0 ? values.size() : 0);
    if (!exact.empty()) from.integers(exact);
    const auto grid = static_cast<float>(base_->params.lattice.unit());
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const std::uint32_t v = indices[i];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t at = 3 * i + k;
            const std::int32_t value = exact.empty() ? static_cast<std::int32_t>(values[at]) : exact[at];
            integers_[v][k] = value;
            coefficients_[v][k] = static_cast<float>(value) * grid;
        }
    }
}

void PartDecoder::append_attributes(unsigned level, std::size_t first_vertex, std::size_t first_face, Mesh& out) {
    for (AttributeDecoder& attribute : attributes_) {
        attribute.ensure(vertex_count(level), vertex_count(0));
        if (needs_attribute_transform(level)) {
            attribute_transform_ = std::make_unique<PatchTransform>(attribute_tables_, level);
            attribute_levels_ = level;
        }
        attribute.append(*attribute_transform_, level, first_vertex, first_face, out);
    }
    pad_vertex_data(out);
}

/// center + diagonal * p.
void PartDecoder::place_positions(unsigned level, const Vec3& center, double diagonal, std::span<Vec3> out) {
    const std::size_t V = out.size();
    const auto place = [&](std::size_t v, const Vec3& p) { out[v] = center + p * diagonal; };
    if (base_->params.lossless) {
        std::vector<IntegerPoint> points(integers_.begin(), integers_.begin() + static_cast<std::ptrdiff_t>(V));
        synthesize_integers(base_->mesh, level, base_->creases, points);
        const double grid = base_->params.lattice.unit();
        for (std::size_t v = 0; v < V; ++v) {
            const IntegerPoint& p = points[v];
            place(v, Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])} * grid);
        }
        return;
    }
    if (level > 0) synthesize(level);
    const std::vector<Vec3f>& surface = level > 0 ? surface_ : coefficients_;
    for (std::size_t v = 0; v < V; ++v) place(v, to_double(surface[v]));
}

void PartDecoder::mark_changed(const ChunkId& id) {
    changed_level_ = std::min<unsigned>(changed_level_, id.level);
    if (id.level >= info_.first_tiled_level)
        changed_tiles_[id.tile] = 1;
    else
        std::fill(changed_tiles_.begin(), changed_tiles_.end(), std::uint8_t{1});
}

std::vector<std::uint32_t> PartDecoder::changed_faces() const {
    std::vector<std::uint32_t> faces;
    for (std::size_t tile = 0; tile < changed_tiles_.size(); ++tile)
        if (changed_tiles_[tile] != 0)
            faces.insert(faces.end(), tiling_.tiles[tile].faces.begin(), tiling_.tiles[tile].faces.end());
    return faces;
}

bool PartDecoder::needs_transform(unsigned level) const {
    if (!base_ || level == 0 || base_->params.lossless) return false;
    if (flat_) return false;
    const bool again = surface_.size() == vertex_count(level);
    if (again && changed_level_ > level) return false;
    return !transform_ || transform_levels_ < level || (again && !updates_);
}

bool PartDecoder::needs_attribute_transform(unsigned level) const {
    return base_ && !attributes_.empty() && (!attribute_transform_ || attribute_levels_ < level);
}

/// One that can update from the second mesh asked for.
void PartDecoder::make_transform(unsigned level) {
    const std::size_t V = vertex_count(level);
    updates_ = surface_.size() == V;
    transform_levels_ = level;
    transform_ = std::make_unique<PatchTransform>(tables_, level, V < kWorthThreads ? 1 : workers_.count(), updates_);
    changed_level_ = 0;
}

/// The surface of facets without details.
void PartDecoder::lay_flat(unsigned level) {
    std::vector<std::uint32_t> patch;
    const std::uint32_t n = 1u << level;
    const float step = 1 / static_cast<float>(n);
    for (std::uint32_t f = 0; f < base_->mesh.face_count(); ++f) {
        const Face& face = base_->mesh.faces()[f];
        const Vec3f &a = coefficients_[face[0]], &b = coefficients_[face[1]], &c = coefficients_[face[2]];
        patch_vertices(base_->mesh, f, level, patch);
        for (std::uint32_t i = 0; i <= n; ++i)
            for (std::uint32_t k = 0; i + k <= n; ++k)
                surface_[patch[patch_place(n, i, k)]] =
                    (a * static_cast<float>(n - i - k) + b * static_cast<float>(i) + c * static_cast<float>(k)) * step;
    }
}

/// Brings surface_ up to date, once settle(level) has made the transform.
void PartDecoder::synthesize(unsigned level) {
    const std::size_t V = vertex_count(level);
    const bool again = surface_.size() == V;
    if (again && changed_level_ > level) return;
    const std::span<const Vec3f> coefficients = std::span(coefficients_).first(V);
    surface_.resize(V);
    if (flat_)
        lay_flat(level);
    else if (again)
        transform_->update(coefficients, changed_faces(), changed_level_, level, surface_);
    else
        transform_->synthesize(coefficients, level, surface_);
    changed_level_ = kUnchanged;
    std::fill(changed_tiles_.begin(), changed_tiles_.end(), std::uint8_t{0});
}

void PartDecoder::append_mesh(unsigned level, const Vec3& center, double diagonal, Mesh& out) {
    level = std::min(level, finest_);
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    std::vector<Face> faces;
    settle(level, {[&] { faces = triangles_at_level(base_->mesh, level); },
                   [&] { out.positions.resize(first + vertex_count(level)); }});
    ensure_coefficients(level);
    place_positions(level, center, diagonal, std::span(out.positions).subspan(first));
    const std::size_t face_count = faces.size();
    if (out.faces.empty())
        out.faces = std::move(faces);
    else
        for (const Face& f : faces) out.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    append_attributes(level, first, out.faces.size() - face_count, out);
    if (!base_->materials.empty() || !out.materials.empty()) {
        out.materials.resize(out.faces.size() - face_count, 0);
        for (std::size_t f = 0; f < face_count; ++f)
            out.materials.push_back(base_->materials.empty() ? 0 : base_->materials[f >> (2 * level)]);
    }
}

}  // namespace mvw
