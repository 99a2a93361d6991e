// Elements of an XML document and their attributes, by Expat, as its bytes come; text between them is passed over.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "codec/bytes.h"
#include "codec/result.h"

struct XML_ParserStruct;

namespace mvw {

/// Views of the parser's memory: while the element begins or ends.
class XmlElement {
 public:
    XmlElement(std::string_view qualified, const char** attributes);

    std::string_view space, name;  // of names: a URI, empty where there is none; and the name there
    /// By its name in a space of whose URI `space_part` is a part; as most are, in none. Without blanks around it.
    [[nodiscard]] std::optional<std::string_view> attribute(std::string_view wanted,
                                                            std::string_view space_part = {}) const;

 private:
    const char** attributes_;
};

struct XmlHandlers {
    std::function<Result<void>(const XmlElement&)> begin;
    std::function<void(const XmlElement&)> end;  // attributes: none
};

class XmlReader {
 public:
    explicit XmlReader(XmlHandlers handlers);
    ~XmlReader();
    XmlReader(const XmlReader&) = delete;
    XmlReader& operator=(const XmlReader&) = delete;

    /// The next bytes. Malformed, with the line, where they are no XML, Unsupported where they declare a document type
    /// (which may define what unfolds without end), or what a handler says; then no more may be fed.
    Result<void> feed(ByteSpan bytes, bool is_last);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mvw
