// PLY, ASCII and binary of both byte orders: any scalar types, elements and properties that are not needed skipped.
//
// An own reader: OpenMesh refuses lists counted by 32-bit integers and takes a vertex "1 abc 1" or a file cut
// short in its ASCII part without a word; assimp keeps float32 only. The format is a table, so reading it is short.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/text.h"

namespace mvw {
namespace {

enum class Scalar : std::uint8_t { I8, U8, I16, U16, I32, U32, F32, F64 };
constexpr std::array<std::size_t, 8> kScalarBytes{1, 1, 2, 2, 4, 4, 4, 8};

enum class Encoding : std::uint8_t { Ascii, Little, Big };

/// What a property means here.
enum class Role : std::uint8_t { Other, X, Y, Z, Red, Green, Blue, Alpha, NormalX, NormalY, NormalZ, Corners };

struct Property {
    std::string_view name;
    Role role = Role::Other;
    Scalar type = Scalar::F32;
    bool list = false;
    Scalar count_type = Scalar::U8;
};

struct Element {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    Encoding encoding = Encoding::Ascii;
    std::vector<Element> elements;
};

std::optional<Scalar> to_scalar(std::string_view name) {
    constexpr std::array<std::array<std::string_view, 2>, 8> kNames{{{"char", "int8"},
                                                                     {"uchar", "uint8"},
                                                                     {"short", "int16"},
                                                                     {"ushort", "uint16"},
                                                                     {"int", "int32"},
                                                                     {"uint", "uint32"},
                                                                     {"float", "float32"},
                                                                     {"double", "float64"}}};
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (name == kNames[i][0] || name == kNames[i][1]) return static_cast<Scalar>(i);
    return {};
}

constexpr std::array<std::string_view, 11> kVertexNames{"",     "x",     "y",  "z",  "red", "green",
                                                        "blue", "alpha", "nx", "ny", "nz"};

/// Texture coordinates are no measurements; without their image they are of no use. named: whether a vertex has a
/// property of that name.
template <typename Named>
bool is_texture_coordinate(std::string_view name, const Named& named) {
    if (name == "u" || name == "v") return named("u") && named("v") && !named("w");
    if (name == "s" || name == "t") return named("s") && named("t");
    return name.starts_with("texture_");
}

Role role_of(std::string_view element, std::string_view name, bool list) {
    if (element == "face")
        return list && (name == "vertex_indices" || name == "vertex_index") ? Role::Corners : Role::Other;
    if (element != "vertex" || list) return Role::Other;
    for (std::size_t i = 1; i < kVertexNames.size(); ++i)
        if (name == kVertexNames[i]) return static_cast<Role>(i);
    return Role::Other;
}

Result<Property> read_property(std::string_view line, std::string_view element) {
    Property property;
    std::string_view word = next_word(line);
    property.list = word == "list";
    if (property.list) {
        const auto count_type = to_scalar(next_word(line));
        if (!count_type || *count_type >= Scalar::F32) return malformed("the header has a list counted by no integer");
        property.count_type = *count_type;
        word = next_word(line);
    }
    const auto type = to_scalar(word);
    if (!type) return malformed("the header has a property of an unknown type");
    property.type = *type;
    property.name = next_word(line);
    if (property.name.empty()) return malformed("the header has a property without a name");
    property.role = role_of(element, property.name, property.list);
    return property;
}

Result<Header> read_header(std::string_view& text) {
    Header header;
    if (next_line(text) != "ply") return malformed("does not begin with ply");
    bool has_format = false;
    for (;;) {
        if (text.empty()) return malformed("is truncated: no end_header");
        std::string_view line = next_line(text);
        const std::string_view word = next_word(line);
        if (word == "end_header") break;
        if (word == "format") {
            const std::string_view name = next_word(line);
            has_format = name == "ascii" || name == "binary_little_endian" || name == "binary_big_endian";
            header.encoding = name == "ascii"                  ? Encoding::Ascii
                              : name == "binary_little_endian" ? Encoding::Little
                                                               : Encoding::Big;
        } else if (word == "element") {
            const std::string_view name = next_word(line);
            const auto count = to_number(next_word(line));
            if (!count || !(*count >= 0) || *count >= 4294967295.0) return malformed("the header has a wrong count");
            header.elements.push_back({name, static_cast<std::uint64_t>(*count), {}});
        } else if (word == "property") {
            if (header.elements.empty()) return malformed("the header has a property of no element");
            const Result<Property> property = read_property(line, header.elements.back().name);
            if (!property) return property.error();
            header.elements.back().properties.push_back(*property);
        }
    }
    if (!has_format) return malformed("the header names no known format");
    return header;
}

/// Values in file order, whatever the encoding. After a failure every value is 0 and failed() is true.
class Values {
 public:
    Values(std::string_view body, Encoding encoding) : body_(body), encoding_(encoding) {}

