#include "server/origin/cached_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "codec/container/crc32c.h"

namespace mvw::server {
namespace {

constexpr int kFlags = O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC;
constexpr std::size_t kRecordBytes = 8;  // u32 block, u32 crc32c

Descriptor open_file(int folder, const std::string& name, std::string_view ending) {
    return Descriptor(::openat(folder, (name + std::string(ending)).c_str(), kFlags, 0644));
}

Result<void> write_all(int fd, std::uint64_t offset, ByteSpan bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return io_error("write to the cache");
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return {};
}

}  // namespace

CachedFile::CachedFile(Descriptor bytes, Descriptor list, std::uint64_t file_bytes)
    : bytes_(std::move(bytes)),
      list_(std::move(list)),
      file_bytes_(file_bytes),
      there_((file_bytes + kBlockBytes - 1) / kBlockBytes) {}

Result<std::shared_ptr<CachedFile>> CachedFile::open(int folder, const std::string& name, std::uint64_t file_bytes) {
    Descriptor bytes = open_file(folder, name, kBytesEnding), list = open_file(folder, name, kListEnding);
    if (!bytes.ok() || !list.ok()) return io_error("the cache");
    const Result<FileStamp> stamp = stamp_of(bytes.get());
    if (!stamp) return stamp.error();
    // Another size, or a new file: whatever the list says is of something else.
    if (stamp->bytes != file_bytes &&
        (::ftruncate(list.get(), 0) != 0 || ::ftruncate(bytes.get(), static_cast<off_t>(file_bytes)) != 0))
        return io_error("the cache");
    ::futimens(bytes.get(), nullptr);  // used: goes last
    std::shared_ptr<CachedFile> file(new CachedFile(std::move(bytes), std::move(list), file_bytes));
    file->trust_list();
    return file;
}

void CachedFile::remove(int folder, const std::string& name) {
    for (const std::string_view ending : {kListEnding, kBytesEnding})
        ::unlinkat(folder, (name + std::string(ending)).c_str(), 0);
}

void CachedFile::trust_list() {
    Bytes records, block(kBlockBytes);
    if (const Result<FileStamp> stamp = stamp_of(list_.get()); stamp.ok())
        records.resize(std::min<std::uint64_t>(stamp->bytes, 4 * kRecordBytes * there_.size()));
    if (!read_all(list_.get(), 0, records)) return;
    for (ByteReader in(records); in.remaining() >= kRecordBytes;) {
        const std::uint32_t index = in.u32(), crc = in.u32();
        if (index >= there_.size() || there_[index]) continue;
        const std::span<std::byte> bytes = std::span(block).first(size_of(index));
        if (read_all(bytes_.get(), index * kBlockBytes, bytes).ok() && crc32c(bytes) == crc) there_[index] = true;
    }
}

std::uint64_t CachedFile::size_of(std::uint64_t block) const {
    return std::min(kBlockBytes, file_bytes_ - block * kBlockBytes);
}

bool CachedFile::has(std::uint64_t offset, std::uint64_t length) const {
    if (length == 0) return true;
    if (offset >= file_bytes_ || length > file_bytes_ - offset) return false;
    for (std::uint64_t block = offset / kBlockBytes; block * kBlockBytes < offset + length; ++block)
        if (!has_block(block)) return false;
    return true;
}

Result<void> CachedFile::put(std::uint64_t offset, ByteSpan bytes) {
    for (std::uint64_t block = offset / kBlockBytes; block < there_.size() && bytes.size() >= size_of(block); ++block) {
        const ByteSpan one = bytes.first(size_of(block));
        bytes = bytes.subspan(one.size());
        if (there_[block]) continue;
        if (Result<void> r = write_all(bytes_.get(), block * kBlockBytes, one); !r) return r;
        ByteWriter record;
        record.u32(static_cast<std::uint32_t>(block));
        record.u32(crc32c(one));
        const Bytes line = record.take();
        if (::lseek(list_.get(), 0, SEEK_END) < 0 ||
            ::write(list_.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
            return io_error("write to the cache");
        there_[block].store(true, std::memory_order_release);
    }
    return {};
}

Result<void> CachedFile::read(std::uint64_t offset, std::span<std::byte> out) const {
    if (!has(offset, out.size())) return Error{Errc::Io, offset, "these bytes are not in the cache"};
    return read_all(bytes_.get(), offset, out);
}

}  // namespace mvw::server
