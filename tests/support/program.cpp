#include "tests/support/program.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mvw {
namespace {

std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace

ProgramRun run_mvw(const std::vector<std::string>& arguments) {
    const ScratchFolder folder;
    std::string command = quoted(MVW_PROGRAM);
    for (const std::string& a : arguments) command += " " + quoted(a);
    command += " </dev/null >" + quoted(folder / "out") + " 2>" + quoted(folder / "errors");
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(folder / "out"), read_text(folder / "errors")};
}

ScratchFolder::ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mvw_test_XXXXXX").string();
    path_ = mkdtemp(pattern.data()) == nullptr ? "." : pattern;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    if (path_ != ".") std::filesystem::remove_all(path_, ignored);
}

std::string read_text(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_text(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

std::string mvw_program() {
    return MVW_PROGRAM;
}

std::string test_data_folder() {
    return MVW_TEST_DATA;
}

}  // namespace mvw
