// The paper's evidence, recomputed: tables 1 and 2, figures 6 to 9, and which transform codes best.
// Zhao, Sun, et al.: wavelets by matrix-valued interpolatory Loop subdivision; the claims are quoted beside our
// figures.
#pragma once
#include <functional>
#include <string>

#include "codec/result.h"

namespace mvw::paper {

struct PaperOptions {
    std::string out;      // folder, made where it is not there: index.html, paper.json, pictures and plots
    std::string models;   // folder with lucy.ply, koala.ply, skull.ply, sr_bunny_oct7.ply; "": shapes made here
    unsigned levels = 5;  // the paper's; 2 to 6
    std::function<void(const std::string& line)> say;
};

/// Runs everything. Io where the folder cannot be written, a model not read, or no OpenGL be had for the pictures.
Result<void> write_paper(const PaperOptions& options);

}  // namespace mvw::paper
