#include "codec/measure/surface_error.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <limits>
#include <numbers>
#include <thread>
#include <utility>

#include "codec/measure/surface_index.h"
#include "codec/mesh/number_positions.h"

namespace mvw {
namespace {

constexpr std::uint64_t kSeed = 0x6d76772d6d657472;
constexpr std::size_t kBlock = 4096;  // points whose sums are kept together: makes results independent of threads
constexpr double kZero = 1e-14;

/// A uniform number in [0, 1) for each counter (splitmix64: Steele, Lea, Flood 2014).
double uniform(std::uint64_t counter) {
    std::uint64_t z = kSeed + (counter + 1) * 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/// A surface in the frame where distances are fractions of the reference's diagonal.
struct Surface {
    std::vector<Vec3> positions;
    std::vector<Face> faces;
    std::vector<double> area_until;   // running sum of the faces' areas
    std::vector<std::uint32_t> used;  // vertices that faces use, one at each position

    Surface(const Mesh& mesh, const Vec3& center, double diagonal) : faces(mesh.faces) {
        positions.reserve(mesh.positions.size());
        for (const Vec3& p : mesh.positions) positions.push_back((p - center) / diagonal);
        std::vector<std::uint8_t> is_used(positions.size(), 0);
        area_until.reserve(faces.size());
        double total = 0;
        for (std::uint32_t f = 0; f < faces.size(); ++f) {
            area_until.push_back(total += 0.5 * length(area_vector(f)));
            for (const std::uint32_t v : faces[f]) is_used[v] = 1;
        }
        const std::vector<std::uint32_t> number = number_positions(mesh.positions);
        std::vector<std::uint8_t> is_there(number.size(), 0);
        for (std::uint32_t v = 0; v < is_used.size(); ++v)
            if (is_used[v] != 0 && std::exchange(is_there[number[v]], 1) == 0) used.push_back(v);
    }

    [[nodiscard]] Vec3 area_vector(std::uint32_t f) const {
        const Vec3& a = positions[faces[f][0]];
        return cross(positions[faces[f][1]] - a, positions[faces[f][2]] - a);
    }

    /// The face on which area `at` is reached; never one without area. from: a face that does not lie behind it.
    [[nodiscard]] std::uint32_t face_at(double at, std::uint32_t from) const {
        auto it = area_until.begin() + from;
        for (int near = 0; near < 8 && it != area_until.end() && *it <= at; ++near) ++it;
        if (it != area_until.end() && *it <= at) it = std::upper_bound(it, area_until.end(), at);
        if (it == area_until.end()) it = std::lower_bound(area_until.begin(), area_until.end(), area_until.back());
        return static_cast<std::uint32_t>(it - area_until.begin());
    }

    /// Point `i` of `count`, one in each of `count` equal strips of area, uniformly within its face.
    /// face: in, that of an earlier point or 0; out, this one's.
    [[nodiscard]] Vec3 sample(std::size_t i, std::size_t count, std::uint32_t& face) const {
        const double strip = (static_cast<double>(i) + uniform(3 * i)) / static_cast<double>(count);
        face = face_at(strip * area_until.back(), face);
        const double r = std::sqrt(uniform(3 * i + 1)), t = uniform(3 * i + 2);
        const Face& f = faces[face];
        return positions[f[0]] * (1 - r) + positions[f[1]] * (r * (1 - t)) + positions[f[2]] * (r * t);
    }
};

struct Sums {
    double squares = 0, distances = 0, max = 0, degrees = 0;

    void add(double distance) {
        if (distance < kZero) distance = 0;
        squares += distance * distance;
        distances += distance;
        max = std::max(max, distance);
    }
    void add(const Sums& o) {
        squares += o.squares;
        distances += o.distances;
        max = std::max(max, o.max);
        degrees += o.degrees;
    }
};

double angle_degrees(const Vec3& a, const Vec3& b) {
    return std::atan2(length(cross(a, b)), dot(a, b)) * (180 / std::numbers::pi);
}

/// Calls work(block, first, last) for each block of [0, count), on several threads.
template <typename Work>
void for_blocks(std::size_t count, unsigned threads, const Work& work) {
    const std::size_t blocks = (count + kBlock - 1) / kBlock;
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
        for (std::size_t b = next++; b < blocks; b = next++) work(b, b * kBlock, std::min(count, (b + 1) * kBlock));
    };
    if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> helpers;
    for (unsigned t = 1; t < threads && t < blocks; ++t) helpers.emplace_back(run);
    run();
    for (std::thread& t : helpers) t.join();
}

std::size_t points_of(const Surface& surface, const SurfaceErrorOptions& options) {
    return options.samples + (surface.used.size() + options.vertex_stride - 1) / options.vertex_stride;
}

/// Sums over the distances of points on `from` (samples, then its vertices) to `to`, which `index` is of.
Sums one_way(const Surface& from, const Surface& to, const SurfaceIndex& index, const SurfaceErrorOptions& options) {
    const std::size_t samples = options.samples, points = points_of(from, options);
    std::vector<Sums> partial((points + kBlock - 1) / kBlock);
    for_blocks(points, options.threads, [&](std::size_t block, std::size_t first, std::size_t last) {
        std::uint32_t near_face = kNone, face = 0;
        for (std::size_t i = first; i < last; ++i) {
            const Vec3 p = i < samples ? from.sample(i, samples, face)
                                       : from.positions[from.used[(i - samples) * options.vertex_stride]];
            const SurfacePoint hit = index.closest(p, near_face);
            near_face = hit.face;
            partial[block].add(hit.distance);
            if (i < samples) partial[block].degrees += angle_degrees(from.area_vector(face), to.area_vector(hit.face));
        }
    });
    Sums sums;
    for (const Sums& s : partial) sums.add(s);
    return sums;
}

void take_larger(SurfaceError& error, const Sums& sums, std::size_t points, std::uint32_t samples) {
    error.rms = std::max(error.rms, std::sqrt(sums.squares / static_cast<double>(points)));
    error.mean = std::max(error.mean, sums.distances / static_cast<double>(points));
    error.max = std::max(error.max, sums.max);
    if (samples > 0) error.normal_deg = std::max(error.normal_deg, sums.degrees / samples);
}

}  // namespace

bool measurable(const Mesh& mesh) {
    const Box box = bounding_box(mesh);
    const double diagonal = box.diagonal();
    if (!(diagonal > 0) || !std::isfinite(diagonal)) return false;
    return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const Face& f) {
        const Vec3 a = (mesh.positions[f[0]] - box.min) / diagonal;
        return squared_length(cross((mesh.positions[f[1]] - box.min) / diagonal - a,
                                    (mesh.positions[f[2]] - box.min) / diagonal - a)) > 0;
    });
}

