#include "tools/bench/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

namespace mvw::bench {
namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
/// An unnamed file: takes output of any length without a reader that must keep pace.
using ScratchFile = std::unique_ptr<std::FILE, CloseFile>;

std::string contents(std::FILE* file) {
    std::string text;
    std::array<char, 65536> part{};
    std::rewind(file);
    for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), file)) > 0;) text.append(part.data(), n);
    return text;
}

/// What a child's standard streams become; its input is empty.
class SpawnActions {
 public:
    SpawnActions() {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    }
    ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
    SpawnActions(const SpawnActions&) = delete;
    SpawnActions& operator=(const SpawnActions&) = delete;

    void redirect(int to, int stream) { posix_spawn_file_actions_adddup2(&actions_, to, stream); }
    void drop(int stream) { posix_spawn_file_actions_addopen(&actions_, stream, "/dev/null", O_WRONLY, 0); }
    [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
    posix_spawn_file_actions_t actions_{};
};

Result<pid_t> spawn(const std::vector<std::string>& arguments, const SpawnActions& actions) {
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_t child = 0;
    if (const int error = posix_spawnp(&child, argv[0], actions.get(), nullptr, argv.data(), environ); error != 0)
        return Error{Errc::Io, 0, arguments[0] + ": " + std::strerror(error)};
    return child;
}

int wait_for(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

}  // namespace

Result<ProcessRun> run_process(const std::vector<std::string>& arguments) {
    const ScratchFile out(std::tmpfile()), errors(std::tmpfile());
    if (!out || !errors) return Error{Errc::Io, 0, "no temporary file can be made"};
    SpawnActions actions;
    actions.redirect(fileno(out.get()), STDOUT_FILENO);
    actions.redirect(fileno(errors.get()), STDERR_FILENO);
    const auto start = std::chrono::steady_clock::now();
    const auto child = spawn(arguments, actions);
    if (!child) return child.error();
    const int status = wait_for(*child);
    ProcessRun run;
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    run.out = contents(out.get());
    run.errors = contents(errors.get());
    return run;
}

Result<BackgroundProcess> BackgroundProcess::start(const std::vector<std::string>& arguments) {
    std::array<int, 2> pipe{};
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) return Error{Errc::Io, 0, "no pipe can be made"};
    SpawnActions actions;
    actions.redirect(pipe[1], STDOUT_FILENO);
    actions.drop(STDERR_FILENO);
    const auto child = spawn(arguments, actions);
    close(pipe[1]);
    if (child) return BackgroundProcess(*child, pipe[0]);
    close(pipe[0]);
    return child.error();
}

BackgroundProcess::BackgroundProcess(BackgroundProcess&& other) noexcept
    : child_(std::exchange(other.child_, 0)), output_(std::exchange(other.output_, -1)) {}

BackgroundProcess::~BackgroundProcess() {
    if (child_ == 0) return;
    close(output_);
    kill(child_, SIGTERM);
    wait_for(child_);
}

std::string BackgroundProcess::first_line(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    std::string line;
    for (char c = 0;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
        pollfd ready{output_, POLLIN, 0};
        if (left <= 0 || poll(&ready, 1, static_cast<int>(left)) <= 0) return line;
        if (read(output_, &c, 1) != 1 || c == '\n') return line;
        line += c;
    }
}

std::string own_program() {
    std::error_code ignored;
    return std::filesystem::read_symlink("/proc/self/exe", ignored).string();
}

}  // namespace mvw::bench
