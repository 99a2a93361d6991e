// Errors as values: what every function driven by bytes, files or peers returns.
#pragma once
#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace mvw {

/// Why something failed. "More, please" is not a fault: it is never logged as one.
enum class Errc : std::uint8_t {
    NeedMoreData,     // the bytes so far are fine; call again with more
    Malformed,        // the bytes contradict FORMAT.md, PROTOCOL.md or their file type
    Unsupported,      // well formed, but a version or feature that this build does not know
    LimitExceeded,    // well formed, but larger than Limits allows; checked before allocating
    InvalidArgument,  // a parameter outside its documented range
    Io,               // the operating system or the network refused
};

/// A failure: its code, one sentence for people, and the byte where it was noticed (0 where that means nothing).
struct Error {
    Errc code = Errc::Malformed;
    std::uint64_t offset = 0;
    std::string message;
};

/// Either a T or an Error. Ask ok() first; asking for the wrong one is a bug (assert).
template <typename T>
class [[nodiscard]] Result {
 public:
    Result(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor): reads as `return value;`
    Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor): reads as `return error;`

    [[nodiscard]] bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }
    T& value() & { return assert(ok()), *std::get_if<0>(&state_); }               // NOLINT(clang-analyzer-core.*)
    const T& value() const& { return assert(ok()), *std::get_if<0>(&state_); }    // NOLINT(clang-analyzer-core.*)
    T&& value() && { return assert(ok()), std::move(*std::get_if<0>(&state_)); }  // NOLINT(clang-analyzer-core.*)
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    [[nodiscard]] const Error& error() const {
        return assert(!ok()), *std::get_if<1>(&state_);  // NOLINT(clang-analyzer-core.uninitialized.UndefReturn)
    }

 private:
    std::variant<T, Error> state_;
};

/// Success, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor): reads as `return error;`
    [[nodiscard]] bool ok() const { return !error_; }
    explicit operator bool() const { return ok(); }
    [[nodiscard]] const Error& error() const { return assert(error_), *error_; }

 private:
    std::optional<Error> error_;
};

}  // namespace mvw
