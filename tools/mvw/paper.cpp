// mvw paper: the paper's tables and figures, recomputed.
#include "tools/paper/paper.h"

#include <fmt/core.h>

#include <cstdlib>
#include <memory>

#include "tools/mvw/commands.h"

namespace mvw::cli {

void add_paper(CLI::App& app) {
    auto options = std::make_shared<paper::PaperOptions>();
    CLI::App* command = app.add_subcommand("paper", "Recomputes the paper's tables and figures as a page");
    command->footer(
        "Example: mvw paper --out paper --models scans\n"
        "Writes index.html with its pictures and plots, and paper.json with every number.");
    command->add_option("--out", options->out, "Folder for the page")->required();
    command
        ->add_option(
            "--models", options->models,
            "Folder with lucy.ply, koala.ply, skull.ply and sr_bunny_oct7.ply; shapes by formula where not given")
        ->envname("MVW_MODELS");
    command->add_option("--levels", options->levels, "Levels of each model; the paper's are 5")
        ->check(CLI::Range(2u, 6u))
        ->capture_default_str();
    command->callback([options] {
        options->say = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
        if (const auto done = paper::write_paper(*options); !done.ok()) throw Fatal{kFailure, done.error().message};
    });
}

}  // namespace mvw::cli
