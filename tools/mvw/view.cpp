// mvw view: pictures of a mesh.
#include <cstdio>
#include <memory>

#include "client/viewer/picture.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

constexpr unsigned kFinest = 255;

struct ViewArguments {
    std::string file, screenshot, size = "1024x768";
    unsigned level = kFinest;
    PictureOptions picture;
};

void set_size(const std::string& text, PictureOptions& options) {
    int read = 0;
    if (std::sscanf(text.c_str(), "%5ux%5u%n", &options.width, &options.height, &read) != 2 ||
        static_cast<std::size_t>(read) != text.size())
        throw Fatal{kUsage, "--size is WIDTHxHEIGHT, as in 1024x768, not " + text};
}

void view(ViewArguments& arguments) {
    if (arguments.screenshot.empty())
        throw Fatal{kUsage, "view draws into a file: say where with --screenshot FILE.png (this build has no window)"};
    set_size(arguments.size, arguments.picture);
    if (arguments.level != kFinest && !is_mvw(arguments.file))
        throw Fatal{kUsage, arguments.file + ": --level needs a .mvw file"};
    const auto picture = draw_picture(load_surface(arguments.file, arguments.level), arguments.picture);
    if (!picture.ok())
        throw Fatal{picture.error().code == Errc::InvalidArgument ? kUsage : kFailure, picture.error().message};
    if (const auto written = write_png(arguments.screenshot, *picture); !written.ok())
        throw Fatal{kFailure, written.error().message};
}

}  // namespace

void add_view(CLI::App& app) {
    auto arguments = std::make_shared<ViewArguments>();
    CLI::App* command = app.add_subcommand("view", "Draws a mesh or .mvw file into a PNG file");
    command->footer("Example: mvw view bunny.ply --screenshot bunny.png --wireframe");
    command->add_option("FILE", arguments->file, "Mesh or .mvw file to draw")->required();
    command->add_option("--screenshot", arguments->screenshot, "PNG file to write");
    command->add_option("--size", arguments->size, "Width and height in pixels")->capture_default_str();
    command->add_option("--level", arguments->level, "Of a .mvw file: 0 is the base mesh, the finest where not given");
    command->add_flag("--wireframe", arguments->picture.wireframe, "Draw the triangles' edges, too");
    command->add_flag("--flat", arguments->picture.flat, "Shade each triangle by itself");
    command->add_option("--yaw", arguments->picture.yaw, "Degrees to the right around the model")
        ->capture_default_str();
    command->add_option("--pitch", arguments->picture.pitch, "Degrees above the model")->capture_default_str();
    command->callback([arguments] { view(*arguments); });
}

}  // namespace mvw::cli
