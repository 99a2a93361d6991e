#include "tools/paper/page.h"

#include <fmt/core.h>

#include "tools/bench/table.h"

namespace mvw::paper {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.55 Georgia, 'DejaVu Serif', serif; color: #222; max-width: 62rem; margin: 2.5rem auto; padding: 0 1.5rem; }
h1 { font-size: 2rem; line-height: 1.2; margin-bottom: .4rem; }
h2 { font-size: 1.35rem; margin: 3rem 0 .6rem; padding-top: 1rem; border-top: 1px solid #ccc; }
p { max-width: 46rem; }
code { font-size: .9em; }
blockquote { margin: 1rem 0; padding: .1rem 1rem; border-left: 4px solid #c9c2b4; background: #f7f5f0; max-width: 46rem; }
.verdict { margin: 1rem 0; padding: .1rem 1rem; border-left: 4px solid #1f5fa8; background: #eef4fb; max-width: 46rem; }
table { border-collapse: collapse; margin: 1.2rem 0; font: 14px/1.4 'DejaVu Sans', sans-serif; font-variant-numeric: tabular-nums; }
caption { caption-side: top; text-align: left; font-weight: bold; padding-bottom: .4rem; }
th, td { padding: .25rem .8rem; text-align: right; border-bottom: 1px solid #e2e2e2; }
th { border-bottom: 2px solid #999; font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-left: 0; white-space: nowrap; }
figure { margin: 1.4rem 0; }
figure.half { display: inline-block; width: 49%; margin: .6rem 0; vertical-align: top; }
figure img { max-width: 100%; height: auto; }
figcaption { font-size: .9rem; color: #444; max-width: 46rem; }
)";

}  // namespace

void Page::heading(const std::string& text) {
    body_ += "<h2>" + text + "</h2>\n";
}
void Page::text(const std::string& html) {
    body_ += "<p>" + html + "</p>\n";
}
void Page::quote(const std::string& html) {
    body_ += "<blockquote><p>The paper: " + html + "</p></blockquote>\n";
}
void Page::verdict(const std::string& html) {
    body_ += "<div class=\"verdict\"><p>" + html + "</p></div>\n";
}

void Page::table(const std::string& caption, const std::vector<std::string>& head,
                 const std::vector<std::vector<std::string>>& rows) {
    body_ += "<table><caption>" + caption + "</caption>\n<tr>";
    for (const std::string& cell : head) body_ += "<th>" + cell + "</th>";
    body_ += "</tr>\n";
    for (const auto& row : rows) {
        body_ += "<tr>";
        for (const std::string& cell : row) body_ += "<td>" + cell + "</td>";
        body_ += "</tr>\n";
    }
    body_ += "</table>\n";
}

void Page::show(const std::string& file, const std::string& caption) {
    body_ +=
        fmt::format("<figure><a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\"></a><figcaption>{1}</figcaption></figure>\n",
                    file, caption);
}
Result<void> Page::picture(const std::string& name, const Image& image, const std::string& caption) {
    show(name + ".png", caption);
    return write_png(path(name + ".png"), image);
}
Result<void> Page::plot(const std::string& name, const std::string& svg, const std::string& caption) {
    body_ +=
        fmt::format("<figure class=\"half\"><img src=\"{0}.svg\" alt=\"{1}\"><figcaption>{1}</figcaption></figure>\n",
                    name, caption);
    return bench::write_text_file(path(name + ".svg"), svg);
}

Result<void> Page::save() {
    const std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>" + title_ +
                             "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + title_ + "</h1>\n" +
                             body_ + "</body>\n</html>\n";
    if (auto written = bench::write_text_file(path("paper.json"), numbers.dump(2) + "\n"); !written.ok())
        return written;
    return bench::write_text_file(path("index.html"), html);
}

std::string digits(double value, int significant) {
    const std::string text = fmt::format("{:.{}g}", value, significant);
    return text.find('e') == std::string::npos ? text : fmt::format("{:.{}e}", value, significant - 1);
}

}  // namespace mvw::paper
