#include "codec/mesh/io/xml.h"

#include <expat.h>
#include <fmt/format.h>

#include <string>
#include <tuple>
#include <utility>

#include "codec/mesh/io/text.h"

namespace mvw {

namespace {

constexpr char kBehindSpace = '|';  // no URI has one

std::pair<std::string_view, std::string_view> split(std::string_view qualified) {
    const std::size_t at = qualified.rfind(kBehindSpace);
    if (at == std::string_view::npos) return {{}, qualified};
    return {qualified.substr(0, at), qualified.substr(at + 1)};
}

}  // namespace

XmlElement::XmlElement(std::string_view qualified, const char** attributes) : attributes_(attributes) {
    std::tie(space, name) = split(qualified);
}

std::optional<std::string_view> XmlElement::attribute(std::string_view wanted, std::string_view space_part) const {
    for (const char** a = attributes_; a != nullptr && a[0] != nullptr; a += 2) {
        const auto [in, called] = split(a[0]);
        if (called != wanted || in.empty() != space_part.empty() || in.find(space_part) == in.npos) continue;
        std::string_view value = a[1];
        while (!value.empty() && is_blank(value.front())) value.remove_prefix(1);
        while (!value.empty() && is_blank(value.back())) value.remove_suffix(1);
        return value;
    }
    return {};
}

struct XmlReader::State {
    XmlHandlers handlers;
    XML_Parser parser;
    Result<void> stopped;

    void stop(Error error) {
        error.message = fmt::format("line {}: {}", XML_GetCurrentLineNumber(parser), error.message);
        if (stopped) stopped = std::move(error);
        XML_StopParser(parser, XML_FALSE);
    }
    static State& of(void* data) { return *static_cast<State*>(data); }
};

XmlReader::XmlReader(XmlHandlers handlers) : state_(std::make_unique<State>()) {
    state_->handlers = std::move(handlers);
    state_->parser = XML_ParserCreateNS(nullptr, kBehindSpace);
    XML_SetUserData(state_->parser, state_.get());
    XML_SetElementHandler(
        state_->parser,
        [](void* data, const char* name, const char** attributes) {
            State& s = State::of(data);
            if (auto done = s.handlers.begin(XmlElement(name, attributes)); !done) s.stop(done.error());
        },
        [](void* data, const char* name) {
            State& s = State::of(data);
            if (s.handlers.end) s.handlers.end(XmlElement(name, nullptr));
        });
    XML_SetStartDoctypeDeclHandler(state_->parser, [](void* data, const char*, const char*, const char*, int) {
        State::of(data).stop({Errc::Unsupported, 0, "declares a document type, which is not known"});
    });
}

XmlReader::~XmlReader() {
    XML_ParserFree(state_->parser);
}

Result<void> XmlReader::feed(ByteSpan bytes, bool is_last) {
    XML_Parser parser = state_->parser;
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    const XML_Status status = XML_Parse(parser, text, static_cast<int>(bytes.size()), is_last ? 1 : 0);
    if (status == XML_STATUS_OK || !state_->stopped) return state_->stopped;
    return Error{
        Errc::Malformed, 0,
        fmt::format("line {}: {}", XML_GetCurrentLineNumber(parser), XML_ErrorString(XML_GetErrorCode(parser)))};
}

}  // namespace mvw
