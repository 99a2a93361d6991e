#include "tools/bench/models.h"

#include <fmt/core.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/bench/folds.h"
#include "tools/bench/process.h"
#include "tools/bench/sheet.h"
#include "tools/bench/streaming.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;

struct Model {
    fs::path file;
    std::string name;  // without folder and ending
};

std::string ending(const fs::path& file) {
    return file.extension() == ".zst" ? file.stem().extension().string() : file.extension().string();
}

std::string stem(const fs::path& file) {
    return file.extension() == ".zst" ? file.stem().stem().string() : file.stem().string();
}

Result<std::vector<Model>> list_models(const ModelsOptions& options) {
    constexpr std::array<const char*, 6> kEndings{".ply", ".obj", ".stl", ".off", ".gltf", ".glb"};
    std::error_code error;
    std::vector<Model> models;
    fs::recursive_directory_iterator walk(options.folder, error), end;
    for (; !error && walk != end; walk.increment(error)) {
        if (walk->path().filename() == "tiny") walk.disable_recursion_pending();
        if (!walk->is_regular_file() ||
            std::find(kEndings.begin(), kEndings.end(), ending(walk->path())) == kEndings.end())
            continue;
        const Model model{walk->path(), stem(walk->path())};
        if (options.only.empty() || std::count(options.only.begin(), options.only.end(), model.name) > 0)
            models.push_back(model);
    }
    if (error) return Error{Errc::Io, 0, options.folder + ": " + error.message()};
    std::sort(models.begin(), models.end(), [](const Model& a, const Model& b) {
        return std::pair(fs::file_size(a.file), a.name) < std::pair(fs::file_size(b.file), b.name);
    });
    return models;
}

/// The model as a file that mvw reads: itself, or unpacked into `out`.
Result<std::string> unpacked(const Model& model, const std::string& out) {
    if (model.file.extension() != ".zst") return model.file.string();
    const auto packed = read_file(model.file.string());
    if (!packed) return packed.error();
    const unsigned long long size = ZSTD_getFrameContentSize(packed->data(), packed->size());
    if (size >= (1ull << 32)) return Error{Errc::Malformed, 0, model.file.string() + ": states no sensible size"};
    Bytes bytes(size);
    if (ZSTD_decompress(bytes.data(), bytes.size(), packed->data(), packed->size()) != size)
        return Error{Errc::Malformed, 0, model.file.string() + ": cannot be unpacked"};
    const std::string path = out + "/" + model.name + ending(model.file);
    if (auto written = write_file(path, bytes); !written) return written.error();
    return path;
}

/// Runs a subcommand with --json and parses what it says; its own words where it fails.
Result<nlohmann::json> ask(std::vector<std::string> arguments) {
    const std::string command = arguments[0];
    arguments.insert(arguments.begin(), own_program());
    arguments.emplace_back("--json");
    auto run = run_process(arguments);
    if (!run) return run.error();
    if (run->exit_code != 0) {
        const std::string reason = run->errors.empty() ? "ended by a signal" : run->errors;
        return Error{Errc::Io, 0, command + ": " + reason.substr(0, reason.find('\n'))};
    }
    auto json = nlohmann::json::parse(run->out, nullptr, false);
    if (json.is_discarded()) return Error{Errc::Malformed, 0, command + " printed no JSON"};
    return json;
}

std::string number(const nlohmann::json& json, const char* key, const char* format = "{:.0f}") {
    const auto at = json.find(key);
    if (at == json.end() || at->is_null()) return "";
    return at->is_number() ? fmt::format(fmt::runtime(format), at->get<double>()) : at->dump();
}

/// All that is known of one model.
struct Figures {
    nlohmann::json encode = nlohmann::json::object(), decode = encode, compare = encode;
    std::optional<Inspection> inspection;
    std::string trouble;
};

