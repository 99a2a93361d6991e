#include "codec/mesh/io/threemf_model.h"

#include <charconv>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/io/xml.h"

namespace mvw {

namespace {

constexpr std::size_t kMostPlaces = 1'000'000, kMostObjects = 1'000'000;

std::optional<std::uint32_t> to_index(std::optional<std::string_view> word) {
    std::uint32_t value = 0;
    if (!word) return {};
    const auto [end, error] = std::from_chars(word->data(), word->data() + word->size(), value);
    if (error != std::errc{} || end != word->data() + word->size() || value == ThreemfModel::kNoColor) return {};
    return value;
}

std::string text_of(const XmlElement& element, std::string_view attribute) {
    return std::string(element.attribute(attribute).value_or(""));
}

/// #RRGGBB or #RRGGBBAA, sRGB. Alpha 0 is not meant: nobody builds what cannot be seen, but slicers write it.
std::optional<Rgba8> to_color(std::string_view word) {
    std::uint32_t value = 0;
    if ((word.size() != 7 && word.size() != 9) || word[0] != '#') return {};
    const auto [end, error] = std::from_chars(word.data() + 1, word.data() + word.size(), value, 16);
    if (error != std::errc{} || end != word.data() + word.size()) return {};
    if (word.size() == 7) value <<= 8;
    if ((value & 0xFF) == 0) value |= 0xFF;
    const auto byte = [&](int shift) { return static_cast<std::uint8_t>(value >> shift); };
    return Rgba8{byte(24), byte(16), byte(8), byte(0)};
}

/// Twelve numbers: the images of the axes, then of the origin. None: the identity.
std::optional<Affine> to_affine(std::optional<std::string_view> words) {
    Affine out;
    if (!words) return out;
    for (std::size_t k = 0; k < 12; ++k) {
        const std::optional<double> value = to_number(next_word(*words));
        if (!value) return {};
        (k < 9 ? out.row[k % 3][k / 3] : out.shift[k % 3]) = *value;
    }
    if (!next_word(*words).empty()) return {};
    return out;
}

class ModelReader {
 public:
    Result<void> begin(const XmlElement& element) {
        const auto is_of = [&](std::string_view specification) {
            return element.space.find(specification) != std::string_view::npos;
        };
        if (is_of("/3dmanufacturing/material/")) return material(element);
        if (!element.space.empty() && !is_of("/3dmanufacturing/core/") && !is_of("/3dmanufacturing/2013/")) return {};
        if (element.name == "vertex") return vertex(element);
        if (element.name == "triangle") return triangle(element);
        if (element.name == "object") return object(element);
        if (element.name == "component") return place(element, object_ ? &object_->components : nullptr);
        if (element.name == "item") return place(element, &model_.items);
        if (element.name == "basematerials") return group(element);
        if (element.name == "base") return color(element, "displaycolor");
        return {};
    }
    void end(const XmlElement& element) {
        if (element.name == "object") object_ = nullptr;
    }
    ThreemfModel take() { return std::move(model_); }

