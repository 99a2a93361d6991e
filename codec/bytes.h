// Little-endian readers and writers over byte buffers. Reading past the end gives zeros and is remembered: ask once.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "codec/result.h"

namespace mvw {

using Bytes = std::vector<std::byte>;
using ByteSpan = std::span<const std::byte>;

/// Reads fields in disk order from a span that outlives it. After a read past the end every read gives 0 and ok() is
/// false, so a parser asks once at its end instead of once a field.
class ByteReader {
 public:
    explicit ByteReader(ByteSpan bytes) : bytes_(bytes) {}

    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] std::size_t offset() const { return offset_; }
    [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }
    /// NeedMoreData at the present offset: what a reader that ran past the end returns.
    [[nodiscard]] Error error() const { return {Errc::NeedMoreData, offset_, "the data ends too early"}; }

    std::uint8_t u8() { return read<std::uint8_t>(); }
    std::uint16_t u16() { return read<std::uint16_t>(); }
    std::uint32_t u32() { return read<std::uint32_t>(); }
    std::uint64_t u64() { return read<std::uint64_t>(); }
    float f32() { return std::bit_cast<float>(u32()); }
    double f64() { return std::bit_cast<double>(u64()); }
    /// LEB128, at most 10 bytes; a longer or overflowing one counts as a read past the end.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64; shift += 7) {
            const std::uint8_t byte = u8();
            if (shift == 63 && byte > 1) break;
            value |= std::uint64_t{byte & 0x7Fu} << shift;
            if (byte < 0x80) return ok_ ? value : 0;
        }
        ok_ = false;
        return 0;
    }
    /// The next n bytes, or an empty span and ok() == false where fewer are left.
    ByteSpan bytes(std::size_t n) {
        if (!ok_ || n > remaining()) return ok_ = false, ByteSpan{};
        offset_ += n;
        return bytes_.subspan(offset_ - n, n);
    }

 private:
    template <typename T>
    T read() {
        static_assert(std::endian::native == std::endian::little, "big-endian hosts need a byte swap here");
        T value{};
        if (const ByteSpan b = bytes(sizeof(T)); b.size() == sizeof(T)) std::memcpy(&value, b.data(), sizeof(T));
        return value;
    }
    ByteSpan bytes_;
    std::size_t offset_ = 0;
    bool ok_ = true;
};

/// Appends fields in disk order to a buffer that it owns.
class ByteWriter {
 public:
    void u8(std::uint8_t v) { write(v); }
    void u16(std::uint16_t v) { write(v); }
    void u32(std::uint32_t v) { write(v); }
    void u64(std::uint64_t v) { write(v); }
    void f32(float v) { write(std::bit_cast<std::uint32_t>(v)); }
    void f64(double v) { write(std::bit_cast<std::uint64_t>(v)); }
    void varint(std::uint64_t v) {
        for (; v >= 0x80; v >>= 7) u8(static_cast<std::uint8_t>(v | 0x80));
        u8(static_cast<std::uint8_t>(v));
    }
    void bytes(ByteSpan b) { out_.insert(out_.end(), b.begin(), b.end()); }

    [[nodiscard]] std::size_t size() const { return out_.size(); }
    [[nodiscard]] const Bytes& view() const { return out_; }
    [[nodiscard]] Bytes take() { return std::move(out_); }

 private:
    template <typename T>
    void write(T value) {
        static_assert(std::is_unsigned_v<T>);
        const std::size_t at = out_.size();
        out_.resize(at + sizeof(T));
        std::memcpy(out_.data() + at, &value, sizeof(T));
    }
    Bytes out_;
};

}  // namespace mvw
