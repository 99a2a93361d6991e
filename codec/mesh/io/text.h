// Lines, words and numbers of text formats, without copies and without locale.
#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "codec/bytes.h"

namespace mvw {

inline std::string_view as_text(ByteSpan bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
inline ByteSpan as_bytes(std::string_view text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

/// Cuts the next word off the front of `text`; empty where only blanks are left.
inline std::string_view next_word(std::string_view& text) {
    std::size_t begin = 0;
    while (begin < text.size() && is_blank(text[begin])) ++begin;
    std::size_t end = begin;
    while (end < text.size() && !is_blank(text[end])) ++end;
    const std::string_view word = text.substr(begin, end - begin);
    text.remove_prefix(end);
    return word;
}

/// The whole word as a number, correctly rounded; infinity and NaN are numbers, overflow is infinity.
inline std::optional<double> to_number(std::string_view word) {
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || end != word.data() + word.size()) return {};
    if (error == std::errc::result_out_of_range) {
        // Libraries differ in what they leave in `value`: tell too large from too small by the exponent's sign.
        const std::size_t exponent = word.find_last_of("eE");
        const bool tiny = exponent != std::string_view::npos && exponent + 1 < word.size() && word[exponent + 1] == '-';
        return tiny ? 0.0 : HUGE_VAL;
    }
    if (error != std::errc{}) return {};
    return value;
}

/// Cuts the next line off the front of `text`, without its end (LF, CR LF or CR).
inline std::string_view next_line(std::string_view& text) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    const bool pair = text.substr(end, 2) == "\r\n";
    text.remove_prefix(std::min(text.size(), end + (pair ? 2 : 1)));
    return line;
}

/// Lines that say something, counted: blank ones and what follows a '#' are left out.
class Lines {
 public:
    explicit Lines(std::string_view text) : text_(text) {}
    /// The next line, or an empty one at the end.
    std::string_view next() {
        while (!text_.empty()) {
            std::string_view line = next_line(text_);
            ++number_;
            line = line.substr(0, line.find('#'));
            std::string_view rest = line;
            if (!next_word(rest).empty()) return line;
        }
        return {};
    }
    [[nodiscard]] std::size_t number() const { return number_; }  // of the line given last, from 1
    [[nodiscard]] std::size_t remaining() const { return text_.size(); }

 private:
    std::string_view text_;
    std::size_t number_ = 0;
};

}  // namespace mvw