 private:
    Result<void> material(const XmlElement& element) {
        if (element.name == "colorgroup") return group(element);
        if (element.name == "color") return color(element, "color");
        for (const char* unknown : {"texture2dgroup", "compositematerials", "multiproperties"})
            if (element.name == unknown) left_out_.insert(text_of(element, "id"));
        return {};
    }
    Result<void> group(const XmlElement& element) {
        group_ = &groups_[text_of(element, "id")];
        return {};
    }
    Result<void> color(const XmlElement& element, std::string_view attribute) {
        const std::optional<std::string_view> word = element.attribute(attribute);
        const std::optional<Rgba8> color = word ? to_color(*word) : std::nullopt;
        if (group_ == nullptr) return {};
        group_->push_back(color ? static_cast<std::uint32_t>(model_.colors.size()) : ThreemfModel::kNoColor);
        if (color) model_.colors.push_back(*color);
        return {};
    }
    Result<void> object(const XmlElement& element) {
        if (model_.objects.size() == kMostObjects) return Error{Errc::LimitExceeded, 0, "there are too many objects"};
        const auto [at, is_new] = model_.objects.try_emplace(text_of(element, "id"));
        if (!is_new) return malformed("there are two objects of one id");
        object_ = &at->second;
        object_->is_other = element.attribute("type") == "other";
        group_of_object_ = text_of(element, "pid");
        color_of_object_ = to_index(element.attribute("pindex")).value_or(0);
        return {};
    }
    Result<void> vertex(const XmlElement& element) {
        if (object_ == nullptr) return {};
        Vec3 p;
        constexpr const char* kAxes[] = {"x", "y", "z"};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::optional<std::string_view> word = element.attribute(kAxes[k]);
            const std::optional<double> value = word ? to_number(*word) : std::nullopt;
            if (!value) return malformed("a vertex needs three coordinates");
            p[k] = *value;
        }
        object_->positions.push_back(p);
        return {};
    }
    Result<void> triangle(const XmlElement& element) {
        if (object_ == nullptr) return {};
        Face face{}, colors{};
        constexpr const char* kCorners[] = {"v1", "v2", "v3"};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::optional<std::uint32_t> index = to_index(element.attribute(kCorners[k]));
            if (!index) return malformed("a triangle needs three vertices");
            face[k] = *index;
        }
        const std::optional<std::string_view> own = element.attribute("pid");
        const std::string group = own ? std::string(*own) : group_of_object_;
        constexpr const char* kColors[] = {"p1", "p2", "p3"};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t before = k == 0 ? color_of_object_ : index_[0];
            index_[k] = to_index(element.attribute(kColors[k])).value_or(before);
            colors[k] = color_of(group, index_[k]);
        }
        model_.leaves_out_colors = model_.leaves_out_colors || left_out_.contains(group);
        object_->faces.push_back(face);
        object_->colors.push_back(colors);
        return {};
    }
    [[nodiscard]] std::uint32_t color_of(const std::string& group, std::uint32_t index) const {
        const auto found = groups_.find(group);
        return found != groups_.end() && index < found->second.size() ? found->second[index] : ThreemfModel::kNoColor;
    }
    Result<void> place(const XmlElement& element, std::vector<ThreemfPlace>* places) {
        const std::optional<Affine> to_outer = to_affine(element.attribute("transform"));
        if (!to_outer) return malformed("a transform needs twelve numbers");
        if (++places_ > kMostPlaces) return Error{Errc::LimitExceeded, 0, "objects are placed too often"};
        const std::optional<std::string_view> path = element.attribute("path", "/3dmanufacturing/production/");
        if (places != nullptr)
            places->push_back({std::string(path.value_or("")), text_of(element, "objectid"), *to_outer});
        return {};
    }

    ThreemfModel model_;
    ThreemfObject* object_ = nullptr;  // that is open
    std::string group_of_object_;
    std::uint32_t color_of_object_ = 0;
    Face index_{};  // in its group, of the colours of the triangle at hand
    std::map<std::string, std::vector<std::uint32_t>> groups_;
    std::vector<std::uint32_t>* group_ = nullptr;  // the last one
    std::set<std::string> left_out_;               // groups that are not known
    std::size_t places_ = 0;
};

Result<void> read_xml(const ThreemfPieces& pieces, XmlHandlers handlers) {
    XmlReader xml(std::move(handlers));
    const Result<void> done = pieces([&](ByteSpan piece) { return xml.feed(piece, false); });
    return done ? xml.feed({}, true) : done;
}

}  // namespace

Result<ThreemfModel> read_threemf_model(const ThreemfPieces& pieces) {
    ModelReader reader;
    const Result<void> done = read_xml(pieces, {[&](const XmlElement& element) { return reader.begin(element); },
                                                [&](const XmlElement& element) { reader.end(element); }});
    if (!done) return done.error();
    return reader.take();
}

Result<std::string> model_of_relationships(const ThreemfPieces& pieces) {
    std::string target;
    const auto begin = [&](const XmlElement& element) -> Result<void> {
        const std::string_view type = element.attribute("Type").value_or("");
        if (element.name == "Relationship" && type.ends_with("/3dmodel") && target.empty())
            target = text_of(element, "Target");
        return {};
    };
    const Result<void> done = read_xml(pieces, {begin, {}});
    if (!done) return done.error();
    return target;
}

}  // namespace mvw
