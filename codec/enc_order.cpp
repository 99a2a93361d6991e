#include "codec/enc_order.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "codec/enc_attributes.h"
#include "codec/entropy/packed_planes.h"

namespace mvw {

namespace {

constexpr double kHeadBytes = 6;
constexpr double kFewestBytes = 64;  // of a chunk, however early in the file

/// Consecutive planes [first, last] of one block.
struct Run {
    std::size_t part, block, first, last;
    double bytes = kHeadBytes, gain = 0;

    [[nodiscard]] double slope() const { return gain / bytes; }
};

Run joined(const Run& a, const Run& b) {
    return {a.part, a.block, a.first, b.last, a.bytes + b.bytes - kHeadBytes, a.gain + b.gain};
}

/// Bytes of all planes above each one, of all blocks, and of the bases: about where in the file a plane comes to lie.
std::vector<double> bytes_before_planes(const std::vector<CodedPart>& parts, unsigned layers) {
    assert(layers > 0);
    std::vector<double> before(layers, 0);
    for (const CodedPart& part : parts) {
        before[layers - 1] += static_cast<double>(part.base.bytes.size());
        for (const CodedBlock& block : part.blocks)
            for (const auto& plane : block.planes.planes)
                if (plane.plane > 0) before[plane.plane - 1] += static_cast<double>(plane.bytes.size());
    }
    for (unsigned plane = layers - 1; plane-- > 0;) before[plane] += before[plane + 1];
    return before;
}

/// Runs of a block: few bytes each early in the file, more later on; slopes falling from one to the next. before: as
/// bytes_before_planes() says.
std::vector<Run> runs_of(const CodedBlock& block, std::size_t part, std::size_t index,
                         const std::vector<double>& before, const OrderOptions& options) {
    std::vector<Run> runs;
    const double most = options.least_bytes, fewest = std::min(kFewestBytes, most);
    const auto is_short = [&](const Run& run) {
        const double share = options.least_share * before[block.planes.planes[run.first].plane];
        return run.last - run.first + 1 < options.least_planes ||
               run.bytes < kHeadBytes + std::clamp(share, fewest, most);
    };
    for (std::size_t p = 0; p < block.planes.planes.size(); ++p) {
        Run run{part, index, p, p};
        run.bytes += static_cast<double>(block.planes.planes[p].bytes.size());
        run.gain = block.gain[p] * options.area_share[part];
        if (!runs.empty() && is_short(runs.back())) {
            runs.back() = joined(runs.back(), run);
        } else {
            runs.push_back(run);
        }
        while (runs.size() > 1 && (runs.back().slope() >= runs[runs.size() - 2].slope() ||
                                   (p + 1 == block.planes.planes.size() && is_short(runs.back())))) {
            runs[runs.size() - 2] = joined(runs[runs.size() - 2], runs.back());
            runs.pop_back();
        }
    }
    return runs;
}

/// Makes chunks of coded parts, in no particular order but for the bases.
class Planner {
 public:
    Planner(const std::vector<CodedPart>& parts, const OrderOptions& options) : parts_(parts), options_(options) {}

    std::vector<PlannedChunk> run() {
        add_bases();
        const std::vector<double> before = bytes_before_planes(parts_, options_.layers);
        double error = options_.floor;
        for (std::size_t part = 0; part < parts_.size(); ++part) {
            error += parts_[part].rounding * options_.area_share[part];
            if (!parts_[part].attributes.empty()) describe_attributes(part);
            for (std::size_t b = 0; b < parts_[part].blocks.size(); ++b)
                for (const Run& run : runs_of(parts_[part].blocks[b], part, b, before, options_)) {
                    add(run);
                    if (out_.back().id.channel == Channel::Geometry) error += run.gain;
                }
        }
        for (std::size_t part = 0; part < parts_.size(); ++part) out_[part].error = error;
        return std::move(out_);
    }

 private:
    void add_bases() {
        std::vector<std::size_t> order(parts_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return parts_[a].base.bytes.size() < parts_[b].base.bytes.size();
        });
        for (const std::size_t part : order) {
            PlannedChunk& chunk = out_.emplace_back();
            chunk.id.part = static_cast<std::uint16_t>(part);
            chunk.payload = write_base(parts_[part].base, parts_[part].mesh, parts_[part].params);
        }
    }

    /// What a part's attributes are.
    void describe_attributes(std::size_t part) {
        PlannedChunk& chunk = out_.emplace_back();
        chunk.id.part = static_cast<std::uint16_t>(part);
        chunk.id.channel = Channel::Attributes;
        chunk.payload = write_attributes(parts_[part].attributes);
    }

    /// Whether planes down to `lowest` are coded in sight of planes of the level above.
    [[nodiscard]] static bool needs_parent(const CodedPart& part, std::size_t block, unsigned lowest) {
        if (!has_parents(part, part.blocks[block].level)) return false;
        const auto& above = part.blocks[block - 1].planes.planes;
        return !above.empty() && above.front().plane > lowest;
    }

    void add(const Run& run) {
        const CodedPart& part = parts_[run.part];
        const CodedBlock& block = part.blocks[run.block];
        PlannedChunk& chunk = out_.emplace_back();
        chunk.top_plane = block.planes.planes[run.first].plane;
        chunk.lowest_plane = block.planes.planes[run.last].plane;
        chunk.needs_parent = needs_parent(part, run.block, chunk.lowest_plane);
        chunk.gain = run.gain;
        chunk.id = {static_cast<std::uint16_t>(run.part), block.tile, block.level,
                    static_cast<std::uint8_t>(options_.layers - 1 - chunk.lowest_plane), block.channel};
        ByteWriter out;
        write_geometry_front(out, {0, chunk.top_plane, run.first == 0, chunk.needs_parent});
        if (part.params.fast) {
            out.bytes(pack_planes(block.planes.entries, components_of(part, block.channel), chunk.top_plane,
                                  chunk.lowest_plane));
        }
        for (std::size_t p = run.first; p <= run.last && !part.params.fast; ++p) {
            const Bytes& bytes = block.planes.planes[p].bytes;
            if (p < run.last) out.varint(bytes.size());
            out.bytes(bytes);
        }
        chunk.payload = out.take();
    }

