// A table of results, written as csv for programs and as Markdown for people.
#pragma once
#include <string>
#include <vector>

#include "codec/result.h"

namespace mvw::bench {

struct Table {
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;  // as many cells as head each

    [[nodiscard]] std::string csv() const;       // RFC 4180: cells with commas, quotes or line breaks are quoted
    [[nodiscard]] std::string markdown() const;  // bars in cells are escaped
};

/// `text` as a whole file, beside its final name first. Io names the path.
Result<void> write_text_file(const std::string& path, const std::string& text);

}  // namespace mvw::bench
