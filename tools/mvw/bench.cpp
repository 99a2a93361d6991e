// mvw bench: measurements whose answers are kept.
#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/bench/cuts.h"
#include "tools/bench/decode_speed.h"
#include "tools/bench/load.h"
#include "tools/bench/lod_hull.h"
#include "tools/bench/models.h"
#include "tools/bench/network.h"
#include "tools/bench/remesh.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

struct ModelsArguments {
    bench::ModelsOptions options;
    bool json = false, no_pictures = false;
};

struct RemeshArguments {
    bench::RemeshBenchOptions options;
    std::string transform{transform_name(options.transform)};
    bool json = false, no_pictures = false;
};

struct CutsArguments {
    bench::CutsOptions options;
    bool json = false;
};

struct DecodeSpeedArguments {
    bench::DecodeSpeedOptions options;
    bool json = false;
};

struct LodHullArguments {
    bench::LodHullOptions options;
    bool json = false;
};

struct NetworkArguments {
    bench::NetworkOptions options;
    bool json = false;
};

void print_json(const char* name, const bench::Table& table) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const auto& row : table.rows) {
        nlohmann::ordered_json object;
        for (std::size_t i = 0; i < row.size(); ++i) object[table.head[i]] = row[i];
        rows.push_back(object);
    }
    fmt::print("{}\n", nlohmann::ordered_json{{name, rows}}.dump());
}

void print(const Result<bench::Table>& table, const char* name, bool json) {
    if (!table) throw Fatal{kFailure, table.error().message};
    if (json)
        print_json(name, *table);
    else
        fmt::print("{}", table->markdown());
}

void say_on_errors(const std::string& line) {
    fmt::print(stderr, "{}\n", line);
}

void bench_models(ModelsArguments& arguments) {
    arguments.options.pictures = !arguments.no_pictures;
    arguments.options.say = say_on_errors;
    print(bench::run_models(arguments.options), "models", arguments.json);
}

void bench_remesh(RemeshArguments& arguments) {
    arguments.options.pictures = !arguments.no_pictures;
    arguments.options.transform = transform_from_name(arguments.transform).value();  // one of transform_names()
    arguments.options.say = say_on_errors;
    print(bench::run_remesh(arguments.options), "steps", arguments.json);
}

void bench_lod_hull(LodHullArguments& arguments) {
    arguments.options.say = say_on_errors;
    print(bench::run_lod_hull(arguments.options), "points", arguments.json);
}

void bench_cuts(CutsArguments& arguments) {
    arguments.options.say = say_on_errors;
    print(bench::run_cuts(arguments.options), "models", arguments.json);
}

void bench_decode(DecodeSpeedArguments& arguments) {
    arguments.options.say = say_on_errors;
    print(bench::run_decode_speed(arguments.options), "times", arguments.json);
}

void bench_network(NetworkArguments& arguments) {
    arguments.options.say = say_on_errors;
    print(bench::run_network(arguments.options), "cases", arguments.json);
}

void add_network(CLI::App& bench) {
    auto arguments = std::make_shared<NetworkArguments>();
    CLI::App* command = bench.add_subcommand(
        "network", "Times the stream over shaped links against whole Draco files and chains of them");
    command->footer("Example: mvw bench network bunny.ply --out results   (writes network.csv, network.md and plots)");
    command->add_option("MESH", arguments->options.meshes, "Mesh files")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--rates", arguments->options.megabits, "Mbit/s")->capture_default_str();
    command->add_option("--round-trips", arguments->options.round_trips_ms, "Milliseconds")->capture_default_str();
    command->add_option("--runs", arguments->options.runs, "Over each link; medians count")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--simplifier", arguments->options.simplifier, "simplify.mjs, with its packages beside it")
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: cases, a list of one object per link");
    command->callback([arguments] { bench_network(*arguments); });
}

struct LoadArguments {
    bench::LoadOptions options;
    bool json = false;
};

void bench_load(const LoadArguments& arguments) {
    print(bench::run_load(arguments.options), "measures", arguments.json);
}

void add_load(CLI::App& bench) {
    auto arguments = std::make_shared<LoadArguments>();
    CLI::App* command = bench.add_subcommand("load", "Measures mvw serve in a crowd, beside nginx with the same files");
    command->footer("Example: mvw bench load models --clients 64 --rounds 7");
    command->add_option("DIR", arguments->options.folder, "Folder of .mvw files")->required();
    command->add_option("--idle", arguments->options.idle, "Idle connections")->capture_default_str();
    command->add_option("--clients", arguments->options.clients, "HTTP connections at once")->capture_default_str();
    command->add_option("--streams", arguments->options.streams, "Streams at once")->capture_default_str();
    command->add_option("--seconds", arguments->options.seconds, "Of each throughput run")->capture_default_str();
    command->add_option("--rounds", arguments->options.rounds, "Throughput runs of each server")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--nginx", arguments->options.nginx, "The other server")->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: measures, a list of one object per figure");
    command->callback([arguments] { bench_load(*arguments); });
}

struct SoakArguments {
    bench::SoakOptions options;
    bool json = false;
};

void bench_soak(SoakArguments& arguments) {
    arguments.options.say = say_on_errors;
    print(bench::run_soak(arguments.options), "steps", arguments.json);
}

