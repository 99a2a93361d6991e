// mvw compare: surface error between two meshes.
#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "codec/measure/surface_error.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

struct CompareArguments {
    std::string reference, other;
    std::uint32_t samples = SurfaceErrorOptions{}.samples;
    bool json = false;
};

Mesh load_measurable(const std::string& path) {
    Mesh mesh = load_surface(path);
    if (!measurable(mesh)) throw Fatal{kFailure, path + ": nothing to measure: no face of positive area"};
    return mesh;
}

void print_json(const SurfaceError& e) {
    // nlohmann writes what is infinite as null, as cli.md asks.
    const nlohmann::ordered_json json{
        {"rms", e.rms}, {"mean", e.mean}, {"max", e.max}, {"psnr", e.psnr}, {"normal_deg", e.normal_deg}};
    fmt::print("{}\n", json.dump());
}

void print_text(const SurfaceError& e) {
    fmt::print("rms     {:.4e}   of the reference's diagonal\n", e.rms);
    fmt::print("mean    {:.4e}\n", e.mean);
    fmt::print("max     {:.4e}\n", e.max);
    fmt::print("psnr    {:.2f} dB\n", e.psnr);
    fmt::print("normals {:.2f} degrees apart on average\n", e.normal_deg);
}

void compare(const CompareArguments& arguments) {
    const Mesh reference = load_measurable(arguments.reference), other = load_measurable(arguments.other);
    SurfaceErrorOptions options;
    options.samples = arguments.samples;
    const SurfaceError error = surface_error(reference, other, options);
    arguments.json ? print_json(error) : print_text(error);
}

}  // namespace

void add_compare(CLI::App& app) {
    auto arguments = std::make_shared<CompareArguments>();
    CLI::App* command = app.add_subcommand("compare", "Measures how far two surfaces lie apart, both ways");
    command->footer("Example: mvw compare bunny.ply bunny_8kb.ply");
    command->add_option("REFERENCE", arguments->reference, "Mesh or .mvw file whose box's diagonal is the unit")
        ->required();
    command->add_option("OTHER", arguments->other, "Mesh or .mvw file to compare with it")->required();
    command->add_option("--samples", arguments->samples, "Points laid on each surface, besides all vertices")
        ->check(CLI::Range(0, 1'000'000'000))
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: rms mean max psnr normal_deg");
    command->callback([arguments] { compare(*arguments); });
}

}  // namespace mvw::cli
