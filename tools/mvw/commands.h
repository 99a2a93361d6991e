// The subcommands of mvw: each file beside this one adds one, as a thin caller of the libraries.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace mvw::cli {

/// Exit codes, the same for every subcommand.
enum Exit : int { kSuccess = 0, kFailure = 1, kUsage = 2 };

/// Thrown by a subcommand's callback to end the program: main prints one line "mvw: message" and exits with the code.
struct Fatal {
    int exit_code = kFailure;
    std::string message;
};

/// Each adds its subcommand, with its options and the callback that runs it.
void add_encode(CLI::App& app);
void add_decode(CLI::App& app);
void add_info(CLI::App& app);
void add_verify(CLI::App& app);
void add_bench(CLI::App& app);
void add_compare(CLI::App& app);
void add_fetch(CLI::App& app);
void add_paper(CLI::App& app);
void add_serve(CLI::App& app);
void add_token(CLI::App& app);
void add_subdivide(CLI::App& app);
void add_view(CLI::App& app);

}  // namespace mvw::cli
