#include "tools/bench/models.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tools/bench/model_files.h"
#include "tools/bench/process.h"
#include "tools/bench/sheet.h"
#include "tools/bench/streaming.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;

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

Figures measure(const ModelFile& model, const ModelsOptions& options) {
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
    "model",       "input vertices",   "input faces", "parts",   "base faces",  "levels",      "vertices",
    "bytes",       "base bytes",       "bits/vertex", "PSNR dB", "max",         "normals deg", "draco area share",
    "encode s",    "decode s",         "peak MB",     "folds",   "input folds", "backs",       "backs seen",
    "input backs", "input backs seen", "genus",       "loops",   "topology",    "streamed",    "note"};

std::vector<std::string> row_of(const ModelFile& model, const Figures& f) {
    const auto& e = f.encode;
    std::string bits, folds, input_folds, backs, seen, input_backs, input_seen, genus, loops, topology;
    if (const double vertices = e.value("input_vertices", 0.0); vertices > 0)
        bits = fmt::format("{:.2f}", 8 * e.value("bytes", 0.0) / vertices);
    if (f.inspection) {
        const Inspection& i = *f.inspection;
        folds = fmt::format("{}", i.folds);
        input_folds = fmt::format("{}", i.input_folds);
        for (const BackPixels& level : i.backs) {
            backs += fmt::format("{}{}", backs.empty() ? "" : " ", level.in_place);
            seen += fmt::format("{}{}", seen.empty() ? "" : " ", level.seen);
        }
        if (!backs.empty()) {
            input_backs = fmt::format("{}", i.input_backs.in_place);
            input_seen = fmt::format("{}", i.input_backs.seen);
        }
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
            backs,
            seen,
            input_backs,
            input_seen,
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
Result<void> check_streaming(const std::vector<ModelFile>& models, const std::string& out, Table& table) {
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
    const auto models = list_models(options.folder, options.only);
    if (!models) return models.error();
    Table table{kHead, {}};
    for (const ModelFile& model : *models) {
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
