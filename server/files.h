// Files below one folder: opened part by part so that no symbolic link is followed, read by place, never mapped (a
// mapped file that shrinks kills the process).
#pragma once
#include <sys/stat.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "server/model_source.h"

namespace mvw::server {

/// What tells one state of a file from another.
struct FileStamp {
    std::uint64_t device = 0, inode = 0, bytes = 0;
    std::int64_t modified_ns = 0;
    friend constexpr bool operator==(const FileStamp&, const FileStamp&) = default;
};

/// An open descriptor, closed at the end.
class Descriptor {
 public:
    explicit Descriptor(int fd = -1) : fd_(fd) {}
    ~Descriptor();
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    [[nodiscard]] int get() const { return fd_; }
    [[nodiscard]] bool ok() const { return fd_ >= 0; }

 private:
    int fd_;
};

/// Io with the system's words for errno.
Error io_error(std::string_view what);

/// A folder, for the calls below. Not ok() where it cannot be opened; errno says why.
Descriptor open_folder(const std::string& path);
Descriptor open_folder_at(int folder, const std::string& name);
/// folder/a/b/c, a plain name: a link put in the way is refused and not followed. Not ok() where there is none.
Descriptor open_below(int folder, std::string_view name);

/// True for names that may be looked up: one or more parts joined by '/', none of them empty or starting with '.',
/// no NUL and no backslash.
bool is_plain_name(std::string_view name);

FileStamp stamp_of(const struct stat& s);
/// Io where it is not a plain file.
Result<FileStamp> stamp_of(int fd);

/// Fills `out` from `offset`. Io where that fails or the file ends before.
Result<void> read_all(int fd, std::uint64_t offset, std::span<std::byte> out);

/// An open file as bytes to be sent.
class FileSource final : public ByteSource {
 public:
    explicit FileSource(Descriptor file) : file_(std::move(file)) {}
    Result<void> read(std::uint64_t offset, std::span<std::byte> out) const override {
        return read_all(file_.get(), offset, out);
    }
    int descriptor() const override { return file_.get(); }

 private:
    Descriptor file_;
};

}  // namespace mvw::server