    const std::vector<CodedPart>& parts_;
    const OrderOptions& options_;
    std::vector<PlannedChunk> out_;
};

/// Sends chunks by falling slope, each behind what it builds on.
class Sorter {
 public:
    explicit Sorter(std::vector<PlannedChunk>& plan) : plan_(plan), sent_(plan.size(), 0) {
        for (std::size_t i = 0; i < plan.size(); ++i) blocks_[block_of(plan[i].id, plan[i].id.level)].push_back(i);
        for (auto& [block, chunks] : blocks_)
            std::ranges::sort(chunks, {}, [&](std::size_t i) { return plan[i].id.layer; });
    }

    std::vector<PlannedChunk> run() {
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t i = 0; i < plan_.size(); ++i) {
            if (plan_[i].id.channel == Channel::Base)
                send(i);
            else
                order.emplace_back(plan_[i].gain / (kHeadBytes + static_cast<double>(plan_[i].payload.size())), i);
        }
        std::ranges::stable_sort(order, std::ranges::greater{}, &std::pair<double, std::size_t>::first);
        for (const auto& [slope, i] : order) send(i);
        return std::move(out_);
    }

 private:
    using Block = std::tuple<std::uint16_t, Channel, std::uint16_t, unsigned>;
    static Block block_of(const ChunkId& id, unsigned level) { return {id.part, id.channel, id.tile, level}; }

    /// A block's chunks as long as they are `wanted`.
    template <typename Wanted>
    void send_first(const Block& block, Wanted wanted) {
        for (const std::size_t i : blocks_[block]) {
            if (!wanted(plan_[i])) return;
            send(i);
        }
    }

    void send(std::size_t i) {
        if (std::exchange(sent_[i], std::uint8_t{1}) != 0) return;
        const ChunkId id = plan_[i].id;
        const unsigned lowest = plan_[i].lowest_plane;
        const auto any = [](const PlannedChunk&) { return true; };
        if (id.channel == Channel::Color || (id.channel >= Channel::FirstField && id.channel <= Channel::LastField))
            send_first({id.part, Channel::Attributes, 0, 0}, any);
        send_first(block_of(id, id.level), [&](const PlannedChunk& c) { return c.lowest_plane > lowest; });
        if (plan_[i].needs_parent)
            send_first(block_of(id, id.level - 1u), [&](const PlannedChunk& c) { return c.top_plane > lowest; });
        out_.push_back(std::move(plan_[i]));
    }

    std::vector<PlannedChunk>& plan_;
    std::map<Block, std::vector<std::size_t>> blocks_;  // layers rising
    std::vector<std::uint8_t> sent_;
    std::vector<PlannedChunk> out_;
};

}  // namespace

unsigned layers_of(const std::vector<CodedPart>& parts) {
    unsigned layers = 1;
    for (const CodedPart& part : parts)
        for (const CodedBlock& block : part.blocks)
            if (!block.planes.planes.empty()) layers = std::max(layers, block.planes.planes.front().plane + 1);
    return layers;
}

std::vector<PlannedChunk> order_chunks(const std::vector<CodedPart>& parts, const OrderOptions& options) {
    std::vector<PlannedChunk> plan = Planner(parts, options).run();
    sort_chunks(plan);
    return plan;
}

PlannedChunk join_chunks(const PlannedChunk& first, const PlannedChunk& second) {
    PlannedChunk out = second;
    out.top_plane = first.top_plane;
    out.needs_parent = first.needs_parent || second.needs_parent;
    out.gain = first.gain + second.gain;
    ByteReader planes(first.payload), more(second.payload);
    GeometryFront front = read_geometry_front(planes);
    (void)read_geometry_front(more);
    front.needs_parent = out.needs_parent;
    ByteWriter payload;
    write_geometry_front(payload, front);
    for (unsigned plane = first.top_plane + 1; plane-- > first.lowest_plane;) {
        const std::uint64_t length = plane > first.lowest_plane ? planes.varint() : planes.remaining();
        payload.varint(length);
        payload.bytes(planes.bytes(static_cast<std::size_t>(length)));
    }
    payload.bytes(more.bytes(more.remaining()));
    out.payload = payload.take();
    return out;
}

PlannedChunk beginning_of(const PlannedChunk& chunk, std::size_t bytes) {
    PlannedChunk out = chunk;
    ByteReader in(chunk.payload);
    GeometryFront front = read_geometry_front(in);
    front.beginning = true;
    const ByteSpan planes = in.bytes(in.remaining());
    out.payload = with_front(front, ByteReader(planes.first(std::min(bytes, planes.size()))));
    return out;
}

std::vector<ChunkToWrite> to_write(const std::vector<PlannedChunk>& plan) {
    std::vector<ChunkToWrite> out;
    out.reserve(plan.size());
    for (const PlannedChunk& c : plan) out.push_back({c.id, c.payload, static_cast<float>(c.error)});
    return out;
}

void sort_chunks(std::vector<PlannedChunk>& plan) {
    if (plan.empty()) return;
    double error = plan.front().error;  // of the bases alone
    plan = Sorter(plan).run();
    for (PlannedChunk& chunk : plan) {
        if (chunk.id.channel == Channel::Geometry) error -= chunk.gain;
        chunk.error = std::max(error, 0.0);
    }
}

}  // namespace mvw
