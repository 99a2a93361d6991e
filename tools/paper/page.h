// An HTML page with its pictures and the JSON of its numbers, in one folder.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/viewer/image.h"
#include "codec/result.h"

namespace mvw::paper {

class Page {
 public:
    Page(std::string folder, std::string title) : folder_(std::move(folder)), title_(std::move(title)) {}

    void heading(const std::string& text);
    /// A paragraph; `html` as it is.
    void text(const std::string& html);
    /// What the paper says, set apart.
    void quote(const std::string& html);
    /// How ours stands to it, set apart.
    void verdict(const std::string& html);
    /// Cells as they are; the first column is set left, the others right.
    void table(const std::string& caption, const std::vector<std::string>& head,
               const std::vector<std::vector<std::string>>& rows);
    /// Writes the picture or plot as NAME.png or NAME.svg. Plots stand two to a row.
    Result<void> picture(const std::string& name, const Image& image, const std::string& caption);
    Result<void> plot(const std::string& name, const std::string& svg, const std::string& caption);
    /// The same for a picture that is written already, under its file's name.
    void show(const std::string& file, const std::string& caption);
    [[nodiscard]] std::string path(const std::string& file) const { return folder_ + "/" + file; }

    /// The numbers, by section.
    nlohmann::ordered_json numbers = nlohmann::ordered_json::object();

    /// index.html and paper.json.
    Result<void> save();

 private:
    std::string folder_, title_, body_;
};

/// A number with so many significant digits, without exponents where that reads well.
std::string digits(double value, int significant = 3);

}  // namespace mvw::paper
