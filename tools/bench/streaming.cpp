#include "tools/bench/streaming.h"

#include <filesystem>

#include "codec/mesh/io/files.h"
#include "tools/bench/process.h"

namespace mvw::bench {
namespace {

constexpr double kStartSeconds = 20;

std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

std::string stream_one(const std::string& url, const std::string& folder, const std::string& model) {
    const std::string served = folder + "/" + model + ".mvw";
    const std::string output = folder + "/." + model + ".mvw";
    const auto run = run_process({own_program(), "fetch", url + "/" + model, output});
    if (!run) return run.error().message;
    if (run->exit_code != 0) return first_line(run->errors);
    const auto sent = read_file(served), came = read_file(output);
    std::error_code ignored;
    std::filesystem::remove(output, ignored);
    if (!sent || !came) return "not written";
    return *sent == *came ? "yes" : "other bytes came";
}

}  // namespace

Result<std::vector<std::string>> stream_models(const std::string& folder, const std::vector<std::string>& models) {
    auto server =
        BackgroundProcess::start({own_program(), "serve", folder, "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0"});
    if (!server) return server.error();
    const std::string line = server->first_line(kStartSeconds);
    const std::size_t at = line.find("mvw://");
    if (at == std::string::npos) return Error{Errc::Io, 0, "mvw serve does not start"};
    const std::string url = line.substr(at, line.find(' ', at) - at);
    std::vector<std::string> answers;
    answers.reserve(models.size());
    for (const std::string& model : models) answers.push_back(stream_one(url, folder, model));
    return answers;
}

}  // namespace mvw::bench
