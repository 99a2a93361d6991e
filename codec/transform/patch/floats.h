// Buffers of floats that start at a cache line: the vectors of a group of eight patches then never straddle two.
#pragma once
#include <cstddef>
#include <vector>

namespace mvw {

/// Zero at first.
class Floats {
 public:
    Floats() = default;
    explicit Floats(std::size_t count) : lines_((count + kLine - 1) / kLine), size_(count) {}

    [[nodiscard]] float* data() { return lines_.empty() ? nullptr : lines_.front().values; }
    [[nodiscard]] const float* data() const { return lines_.empty() ? nullptr : lines_.front().values; }
    [[nodiscard]] std::size_t size() const { return size_; }

 private:
    static constexpr std::size_t kLine = 16;
    struct alignas(64) Line {
        float values[kLine] = {};
    };
    std::vector<Line> lines_;
    std::size_t size_ = 0;
};

}  // namespace mvw