void add_soak(CLI::App& bench) {
    auto arguments = std::make_shared<SoakArguments>();
    CLI::App* command =
        bench.add_subcommand("soak", "Lets badly behaved clients loose on mvw serve and watches its memory");
    command->footer("Example: mvw bench soak models --seconds 1800   (fails where memory or descriptors grow)");
    command->add_option("DIR", arguments->options.folder, "Folder of .mvw files")->required();
    command->add_option("--seconds", arguments->options.seconds, "How long")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: steps, a list of one object per look");
    command->callback([arguments] { bench_soak(*arguments); });
}

void add_models(CLI::App& bench) {
    auto arguments = std::make_shared<ModelsArguments>();
    CLI::App* command = bench.add_subcommand("models", "Encodes, decodes and compares every mesh of a folder");
    command->footer("Example: mvw bench models scans --out results   (writes models.csv, models.md and pictures)");
    command->add_option("DIR", arguments->options.folder, "Folder of meshes, also packed as .zst")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--only", arguments->options.only, "Names of models, without ending");
    command->add_option("--encode-option", arguments->options.encode_extra, "Passed on to mvw encode; repeatable")
        ->allow_extra_args(false);
    command->add_flag("--no-pictures", arguments->no_pictures, "Figures only");
    command->add_flag("--json", arguments->json, "One JSON object: models, a list of one object per model");
    command->callback([arguments] { bench_models(*arguments); });
}

void add_lod_hull(CLI::App& bench) {
    auto arguments = std::make_shared<LodHullArguments>();
    CLI::App* command =
        bench.add_subcommand("lod-hull", "Holds prefixes of .mvw files against simplified meshes coded by Draco");
    command->footer("Example: mvw bench lod-hull bunny.ply lucy.ply --out results   (writes lod_hull.csv and plots)");
    command->add_option("MESH", arguments->options.meshes, "Mesh files")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--hull", arguments->options.hull,
                        "Hulls of an earlier lod_hull.csv: needs neither node nor Draco's programs for these models");
    command->add_option("--simplifier", arguments->options.simplifier, "simplify.mjs, with its packages beside it")
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: points, a list of one object per file or prefix");
    command->callback([arguments] { bench_lod_hull(*arguments); });
}

void add_remesh(CLI::App& bench) {
    auto arguments = std::make_shared<RemeshArguments>();
    CLI::App* command = bench.add_subcommand(
        "remesh", "Remeshes every mesh of a folder: error, folds and cost of each step, and pictures");
    command->footer("Example: mvw bench remesh scans --out results   (writes remesh.csv, remesh.md and NAME.png)");
    command->add_option("DIR", arguments->options.folder, "Folder of meshes, .zst-packed ones too")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--only", arguments->options.only, "Names of models, without ending (default: all)");
    command->add_option("--base-faces", arguments->options.base_faces, "Faces of the base (default: by the model)");
    command->add_option("--levels", arguments->options.levels, "Levels above the base (default: by the model)")
        ->check(CLI::Range(0, 12));
    command->add_option("--transform", arguments->transform, "Transform whose details sliding makes normal")
        ->check(CLI::IsMember(transform_names()))
        ->capture_default_str();
    command->add_flag("--no-pictures", arguments->no_pictures, "Figures alone");
    command->add_flag("--json", arguments->json, "One JSON object: steps, a list of one object per row");
    command->callback([arguments] { bench_remesh(*arguments); });
}

void add_decode_speed(CLI::App& bench) {
    auto arguments = std::make_shared<DecodeSpeedArguments>();
    CLI::App* command = bench.add_subcommand(
        "decode", "Times decoding on one thread and two against Draco at as many vertices and as small an error");
    command->footer("Example: mvw bench decode lucy.ply --out results   (writes decode_speed.csv)");
    command->add_option("MESH", arguments->options.meshes, "Mesh files")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--tile-count", arguments->options.tile_count, "Tiles of each part")
        ->check(CLI::Range(1, 65535))
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: times, a list of one object per row");
    command->callback([arguments] { bench_decode(*arguments); });
}

void add_cuts(CLI::App& bench) {
    auto arguments = std::make_shared<CutsArguments>();
    CLI::App* command =
        bench.add_subcommand("cuts", "Cuts one file of each mesh at 200 places: is more always better?");
    command->footer("Example: mvw bench cuts bunny.ply lucy.ply --out results   (writes cuts.csv)");
    command->add_option("MESH", arguments->options.meshes, "Mesh files")->required();
    command->add_option("--out", arguments->options.out, "Folder for the results")->required();
    command->add_option("--count", arguments->options.count, "Cuts of each file")
        ->check(CLI::Range(2, 100'000))
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "One JSON object: models, a list of one object per model");
    command->callback([arguments] { bench_cuts(*arguments); });
}

}  // namespace

void add_bench(CLI::App& app) {
    CLI::App* bench = app.add_subcommand("bench", "Measures the codec and the stream");
    bench->footer("Example: mvw bench models scans --out results");
    bench->require_subcommand(1);
    add_models(*bench);
    add_remesh(*bench);
    add_lod_hull(*bench);
    add_cuts(*bench);
    add_decode_speed(*bench);
    add_network(*bench);
    add_load(*bench);
    add_soak(*bench);
}

}  // namespace mvw::cli