struct ReferenceSurface::State {
    Vec3 center;
    double diagonal;
    Surface surface;
    SurfaceIndex index;

    State(const Mesh& mesh, const Box& box, unsigned threads)
        : center(box.center()),
          diagonal(box.diagonal()),
          surface(mesh, center, diagonal),
          index(surface.positions, surface.faces, threads) {}
};

ReferenceSurface::ReferenceSurface(const Mesh& mesh, unsigned threads)
    : state_(std::make_unique<State>(mesh, bounding_box(mesh), threads)) {
    assert(measurable(mesh));
}
ReferenceSurface::~ReferenceSurface() = default;
ReferenceSurface::ReferenceSurface(ReferenceSurface&&) noexcept = default;
ReferenceSurface& ReferenceSurface::operator=(ReferenceSurface&&) noexcept = default;

SurfaceError ReferenceSurface::error_of(const Mesh& other, const SurfaceErrorOptions& options) const {
    assert(measurable(other));
    const Surface &a = state_->surface, b(other, state_->center, state_->diagonal);
    const SurfaceIndex index(b.positions, b.faces, options.threads);
    SurfaceError error;
    take_larger(error, one_way(a, b, index, options), points_of(a, options), options.samples);
    take_larger(error, one_way(b, a, state_->index, options), points_of(b, options), options.samples);
    error.psnr = error.rms > 0 ? -20 * std::log10(error.rms) : std::numeric_limits<double>::infinity();
    return error;
}

SurfacePoint ReferenceSurface::closest(const Vec3& p, std::uint32_t near_face) const {
    const State& s = *state_;
    SurfacePoint hit = s.index.closest((p - s.center) / s.diagonal, near_face);
    hit.point = hit.point * s.diagonal + s.center;
    hit.distance *= s.diagonal;
    return hit;
}

SurfaceError surface_error(const Mesh& reference, const Mesh& other, const SurfaceErrorOptions& options) {
    return ReferenceSurface(reference, options.threads).error_of(other, options);
}

std::vector<double> vertex_errors(const Mesh& reference, std::span<const Vec3> positions, unsigned threads) {
    assert(measurable(reference));
    const double diagonal = bounding_box(reference).diagonal();
    const SurfaceIndex index(reference.positions, reference.faces, threads);
    std::vector<double> errors(positions.size());
    for_blocks(positions.size(), threads, [&](std::size_t, std::size_t first, std::size_t last) {
        std::uint32_t near_face = kNone;
        for (std::size_t i = first; i < last; ++i) {
            const SurfacePoint hit = index.closest(positions[i], near_face);
            near_face = hit.face;
            errors[i] = hit.distance / diagonal;
        }
    });
    return errors;
}

}  // namespace mvw
