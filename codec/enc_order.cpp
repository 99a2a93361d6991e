#include "codec/enc_order.h"

#include <algorithm>
#include <cassert>
#include <numeric>
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
    bool sent = false;

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
        return run.bytes < kHeadBytes + std::clamp(share, fewest, most);
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

class Orderer {
 public:
    Orderer(const std::vector<CodedPart>& parts, const OrderOptions& options)
        : parts_(parts), options_(options), described_(parts.size(), 0) {
        error_ = options.floor;
        const std::vector<double> before = bytes_before_planes(parts, options.layers);
        for (std::size_t part = 0; part < parts.size(); ++part) {
            error_ += parts[part].rounding * options.area_share[part];
            runs_.emplace_back();
            for (std::size_t b = 0; b < parts[part].blocks.size(); ++b) {
                runs_.back().push_back(runs_of(parts[part].blocks[b], part, b, before, options));
                for (const Run& run : runs_.back().back()) error_ += surface_gain(run);
            }
        }
    }

    std::vector<PlannedChunk> run() {
        send_bases();
        std::vector<Run*> order;
        for (auto& blocks : runs_)
            for (auto& runs : blocks)
                for (Run& run : runs) order.push_back(&run);
        std::stable_sort(order.begin(), order.end(),
                         [](const Run* a, const Run* b) { return a->slope() > b->slope(); });
        for (Run* run : order) send(*run);
        for (std::size_t part = 0; part < parts_.size(); ++part)  // such as need no coefficients
            if (!parts_[part].attributes.empty()) describe_attributes(part);
        return std::move(out_);
    }

 private:
    void send_bases() {
        std::vector<std::size_t> order(parts_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return parts_[a].base.bytes.size() < parts_[b].base.bytes.size();
        });
        for (const std::size_t part : order) {
            PlannedChunk& chunk = out_.emplace_back();
            chunk.id.part = static_cast<std::uint16_t>(part);
            chunk.payload = write_base(parts_[part].base, parts_[part].mesh, parts_[part].params);
            chunk.error = error_;
        }
    }

    [[nodiscard]] const CodedBlock& block_of(const Run& run) const { return parts_[run.part].blocks[run.block]; }
    /// What a run lowers the surface error by: attributes leave it as it is.
    [[nodiscard]] double surface_gain(const Run& run) const {
        return block_of(run).channel == Channel::Geometry ? run.gain : 0;
    }
    [[nodiscard]] unsigned lowest_plane(const Run& run) const { return block_of(run).planes.planes[run.last].plane; }

    /// The run, behind what it builds on: higher planes of its block, and those of the parent above its lowest plane.
    void send(Run& run) {
        if (run.sent) return;
        run.sent = true;
        for (Run& earlier : runs_[run.part][run.block])
            if (earlier.last < run.first) send(earlier);
        const CodedBlock& block = block_of(run);
        bool needs_parent = false;
        if (has_parents(parts_[run.part], block.level))
            for (Run& above : runs_[run.part][run.block - 1])
                if (block_of(above).planes.planes[above.first].plane > lowest_plane(run)) {
                    needs_parent = true;
                    send(above);
                }
        write(run, needs_parent);
    }

    /// What a part's attributes are comes before the first chunk of one.
    void describe_attributes(std::size_t part) {
        if (std::exchange(described_[part], std::uint8_t{1}) != 0) return;
        PlannedChunk& chunk = out_.emplace_back();
        chunk.id.part = static_cast<std::uint16_t>(part);
        chunk.id.channel = Channel::Attributes;
        chunk.payload = write_attributes(parts_[part].attributes);
        chunk.error = std::max(error_, 0.0);
    }

    void write(const Run& run, bool needs_parent) {
        const CodedBlock& block = block_of(run);
        if (block.channel != Channel::Geometry) describe_attributes(run.part);
        error_ -= surface_gain(run);
        PlannedChunk& chunk = out_.emplace_back();
        chunk.id = {static_cast<std::uint16_t>(run.part), block.tile, block.level,
                    static_cast<std::uint8_t>(options_.layers - 1 - lowest_plane(run)), block.channel};
        chunk.error = std::max(error_, 0.0);
        ByteWriter out;
        write_geometry_front(out, {0, block.planes.planes[run.first].plane, run.first == 0, needs_parent});
        const CodedPart& part = parts_[run.part];
        if (part.params.fast) {
            out.bytes(pack_planes(block.planes.entries, components_of(part, block.channel),
                                  block.planes.planes[run.first].plane, lowest_plane(run)));
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
    std::vector<std::vector<std::vector<Run>>> runs_;  // part, block
    std::vector<std::uint8_t> described_;              // of each part, once its Attributes chunk is there
    std::vector<PlannedChunk> out_;
    double error_ = 0;
};

}  // namespace

std::vector<PlannedChunk> order_chunks(const std::vector<CodedPart>& parts, const OrderOptions& options) {
    return Orderer(parts, options).run();
}

}  // namespace mvw