    double next(Scalar type) {
        if (encoding_ == Encoding::Ascii) {
            const auto value = to_number(next_word(body_));
            failed_ = failed_ || !value;
            return failed_ ? 0.0 : *value;
        }
        const std::size_t size = kScalarBytes[static_cast<std::size_t>(type)];
        if (failed_ || body_.size() < size) return failed_ = true, 0.0;
        std::array<char, 8> raw{};
        std::memcpy(raw.data(), body_.data(), size);
        if (encoding_ == Encoding::Big) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
        body_.remove_prefix(size);
        return decode(raw, type);
    }
    /// Bytes that a value of this type takes at least: 2 in ASCII (but the last, which may lack its blank).
    [[nodiscard]] std::size_t least_bytes(Scalar type) const {
        return encoding_ == Encoding::Ascii ? 2 : kScalarBytes[static_cast<std::size_t>(type)];
    }
    [[nodiscard]] bool failed() const { return failed_; }
    [[nodiscard]] std::size_t remaining() const { return body_.size() + 1; }
    void fail() { failed_ = true; }

 private:
    template <typename T>
    static double as(const std::array<char, 8>& raw) {
        T value;
        std::memcpy(&value, raw.data(), sizeof(T));
        return static_cast<double>(value);
    }
    static double decode(const std::array<char, 8>& raw, Scalar type) {
        switch (type) {
            case Scalar::I8:
                return as<std::int8_t>(raw);
            case Scalar::U8:
                return as<std::uint8_t>(raw);
            case Scalar::I16:
                return as<std::int16_t>(raw);
            case Scalar::U16:
                return as<std::uint16_t>(raw);
            case Scalar::I32:
                return as<std::int32_t>(raw);
            case Scalar::U32:
                return as<std::uint32_t>(raw);
            case Scalar::F32:
                return as<float>(raw);
            case Scalar::F64:
                return as<double>(raw);
        }
        return 0;
    }

    std::string_view body_;
    Encoding encoding_;
    bool failed_ = false;
};

std::uint32_t to_index(double value) {
    return value >= 0 && value < 4294967295.0 && value == std::floor(value) ? static_cast<std::uint32_t>(value)
                                                                            : kBadIndex;
}

/// A colour channel of any type: floating-point ones are fractions of 1, 16-bit ones of 65535.
std::uint8_t to_channel(double value, Scalar type) {
    if (type == Scalar::F32 || type == Scalar::F64) value *= 255;
    if (type == Scalar::U16) value /= 257;
    return static_cast<std::uint8_t>(std::lround(std::isfinite(value) ? std::clamp(value, 0.0, 255.0) : 0.0));
}

/// One list; its corners go to `corners` where that is not null.
void read_list(Values& values, const Property& property, std::vector<std::uint32_t>* corners) {
    const double count = values.next(property.count_type);
    // Checked before the loop: a short file cannot make it long.
    const std::size_t most = values.remaining() / values.least_bytes(property.type);
    if (!(count >= 0) || count > static_cast<double>(most)) return values.fail();
    for (auto left = static_cast<std::size_t>(std::ceil(count)); left > 0; --left) {
        const std::uint32_t index = to_index(values.next(property.type));
        if (corners != nullptr) corners->push_back(index);
    }
}

bool has_role(const Element& element, Role role) {
    return std::any_of(element.properties.begin(), element.properties.end(),
                       [&](const Property& p) { return p.role == role; });
}

/// What vertices have beside positions.
struct VertexLayout {
    bool colored = false;
    std::optional<std::size_t> normals;             // which field of the polygons they are
    std::vector<std::optional<std::size_t>> field;  // of each property: likewise
};

VertexLayout layout_of(const Element& element, Polygons& out) {
    VertexLayout layout;
    const auto has = [&](Role role) { return has_role(element, role); };
    layout.colored = has(Role::Red) && has(Role::Green) && has(Role::Blue);
    if (has(Role::NormalX) && has(Role::NormalY) && has(Role::NormalZ))
        layout.normals = field_of(out, FieldKind::Normals, "");
    const auto named = [&](std::string_view name) {
        return std::ranges::find(element.properties, name, &Property::name) != element.properties.end();
    };
    for (const Property& p : element.properties) {
        layout.field.emplace_back();
        const bool other = p.role == Role::Other;
        const bool kept = other && !p.list && !is_texture_coordinate(p.name, named);
        if (kept) layout.field.back() = field_of(out, FieldKind::Scalar, p.name);
        if (other && !kept) drop_field(out, std::string(p.name.substr(0, kMaxFieldName)));
    }
    return layout;
}

void read_vertex(Values& values, const Element& element, const VertexLayout& layout, Polygons& out) {
    Vec3 p;
    std::array<double, 3> normal{};
    Rgba8 color;
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& property = element.properties[k];
        if (property.list) {
            read_list(values, property, nullptr);
            continue;
        }
        const double value = values.next(property.type);
        if (layout.field[k]) set_value(out.fields[*layout.field[k]], out.positions.size(), {&value, 1});
        const std::size_t role = static_cast<std::size_t>(property.role);
        if (property.role >= Role::X && property.role <= Role::Z) p[role - static_cast<std::size_t>(Role::X)] = value;
        if (property.role == Role::Red) color.r = to_channel(value, property.type);
        if (property.role == Role::Green) color.g = to_channel(value, property.type);
        if (property.role == Role::Blue) color.b = to_channel(value, property.type);
        if (property.role == Role::Alpha) color.a = to_channel(value, property.type);
        if (property.role >= Role::NormalX && property.role <= Role::NormalZ)
            normal[role - static_cast<std::size_t>(Role::NormalX)] = value;
    }
    if (layout.normals) set_value(out.fields[*layout.normals], out.positions.size(), normal);
    out.positions.push_back(p);
    if (layout.colored) out.colors.push_back(color);
}

Result<void> read_element(Values& values, const Element& element, Polygons& out) {
    const bool vertex = element.name == "vertex", face = element.name == "face";
    if (vertex && !(has_role(element, Role::X) && has_role(element, Role::Y) && has_role(element, Role::Z)))
        return malformed("vertices have no x, y and z");
    if (face && !has_role(element, Role::Corners)) return malformed("faces have no vertex_indices");
    std::uint64_t least = 0;  // bytes of one row
    for (const Property& p : element.properties) least += values.least_bytes(p.list ? p.count_type : p.type);
    if (least == 0) return {};  // rows without content take no bytes
    if (element.count > values.remaining() / least)
        return malformed(
            fmt::format("is truncated: {} rows of element {} do not fit into its bytes", element.count, element.name));
    VertexLayout layout;
    if (vertex) {
        layout = layout_of(element, out);
        out.positions.reserve(element.count);
    }
    if (face) out.starts.reserve(element.count + 1);
    for (std::uint64_t row = 0; row < element.count; ++row) {
        if (vertex) {
            read_vertex(values, element, layout, out);
        } else {
            for (const Property& p : element.properties) {
                if (p.list)
                    read_list(values, p, p.role == Role::Corners ? &out.corners : nullptr);
                else
                    values.next(p.type);
            }
            if (face) out.end_polygon();
        }
        if (values.failed())
            return malformed(fmt::format("is truncated or damaged at row {} of element {}", row, element.name));
    }
    return {};
}

}  // namespace

