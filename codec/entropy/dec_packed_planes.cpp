#include <zstd.h>

#include <algorithm>
#include <memory>

#include "codec/entropy/packed_planes.h"

namespace mvw {

namespace {

struct FreeContext {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// Blocks are small and many: a context of their own would cost each more than its bytes.
ZSTD_DCtx* this_threads_context() {
    thread_local std::unique_ptr<ZSTD_DCtx, FreeContext> context;
    if (!context) context.reset(ZSTD_createDCtx());
    return context.get();
}

/// kWidth: bytes of a word where that is known beforehand, else 0. A loop that the compiler makes vectors of.
template <std::size_t kWidth>
void unpack(ByteSpan raw, unsigned top, unsigned low, std::span<std::uint32_t> entries) {
    const std::size_t width = kWidth == 0 ? packed_width(top, low) : kWidth, size = entries.size();
    const std::uint32_t mask = (std::uint32_t{2} << (top - low)) - 1;
    const std::byte* const from = raw.data();
    std::uint32_t* const to = entries.data();
    for (std::size_t i = 0; i < size; ++i) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < width; ++k) word |= std::to_integer<std::uint32_t>(from[k * size + i]) << (8 * k);
        const std::uint32_t bits = (word >> 1) & mask;
        const std::uint32_t says_sign = std::uint32_t{to[i] == 0} & std::uint32_t{bits != 0};
        to[i] |= bits << (low + 1) | (word & says_sign);
    }
}

}  // namespace

bool is_packed_planes(ByteSpan packed, std::size_t entries, unsigned top, unsigned low) {
    return ZSTD_getFrameContentSize(packed.data(), packed.size()) == entries * packed_width(top, low) &&
           ZSTD_findFrameCompressedSize(packed.data(), packed.size()) == packed.size();
}

bool unzip_planes(ByteSpan packed, std::size_t entries, unsigned top, unsigned low, Bytes& raw) {
    const std::size_t size = entries * packed_width(top, low);
    if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size) return false;
    raw.resize(size);
    ZSTD_DCtx* const context = this_threads_context();
    return context != nullptr &&
           ZSTD_decompressDCtx(context, raw.data(), raw.size(), packed.data(), packed.size()) == raw.size();
}

void unpack_planes(ByteSpan raw, unsigned top, unsigned low, std::span<std::uint32_t> entries) {
    const std::size_t width = kSmall ? 0 : packed_width(top, low);
    if (width == 1) return unpack<1>(raw, top, low, entries);
    if (width == 2) return unpack<2>(raw, top, low, entries);
    if (width == 3) return unpack<3>(raw, top, low, entries);
    unpack<0>(raw, top, low, entries);
}

}  // namespace mvw
