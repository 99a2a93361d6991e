#include "tools/paper/paper.h"

#include <fmt/core.h>

#include <filesystem>

#include "tools/paper/sections.h"

namespace mvw::paper {
namespace {

void introduce(Page& page, const std::vector<Model>& models, bool shapes) {
    page.text(
        "The tables and figures of &ldquo;wavelets by matrix-valued interpolatory Loop subdivision&rdquo;, recomputed "
        "by "
        "<code>mvw paper</code>: every number and picture below comes from that run, and all numbers stand in "
        "<a href=\"paper.json\">paper.json</a>. The paper&rsquo;s own meshes are not public, so ours stand in for "
        "them.");
    std::vector<std::vector<std::string>> rows;
    for (const Model& model : models) {
        const BaseMesh& base = model.mesh.base;
        rows.push_back({model.name, model.origin, std::to_string(base.face_count()), std::to_string(model.mesh.levels),
                        std::to_string(model.mesh.positions.size())});
        page.numbers["models"].push_back({{"name", model.name},
                                          {"origin", model.origin},
                                          {"base_faces", base.face_count()},
                                          {"levels", model.mesh.levels},
                                          {"vertices", model.mesh.positions.size()}});
    }
    page.table("Models", {"", "origin", "base faces", "levels", "vertices"}, rows);
    if (shapes)
        page.text(
            "These are shapes by formula. With <code>--models DIR</code> the experiments run on scans of the "
            "paper&rsquo;s "
            "sizes.");
}

}  // namespace

Result<void> write_paper(const PaperOptions& options) {
    std::error_code failed;
    std::filesystem::create_directories(options.out, failed);
    if (failed) return Error{Errc::Io, 0, options.out + ": " + failed.message()};
    const auto say = [&](const char* what) {
        if (options.say) options.say(what);
    };
    say("models");
    const Result<std::vector<Model>> models = load_models(options.models, options.levels);
    if (!models.ok()) return models.error();
    Page page(options.out, "Wavelets by matrix-valued interpolatory Loop subdivision, recomputed");
    introduce(page, *models, options.models.empty());
    say("table 1");
    add_weights(page);
    say("table 2");
    add_timing(page, *models);
    say("figures 7 and 8");
    if (auto done = add_noise(page, *models); !done.ok()) return done;
    say("figures 6 and 9");
    if (auto done = add_levels(page, *models); !done.ok()) return done;
    say("every transform");
    if (auto done = add_coding(page, *models); !done.ok()) return done;
    return page.save();
}

}  // namespace mvw::paper
