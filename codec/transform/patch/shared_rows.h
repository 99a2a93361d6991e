// Rows of numbers that are often alike, and by which many things can be told apart.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace mvw {

/// Rows of numbers, each kept once.
class SharedRows {
 public:
    explicit SharedRows(std::vector<float>& kept) : kept_(kept) {}
    SharedRows(const SharedRows&) = delete;
    SharedRows& operator=(const SharedRows&) = delete;
    /// Where the row begins among those kept.
    std::uint32_t place(std::span<const float> row) {
        const auto known = rows_.find(row);
        if (known != rows_.end()) return known->first;
        const Row added{static_cast<std::uint32_t>(kept_.size()), static_cast<std::uint32_t>(row.size())};
        kept_.insert(kept_.end(), row.begin(), row.end());
        rows_.insert(added);
        return added.first;
    }

 private:
    struct Row {
        std::uint32_t first, count;
    };
    [[nodiscard]] std::span<const float> values(const Row& row) const {
        return std::span(kept_).subspan(row.first, row.count);
    }
    [[nodiscard]] std::span<const float> values(std::span<const float> row) const { return row; }
    [[nodiscard]] std::string_view bytes(const auto& row) const {
        const std::span<const float> of = values(row);
        return {reinterpret_cast<const char*>(of.data()), of.size_bytes()};
    }
    struct Hash {
        using is_transparent = void;
        const SharedRows* rows;
        std::size_t operator()(const auto& row) const { return std::hash<std::string_view>{}(rows->bytes(row)); }
    };
    struct Equal {
        using is_transparent = void;
        const SharedRows* rows;
        bool operator()(const auto& a, const auto& b) const { return rows->bytes(a) == rows->bytes(b); }
    };

    std::vector<float>& kept_;
    std::unordered_set<Row, Hash, Equal> rows_{0, Hash{this}, Equal{this}};
};

}  // namespace mvw
