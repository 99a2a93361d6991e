#include "codec/transform/transform.h"

#include <array>

namespace mvw {

namespace {

constexpr std::array<std::string_view, kTransformCount> kNames{
    "interp",         "interp-lazy", "vector",      "loop",          "loop-lazy",         "butterfly",
    "butterfly-lazy", "seeded",      "seeded-lazy", "seeded-normal", "seeded-normal-lazy"};

}  // namespace

std::string_view transform_name(TransformKind kind) {
    return kNames[static_cast<std::size_t>(kind)];
}

std::vector<std::string> transform_names() {
    return {kNames.begin(), kNames.end()};
}

std::optional<TransformKind> transform_from_name(std::string_view name) {
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (kNames[i] == name) return static_cast<TransformKind>(i);
    return std::nullopt;
}

}  // namespace mvw