Figures measure(const Model& model, const ModelsOptions& options) {
    Figures figures;
    const auto fail = [&](const Error& error) {
        figures.trouble = error.message;
        return figures;
    };
    const auto input = unpacked(model, options.out);
    if (!input) return fail(input.error());
    const std::string base = options.out + "/" + model.name, file = base + ".mvw", decoded = base + ".decoded.ply";
    std::vector<std::string> arguments{"encode", *input, file};
    arguments.insert(arguments.end(), options.encode_extra.begin(), options.encode_extra.end());
    auto encode = ask(arguments);
    if (!encode) return fail(encode.error());
    figures.encode = *encode;
    auto decode = ask({"decode", file, decoded});
    if (!decode) return fail(decode.error());
    figures.decode = *decode;
    auto compare = ask({"compare", *input, decoded});
    if (!compare) return fail(compare.error());
    figures.compare = *compare;
    auto inspection = inspect(*input, file, options.pictures ? base + ".png" : "");
    if (!inspection) return fail(inspection.error());
    figures.inspection = *inspection;
    fs::remove(decoded);
    if (*input != model.file.string()) fs::remove(*input);
    return figures;
}

const std::vector<std::string> kHead{
    "model",      "input vertices", "input faces", "parts", "base faces",  "levels",           "vertices", "bytes",
    "base bytes", "bits/vertex",    "PSNR dB",     "max",   "normals deg", "draco area share", "encode s", "decode s",
    "peak MB",    "folds",          "input folds", "genus", "loops",       "topology",         "streamed", "note"};

std::vector<std::string> row_of(const Model& model, const Figures& f) {
    const auto& e = f.encode;
    std::string bits, folds, input_folds, genus, loops, topology;
    if (const double vertices = e.value("input_vertices", 0.0); vertices > 0)
        bits = fmt::format("{:.2f}", 8 * e.value("bytes", 0.0) / vertices);
    if (f.inspection) {
        const Inspection& i = *f.inspection;
        folds = fmt::format("{}", i.folds);
        input_folds = fmt::format("{}", i.input_folds);
        genus = fmt::format("{}", i.topology.genus);
        loops = fmt::format("{}", i.topology.boundary_loops);
        topology = i.topology_kept ? "kept" : i.topology_trouble;
    }
    return {model.name,
            number(e, "input_vertices"),
            number(e, "input_faces"),
            number(e, "parts"),
            number(e, "base_faces"),
            number(e, "levels"),
            number(e, "vertices"),
            number(e, "bytes"),
            number(e, "base_bytes"),
            bits,
            number(f.compare, "psnr", "{:.2f}"),
            number(f.compare, "max", "{:.2e}"),
            number(f.compare, "normal_deg", "{:.2f}"),
            number(e, "draco_area_share", "{:.4f}"),
            number(e, "seconds", "{:.1f}"),
            number(f.decode, "seconds", "{:.2f}"),
            number(e, "peak_mb"),
            folds,
            input_folds,
            genus,
            loops,
            topology,
            "",
            f.trouble};
}

Result<void> write_table(const Table& table, const std::string& out) {
    if (auto written = write_text_file(out + "/models.csv", table.csv()); !written) return written.error();
    return write_text_file(out + "/models.md", table.markdown());
}

/// Fills the column of that name for all models that have a file.
Result<void> check_streaming(const std::vector<Model>& models, const std::string& out, Table& table) {
    const auto column = static_cast<std::size_t>(std::find(kHead.begin(), kHead.end(), "streamed") - kHead.begin());
    std::vector<std::string> names;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < models.size(); ++i)
        if (fs::exists(out + "/" + models[i].name + ".mvw")) {
            names.push_back(models[i].name);
            rows.push_back(i);
        }
    if (names.empty()) return {};
    const auto answers = stream_models(out, names);
    if (!answers) return answers.error();
    for (std::size_t k = 0; k < rows.size(); ++k) table.rows[rows[k]][column] = (*answers)[k];
    return {};
}

}  // namespace

Result<Table> run_models(const ModelsOptions& options) {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) return Error{Errc::Io, 0, options.out + ": " + error.message()};
    const auto models = list_models(options);
    if (!models) return models.error();
    Table table{kHead, {}};
    for (const Model& model : *models) {
        table.rows.push_back(row_of(model, measure(model, options)));
        std::string line;
        for (const std::string& cell : table.rows.back())
            line += (line.empty() ? "" : "  ") + (cell.empty() ? "-" : cell);
        if (options.say) options.say(line);
        // Written after each model: a run that is cut short leaves what it found.
        if (auto written = write_table(table, options.out); !written) return written.error();
    }
    if (auto streamed = check_streaming(*models, options.out, table); !streamed) return streamed.error();
    if (auto written = write_table(table, options.out); !written) return written.error();
    return table;
}

}  // namespace mvw::bench
