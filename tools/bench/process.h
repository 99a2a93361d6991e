// Runs other programs.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

#include "codec/result.h"

namespace mvw::bench {

struct ProcessRun {
    int exit_code = -1;  // -1 where a signal ended it
    std::string out;     // its standard output, whole
    std::string errors;  // its standard error, whole
    double seconds = 0;  // wall clock
};

/// Runs arguments[0] (looked up in PATH where it has no slash) without standard input, and waits for its end. Io where
/// it cannot be started.
Result<ProcessRun> run_process(const std::vector<std::string>& arguments);

/// A program that runs beside this one; asked to end (SIGTERM) and waited for with the object.
class BackgroundProcess {
 public:
    /// Its standard error is dropped. Io where it cannot be started.
    static Result<BackgroundProcess> start(const std::vector<std::string>& arguments);
    ~BackgroundProcess();
    BackgroundProcess(BackgroundProcess&& other) noexcept;
    BackgroundProcess& operator=(BackgroundProcess&&) = delete;

    /// The first line that it prints, without its end; what there is of it where the program ends or `seconds` pass.
    std::string first_line(double seconds);
    [[nodiscard]] pid_t pid() const { return child_; }

 private:
    BackgroundProcess(pid_t child, int output) : child_(child), output_(output) {}
    pid_t child_;
    int output_;
};

/// Path of the program that is running: how the bench starts `mvw` itself.
std::string own_program();

}  // namespace mvw::bench
