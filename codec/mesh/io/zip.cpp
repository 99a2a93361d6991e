#include "codec/mesh/io/zip.h"

#include <zip.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/text.h"

namespace mvw {

namespace {

constexpr std::size_t kPiece = 1u << 16;
/// An archive's end has this signature, and lies within so many bytes of the file's. libzip reads the whole directory
/// again for each place that looks like it: a hostile file would keep it busy for minutes.
constexpr std::string_view kSignatureOfEnd = "PK\5\6";
constexpr std::size_t kFarthestEnd = 65'557, kMostEnds = 16;

std::size_t ends_of(ByteSpan bytes) {
    std::string_view text = as_text(bytes.last(std::min(bytes.size(), kFarthestEnd)));
    std::size_t count = 0;
    for (std::size_t at = text.find(kSignatureOfEnd); at != text.npos; at = text.find(kSignatureOfEnd, at + 1)) ++count;
    return count;
}

/// What libzip does not know is no damage.
Errc code_of(zip_error_t* error) {
    switch (zip_error_code_zip(error)) {
        case ZIP_ER_COMPNOTSUPP:
        case ZIP_ER_ENCRNOTSUPP:
        case ZIP_ER_NOPASSWD:
            return Errc::Unsupported;
        default:
            return Errc::Malformed;
    }
}

struct CloseFile {
    void operator()(zip_file_t* file) const { zip_fclose(file); }
};

}  // namespace

void ZipArchive::Discard::operator()(zip* archive) const {
    zip_discard(archive);
}

Result<ZipArchive> ZipArchive::open(ByteSpan bytes) {
    if (ends_of(bytes) > kMostEnds) return malformed("is no ZIP archive: it ends in too many places");
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    zip_t* archive = source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
    if (archive != nullptr) return ZipArchive(archive);
    if (source != nullptr) zip_source_free(source);
    std::string reason = std::string("is no ZIP archive: ") + zip_error_strerror(&error);
    zip_error_fini(&error);
    return malformed(std::move(reason));
}

bool ZipArchive::has(const std::string& name) const {
    return zip_name_locate(archive_.get(), name.c_str(), ZIP_FL_NOCASE) >= 0;
}

Result<void> ZipArchive::read(const std::string& name, std::uint64_t most,
                              const std::function<Result<void>(ByteSpan)>& take) const {
    const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen(archive_.get(), name.c_str(), ZIP_FL_NOCASE));
    if (!file)
        return Error{code_of(zip_get_error(archive_.get())), 0,
                     std::string("cannot be read: ") + zip_strerror(archive_.get())};
    std::vector<std::byte> piece(kPiece);
    for (std::uint64_t sum = 0;;) {
        const zip_int64_t n = zip_fread(file.get(), piece.data(), piece.size());
        if (n < 0) return malformed(std::string("is damaged: ") + zip_file_strerror(file.get()));
        if (n == 0) return {};
        sum += static_cast<std::uint64_t>(n);
        if (sum > most) return Error{Errc::LimitExceeded, 0, "is too long for its archive"};
        if (const auto done = take(ByteSpan(piece).first(static_cast<std::size_t>(n))); !done) return done;
    }
}

}  // namespace mvw
