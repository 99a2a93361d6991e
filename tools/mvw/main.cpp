#include <cstdio>
#include <exception>

#include "tools/mvw/commands.h"

namespace {

using namespace mvw::cli;

int run(int argc, char** argv) {
    CLI::App app{"Encodes triangle meshes into .mvw files, streams them, and decodes them progressively."};
    app.require_subcommand(1);
    add_encode(app);
    add_decode(app);
    add_info(app);
    add_verify(app);
    add_compare(app);
    add_fetch(app);
    add_serve(app);
    add_token(app);
    add_view(app);
    add_subdivide(app);
    add_paper(app);
    add_bench(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kSuccess : kUsage;
    } catch (const Fatal& fatal) {
        std::fprintf(stderr, "mvw: %s\n", fatal.message.c_str());
        return fatal.exit_code;
    }
    return kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "mvw: %s\n", e.what());
    } catch (...) {
        std::fputs("mvw: failed for a reason unknown\n", stderr);
    }
    return kFailure;
}
