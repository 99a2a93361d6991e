// How backs of faces are drawn. Where a surface is folded over itself, as coarse levels are here and there, people want
// to see the front that the fold covers, and not a red speck; insides of open surfaces they want to see as ever.
#pragma once

namespace mvw {

enum class Backs {
    InPlace,     // where they lie: to find folds
    StepBehind,  // kBackStep further away: fronts close behind them are seen, what is far behind is not
    Hidden,      // not at all
};

inline constexpr double kBackStep = 0.005;  // of the model's diagonal; more than most folds are high

/// How the viewers draw a model of that radius (half of its box's diagonal) from an eye so far from its box's middle.
/// From outside, whoever looks along a ray that meets the back of a solid's surface meets a front, too.
/// (codec/mesh/solid.h)
constexpr Backs backs_from_eye(bool solid, double eye_to_middle, double radius) {
    return solid && eye_to_middle > radius ? Backs::Hidden : Backs::StepBehind;
}

}  // namespace mvw
