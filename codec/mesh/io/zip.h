// Files inside a ZIP archive, by libzip.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "codec/bytes.h"
#include "codec/result.h"

struct zip;

namespace mvw {

class ZipArchive {
 public:
    /// bytes: must outlive this. Malformed where they are no archive.
    static Result<ZipArchive> open(ByteSpan bytes);

    /// Names are told apart as packages of documents do it: not by upper and lower case.
    [[nodiscard]] bool has(const std::string& name) const;
    /// Hands out a file piece by piece until `take` fails, whose error is passed on; errors do not name it. Malformed
    /// where there is no such file or it is damaged, Unsupported where it is encrypted or packed in another way than is
    /// known, LimitExceeded where it is longer than `most`.
    [[nodiscard]] Result<void> read(const std::string& name, std::uint64_t most,
                                    const std::function<Result<void>(ByteSpan)>& take) const;

 private:
    struct Discard {
        void operator()(zip* archive) const;
    };
    explicit ZipArchive(zip* archive) : archive_(archive) {}

    std::unique_ptr<zip, Discard> archive_;
};

}  // namespace mvw
