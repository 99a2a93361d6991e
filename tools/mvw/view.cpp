// mvw view: a model in a window as it refines, or a picture of one.
#include <fmt/core.h>

#include <cstdio>
#include <memory>

#include "client/client.h"
#include "client/viewer/animation.h"
#include "client/viewer/picture.h"
#include "client/viewer/window/window.h"
#include "codec/mesh/io/files.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

constexpr unsigned kFinest = 255;

struct ViewArguments {
    std::string file, screenshot, animation, size = "1024x768";
    unsigned level = kFinest, layer = kFinest;
    double mbit_per_second = 0;  // 0: as fast as it goes
    bool z_up = false, controls = false;
    PictureOptions picture;
};

void set_size(const std::string& text, PictureOptions& options) {
    int read = 0;
    if (std::sscanf(text.c_str(), "%5ux%5u%n", &options.width, &options.height, &read) != 2 ||
        static_cast<std::size_t>(read) != text.size())
        throw Fatal{kUsage, "--size is WIDTHxHEIGHT, as in 1024x768, not " + text};
}

bool is_url(const std::string& place) {
    return place.find("://") != std::string::npos;
}

/// All of a model that a server has.
Mesh fetch_surface(const std::string& place, unsigned level) {
    const auto url = client::parse_url(place);
    if (!url.ok()) throw Fatal{kUsage, url.error().message};
    client::Stream stream(*url, {}, {});
    if (const auto summary = stream.wait(); !summary.ok())
        throw Fatal{kFailure, place + ": " + summary.error().message};
    auto mesh = stream.feed().decoder().mesh(level);
    if (!mesh.ok()) throw Fatal{kFailure, place + ": " + mesh.error().message};
    return std::move(mesh).value();
}

void draw_into_file(ViewArguments& arguments) {
    Mesh mesh = is_url(arguments.file) ? fetch_surface(arguments.file, arguments.level)
                                       : load_surface(arguments.file, arguments.level);
    if (arguments.z_up)
        for (Vec3& p : mesh.positions) p = {p.x, p.z, -p.y};
    const auto picture = draw_picture(mesh, arguments.picture);
    if (!picture.ok())
        throw Fatal{picture.error().code == Errc::InvalidArgument ? kUsage : kFailure, picture.error().message};
    if (const auto written = write_png(arguments.screenshot, *picture); !written.ok())
        throw Fatal{kFailure, written.error().message};
}

void animate(const ViewArguments& arguments) {
    constexpr unsigned kFrames = 40;
    if (!is_mvw(arguments.file)) throw Fatal{kUsage, arguments.file + ": --animation needs a .mvw file"};
    const auto file = read_file(arguments.file);
    if (!file.ok()) throw Fatal{kFailure, file.error().message};
    const auto frames = draw_refinement(*file, kFrames, arguments.z_up, arguments.picture);
    if (!frames.ok())
        throw Fatal{frames.error().code == Errc::InvalidArgument ? kUsage : kFailure,
                    arguments.file + ": " + frames.error().message};
    if (const auto written = write_webp(arguments.animation, *frames); !written.ok())
        throw Fatal{kFailure, written.error().message};
}

void show_window(const ViewArguments& arguments) {
    if (!is_url(arguments.file) && !is_mvw(arguments.file))
        throw Fatal{kUsage, arguments.file + ": a window shows .mvw files and URLs; draw others with --screenshot"};
    client::WindowOptions options;
    options.place = arguments.file;
    options.width = static_cast<int>(arguments.picture.width);
    options.height = static_cast<int>(arguments.picture.height);
    options.level = arguments.level;
    options.layer = arguments.layer;
    if (arguments.mbit_per_second > 0) options.bytes_per_second = arguments.mbit_per_second * 1e6 / 8;
    options.wireframe = arguments.picture.wireframe;
    options.flat = arguments.picture.flat;
    options.z_up = arguments.z_up;
    options.yaw = arguments.picture.yaw;
    options.pitch = arguments.picture.pitch;
    options.screenshot = arguments.screenshot;
    const auto shown = client::run_window(options);
    if (!shown.ok()) throw Fatal{kFailure, shown.error().message};
    if (arguments.controls)
        fmt::print(stderr, "{} frames, at most {:.1f} ms of one beside drawing\n", shown->frames,
                   shown->longest_wait * 1000);
}

void view(ViewArguments& arguments) {
    set_size(arguments.size, arguments.picture);
    if (arguments.level != kFinest && !is_url(arguments.file) && !is_mvw(arguments.file))
        throw Fatal{kUsage, arguments.file + ": --level needs a .mvw file"};
    if (arguments.controls && arguments.screenshot.empty()) throw Fatal{kUsage, "--controls goes with --screenshot"};
    if (!arguments.animation.empty())
        animate(arguments);
    else if (arguments.screenshot.empty() || arguments.controls)
        show_window(arguments);
    else
        draw_into_file(arguments);
}

}  // namespace

void add_view(CLI::App& app) {
    auto arguments = std::make_shared<ViewArguments>();
    CLI::App* command =
        app.add_subcommand("view", "Shows a .mvw file or URL in a window, or draws a mesh into a PNG file");
    command->footer(
        "Without --screenshot a window opens. It refines while bytes arrive; tiles in view get theirs first.\n"
        "Example: mvw view mvw://127.0.0.1:7707/bunny\n"
        "Example: mvw view bunny.ply --screenshot bunny.png --wireframe");
    command->add_option("FILE", arguments->file, ".mvw file, URL, or, with --screenshot, mesh")->required();
    command->add_option("--screenshot", arguments->screenshot, "PNG file to write, without a display");
    command->add_option("--animation", arguments->animation, "WebP file to write, without a display: it refines")
        ->excludes("--screenshot");
    command->add_flag("--controls", arguments->controls, "The screenshot is of the window, once all has come");
    command->add_flag("--z-up", arguments->z_up, "The model's z axis points up, not its y axis");
    command->add_option("--size", arguments->size, "Width and height in pixels")->capture_default_str();
    command->add_option("--level", arguments->level, "Of a .mvw file: 0 is the base mesh, the finest where not given");
    command->add_option("--layer", arguments->layer, "Of a window: no finer layer is used");
    command->add_option("--mbit", arguments->mbit_per_second, "Of a window: the link is no faster, at first")
        ->check(CLI::PositiveNumber);
    command->add_flag("--wireframe", arguments->picture.wireframe, "Draw the triangles' edges, too");
    command->add_flag("--flat", arguments->picture.flat, "Shade each triangle by itself");
    command->add_option("--yaw", arguments->picture.yaw, "Degrees to the right around the model")
        ->capture_default_str();
    command->add_option("--pitch", arguments->picture.pitch, "Degrees above the model")->capture_default_str();
    command->callback([arguments] { view(*arguments); });
}

}  // namespace mvw::cli
