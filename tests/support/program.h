// Runs the program itself, as a user would.
#pragma once
#include <string>
#include <vector>

namespace mvw {

struct ProgramRun {
    int exit_code = -1;       // -1 where a signal ended it
    std::string out, errors;  // standard output and standard error, whole
};

/// Runs build/mvw with these arguments and no standard input, and waits for it.
ProgramRun run_mvw(const std::vector<std::string>& arguments);

/// Path of build/mvw.
std::string mvw_program();

/// tests/data, without a slash at its end.
std::string test_data_folder();

/// A folder that is the test's own, removed with all in it at the end.
class ScratchFolder {
 public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    /// Path of a file in it.
    [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
    std::string path_;
};

/// The whole file; empty where it cannot be read.
std::string read_text(const std::string& path);
void write_text(const std::string& path, const std::string& text);

}  // namespace mvw