Result<Polygons> read_ply(ByteSpan bytes) {
    std::string_view text = as_text(bytes);
    const Result<Header> header = read_header(text);
    if (!header) return header.error();
    Polygons out;
    Values values(text, header->encoding);
    for (const Element& element : header->elements)
        if (const Result<void> done = read_element(values, element, out); !done) return done.error();
    return out;
}

namespace {

/// Names of scalars' properties: none that means something else to readers, none twice.
class PropertyNames {
 public:
    explicit PropertyNames(const std::vector<VertexField>& fields) : fields_(fields) {}

    std::string take(const std::string& name) {
        std::string out = name.starts_with("texture_") ? "_" + name : name;
        while (means_something(out) || !taken_.insert(out).second) out += '_';
        return out;
    }

 private:
    [[nodiscard]] bool means_something(std::string_view name) const {
        const auto named = [&](std::string_view n) {
            return std::ranges::find(fields_, n, &VertexField::name) != fields_.end();
        };
        return std::ranges::find(kVertexNames, name) != kVertexNames.end() || is_texture_coordinate(name, named);
    }
    const std::vector<VertexField>& fields_;
    std::set<std::string> taken_;
};

std::string field_header(const VertexField& field, PropertyNames& names) {
    if (field.kind == FieldKind::Normals) return "property float nx\nproperty float ny\nproperty float nz\n";
    return fmt::format("property {} {}\n", needs_double(field) ? "double" : "float", names.take(field.name));
}

}  // namespace

Bytes write_ply(const Mesh& mesh) {
    const bool wide = needs_double(mesh);
    const char* type = wide ? "double" : "float";
    std::string head = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {0}\nproperty {1} x\nproperty {1} y\nproperty {1} z\n",
        mesh.positions.size(), type);
    if (!mesh.colors.empty())
        for (const char* channel : {"red", "green", "blue", "alpha"})
            head += fmt::format("property uchar {}\n", channel);
    PropertyNames names(mesh.fields);
    for (const VertexField& field : mesh.fields) head += field_header(field, names);
    head += fmt::format("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", mesh.faces.size());

    std::vector<std::uint8_t> wide_fields;
    for (const VertexField& field : mesh.fields) wide_fields.push_back(needs_double(field));

    ByteWriter out;
    out.bytes(as_bytes(head));
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (wide)
                out.f64(mesh.positions[v][k]);
            else
                out.f32(static_cast<float>(mesh.positions[v][k]));
        }
        if (!mesh.colors.empty()) {
            const Rgba8& c = mesh.colors[v];
            for (const std::uint8_t channel : {c.r, c.g, c.b, c.a}) out.u8(channel);
        }
        for (std::size_t k = 0; k < mesh.fields.size(); ++k)
            for (std::size_t c = mesh.fields[k].components() * v; c < mesh.fields[k].components() * (v + 1); ++c)
                wide_fields[k] ? out.f64(mesh.fields[k].values[c])
                               : out.f32(static_cast<float>(mesh.fields[k].values[c]));
    }
    for (const Face& f : mesh.faces) {
        out.u8(3);
        for (const std::uint32_t v : f) out.u32(v);
    }
    return out.take();
}

}  // namespace mvw
