#include "tools/bench/table.h"

#include <span>

#include "codec/mesh/io/files.h"

namespace mvw::bench {
namespace {

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

std::string markdown_cell(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c == '\n' ? ' ' : c);
    return out;
}

}  // namespace

std::string Table::csv() const {
    std::string text;
    const auto add = [&](const std::vector<std::string>& row) {
        for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? "," : "") + csv_cell(row[i]);
        text += "\n";
    };
    add(head);
    for (const auto& row : rows) add(row);
    return text;
}

std::string Table::markdown() const {
    std::string text;
    const auto add = [&](const std::vector<std::string>& row) {
        for (const std::string& cell : row) text += "| " + markdown_cell(cell) + " ";
        text += "|\n";
    };
    add(head);
    add(std::vector<std::string>(head.size(), "---"));
    for (const auto& row : rows) add(row);
    return text;
}

Result<void> write_text_file(const std::string& path, const std::string& text) {
    return write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace mvw::bench
