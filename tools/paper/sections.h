// The page's sections: each runs its experiment, writes its figures, and tells how ours stands to the paper's.
#pragma once
#include "tools/paper/models.h"
#include "tools/paper/page.h"

namespace mvw::paper {

/// Table 1: lifting weights, computed in several ways.
void add_weights(Page& page);
/// Table 2: time of 5 analyses and 5 syntheses, the fast transform and its predecessor with both components.
void add_timing(Page& page, const std::vector<Model>& models);
/// Figures 7 and 8: noise filtering.
Result<void> add_noise(Page& page, const std::vector<Model>& models);
/// Figures 6 and 9: models at all levels; interpolatory against Loop's wavelets after all but one analyses.
Result<void> add_levels(Page& page, const std::vector<Model>& models);
/// Beyond the paper: entropy and surface error of every transform.
Result<void> add_coding(Page& page, const std::vector<Model>& models);

}  // namespace mvw::paper
