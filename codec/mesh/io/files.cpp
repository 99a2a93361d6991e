#include "codec/mesh/io/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace mvw {
namespace {

Error system_error(const std::string& path, const char* what, int number) {
    return {Errc::Io, 0, fmt::format("{}: {}: {}", path, what, std::generic_category().message(number))};
}

/// Closes its descriptor.
class Descriptor {
 public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int get() const { return fd_; }

 private:
    int fd_;
};

/// 0, or the error number of the first write that failed.
int write_all(int fd, ByteSpan bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno;
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return 0;
}

}  // namespace

Result<Bytes> read_file(const std::string& path) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.get() < 0) return system_error(path, "cannot be opened", errno);
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) return system_error(path, "cannot be read", errno);
    if (!S_ISREG(info.st_mode)) return Error{Errc::Io, 0, path + ": is not a regular file"};
    Bytes bytes(static_cast<std::size_t>(info.st_size));
    for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = ::read(file.get(), bytes.data() + at, bytes.size() - at);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return system_error(path, "cannot be read", errno);
        if (n == 0) return Error{Errc::Io, at, path + ": became shorter while it was read"};
        at += static_cast<std::size_t>(n);
    }
    return bytes;
}

Result<Bytes> read_file_below(const std::string* folder, std::string name) {
    std::ranges::replace(name, '\\', '/');
    if (folder == nullptr || name.empty() || name.front() == '/' || name.find("..") != std::string::npos)
        return Error{Errc::InvalidArgument, 0, name + ": is not looked for outside of the mesh's folder"};
    return read_file(*folder + name);
}

Result<void> write_file(const std::string& path, ByteSpan bytes) {
    static std::atomic<unsigned> serial{0};
    const std::string beside = fmt::format("{}.{}-{}.partial", path, ::getpid(), serial++);
    int failure = 0;
    {
        const Descriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        if (file.get() < 0) return system_error(path, "cannot be written", errno);
        failure = write_all(file.get(), bytes);
    }
    if (failure == 0 && std::rename(beside.c_str(), path.c_str()) != 0) failure = errno;
    if (failure == 0) return {};
    ::unlink(beside.c_str());
    return system_error(path, "cannot be written", failure);
}

}  // namespace mvw
