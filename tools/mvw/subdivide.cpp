// mvw subdivide: the plain matrix-valued scheme as a surface generator.
#include <memory>

#include "codec/limits.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/transform/subdivide.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

struct SubdivideArguments {
    std::string input, output;
    SubdivideOptions options;
};

void subdivide_file(const SubdivideArguments& arguments) {
    const Mesh mesh = load_mesh(arguments.input);
    if (mesh.faces.empty()) throw Fatal{kFailure, arguments.input + ": no face to subdivide"};
    const auto base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces);
    if (!base.ok()) throw Fatal{kFailure, arguments.input + ": " + base.error().message};
    const std::uint64_t vertices = vertices_at_level(*base, arguments.options.levels);
    if (const Limits limits; vertices > limits.max_vertices)
        throw Fatal{kFailure, arguments.input + ": " + std::to_string(vertices) + " vertices at level " +
                                  std::to_string(arguments.options.levels) + ", limit is " +
                                  std::to_string(limits.max_vertices)};
    Mesh out;
    out.positions = subdivide(*base, mesh.positions, arguments.options);
    out.faces = triangles_at_level(*base, arguments.options.levels);
    if (const auto written = write_mesh(arguments.output, out); !written.ok())
        throw Fatal{kFailure, written.error().message};
}

}  // namespace

void add_subdivide(CLI::App& app) {
    auto arguments = std::make_shared<SubdivideArguments>();
    CLI::App* command = app.add_subcommand(
        "subdivide", "Refines a mesh by matrix-valued interpolatory Loop subdivision: a smooth surface through it");
    command->footer("Example: mvw subdivide cage.obj surface.ply --levels 4 --shape 1");
    command->add_option("INPUT", arguments->input, "Mesh file: the control mesh")->required();
    command->add_option("OUTPUT", arguments->output, "Mesh file to write")->required();
    command->add_option("--levels", arguments->options.levels, "Times that each triangle is cut in four")
        ->check(CLI::Range(0u, 10u))
        ->capture_default_str();
    command
        ->add_option("--shape", arguments->options.shape,
                     "Second component of each control vertex, in units of a quarter of (vertex - mean of its ring): 0 "
                     "none, 1 keeps quadratics, more bulges")
        ->check(CLI::Range(-10.0, 10.0))
        ->capture_default_str();
    command->add_option("--s", arguments->options.s, "Rule at vertices of valence other than 6, above 0 up to 36/31")
        ->check(CLI::Range(1e-6, 36.0 / 31.0))
        ->capture_default_str();
    command->callback([arguments] { subdivide_file(*arguments); });
}

}  // namespace mvw::cli
