#include "server/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace mvw::server {
namespace {

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
constexpr int kFileFlags = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;  // a fifo must not block the open

}  // namespace

Descriptor::~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
}

Error io_error(std::string_view what) {
    return {Errc::Io, 0, std::string(what) + ": " + std::strerror(errno)};
}

FileStamp stamp_of(const struct stat& s) {
    return {s.st_dev, s.st_ino, static_cast<std::uint64_t>(s.st_size),
            std::int64_t{s.st_mtim.tv_sec} * 1'000'000'000 + s.st_mtim.tv_nsec};
}

Result<FileStamp> stamp_of(int fd) {
    struct stat s {};
    if (::fstat(fd, &s) != 0) return io_error("stat");
    if (!S_ISREG(s.st_mode)) return Error{Errc::Io, 0, "not a file"};
    return stamp_of(s);
}

Result<void> read_all(int fd, std::uint64_t offset, std::span<std::byte> out) {
    while (!out.empty()) {
        const ssize_t n = ::pread(fd, out.data(), out.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return io_error("read");
        if (n == 0) return Error{Errc::Io, offset, "the file has become shorter"};
        out = out.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return {};
}

Descriptor open_folder(const std::string& path) {
    return Descriptor(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
}

Descriptor open_folder_at(int folder, const std::string& name) {
    return Descriptor(::openat(folder, name.c_str(), kFolderFlags));
}

Descriptor open_below(int folder, std::string_view name) {
    Descriptor here;
    int at = folder;
    for (std::size_t slash = name.find('/'); slash != std::string_view::npos; slash = name.find('/')) {
        here = open_folder_at(at, std::string(name.substr(0, slash)));
        if (!here.ok()) return here;
        at = here.get();
        name.remove_prefix(slash + 1);
    }
    return Descriptor(::openat(at, std::string(name).c_str(), kFileFlags));
}

bool is_plain_name(std::string_view name) {
    if (name.empty() || name.find('\0') != std::string_view::npos || name.find('\\') != std::string_view::npos)
        return false;
    for (std::size_t at = 0; at <= name.size();) {
        const std::size_t end = std::min(name.find('/', at), name.size());
        if (end == at || name[at] == '.') return false;
        at = end + 1;
    }
    return true;
}

}  // namespace mvw::server
