#include "server/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/protocol/percent.h"

namespace mvw::server {
namespace {

constexpr std::string_view kModels = "/models/";
constexpr const char* kImmutable = "public, max-age=31536000, immutable";
constexpr const char* kRevalidate = "public, no-cache";
// Nothing but our own scripts; WebAssembly may be compiled, text may not be evaluated.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const char* reason_of(unsigned status) {
    switch (status) {
        case 200:
            return "OK";
        case 204:
            return "No Content";
        case 206:
            return "Partial Content";
        case 304:
            return "Not Modified";
        case 400:
            return "Bad Request";
        case 401:
            return "Unauthorized";
        case 403:
            return "Forbidden";
        case 404:
            return "Not Found";
        case 405:
            return "Method Not Allowed";
        case 408:
            return "Request Timeout";
        case 413:
            return "Content Too Large";
        case 416:
            return "Range Not Satisfiable";
        case 426:
            return "Upgrade Required";
        case 429:
            return "Too Many Requests";
        case 431:
            return "Request Header Fields Too Large";
        case 503:
            return "Service Unavailable";
        default:
            return "Internal Server Error";
    }
}

const char* type_of(std::string_view path) {
    struct Type {
        std::string_view ending;
        const char* type;
    };
    static constexpr std::array<Type, 13> kTypes{{{".html", "text/html; charset=utf-8"},
                                                  {".js", "text/javascript; charset=utf-8"},
                                                  {".mjs", "text/javascript; charset=utf-8"},
                                                  {".css", "text/css; charset=utf-8"},
                                                  {".wasm", "application/wasm"},
                                                  {".json", "application/json"},
                                                  {".map", "application/json"},
                                                  {".svg", "image/svg+xml"},
                                                  {".png", "image/png"},
                                                  {".jpg", "image/jpeg"},
                                                  {".ico", "image/x-icon"},
                                                  {".woff2", "font/woff2"},
                                                  {".txt", "text/plain; charset=utf-8"}}};
    const auto* found =
        std::find_if(kTypes.begin(), kTypes.end(), [&](const Type& t) { return path.ends_with(t.ending); });
    return found == kTypes.end() ? "application/octet-stream" : found->type;
}

// The value of one key in "a=b&c=d"; empty where it is absent.
std::string query_value(std::string_view query, std::string_view key) {
    while (!query.empty()) {
        const std::string_view pair = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(query.size(), pair.size() + 1));
        if (pair.size() > key.size() && pair.starts_with(key) && pair[key.size()] == '=')
            return protocol::percent_decode(pair.substr(key.size() + 1)).value_or("");
    }
    return {};
}

std::string token_of(const HttpRequest& request, std::string_view query) {
    constexpr std::string_view kBearer = "Bearer ";
    if (request.authorization.starts_with(kBearer)) return request.authorization.substr(kBearer.size());
    return query_value(query, "token");
}

// If-None-Match compares weakly: a list of tags, or '*'.
bool names_tag(std::string_view field, std::string_view tag) {
    while (!field.empty()) {
        std::string_view one = field.substr(0, field.find(','));
        field.remove_prefix(std::min(field.size(), one.size() + 1));
        while (one.starts_with(' ')) one.remove_prefix(1);
        while (one.ends_with(' ')) one.remove_suffix(1);
        if (one.starts_with("W/")) one.remove_prefix(2);
        if (one == "*" || one == tag) return true;
    }
    return false;
}

// A file of the page as it is sent: itself, or the packed copy beside it.
struct PageFile {
    Descriptor file;
    FileStamp stamp;
    const char* coding = nullptr;
};

std::optional<PageFile> open_page_file(int folder, const std::string& name, std::string_view accepted) {
    PageFile plain{open_below(folder, name), {}};
    Result<FileStamp> stamp = plain.file.ok() ? stamp_of(plain.file.get()) : Result<FileStamp>(Error{});
    if (!stamp) return std::nullopt;
    plain.stamp = *stamp;
    for (const auto& [coding, ending] : {std::pair("br", ".br"), std::pair("gzip", ".gz")}) {
        if (!accepts(accepted, coding)) continue;
        PageFile packed{open_below(folder, name + ending), {}, coding};
        stamp = packed.file.ok() ? stamp_of(packed.file.get()) : Result<FileStamp>(Error{});
        if (!stamp || stamp->modified_ns < plain.stamp.modified_ns) continue;  // of a file that has changed since
        packed.stamp = *stamp;
        return packed;
    }
    return plain;
}

void share(HttpReply& reply) {
    reply.fields.emplace_back("Access-Control-Allow-Origin", "*");
    reply.fields.emplace_back("Access-Control-Expose-Headers", "ETag, Content-Range, Accept-Ranges");
}

// A body that has a tag: 304 where the peer has it, else the part that it asks for.
HttpReply tagged_body(const HttpRequest& request, const std::string& tag, std::shared_ptr<const ByteSource> source,
                      std::uint64_t bytes) {
    HttpReply reply;
    reply.fields.emplace_back("ETag", tag);
    reply.fields.emplace_back("Accept-Ranges", "bytes");
    if (names_tag(request.if_none_match, tag)) {
        reply.status = 304;
        reply.without_body = true;
        return reply;
    }
    reply.source = std::move(source);
    reply.length = bytes;
    if (!request.if_range.empty() && request.if_range != tag) return reply;
    ByteRange range;
    switch (parse_range(request.range, bytes, range)) {
        case RangeKind::Whole:
            break;
        case RangeKind::Part:
            reply.status = 206;
            reply.offset = range.first;
            reply.length = range.last - range.first + 1;
            reply.fields.emplace_back("Content-Range", fmt::format("bytes {}-{}/{}", range.first, range.last, bytes));
            break;
        case RangeKind::Unsatisfiable:
            reply = plain_reply(416, "the range is not within the file");
            reply.fields.emplace_back("Content-Range", fmt::format("bytes */{}", bytes));
            break;
    }
    return reply;
}

HttpReply preflight() {
    HttpReply reply;
    reply.status = 204;
    reply.without_body = true;
    share(reply);
    reply.fields.emplace_back("Access-Control-Allow-Methods", "GET, HEAD, OPTIONS");
    reply.fields.emplace_back("Access-Control-Allow-Headers", "Range, If-Range, If-None-Match, Authorization");
    reply.fields.emplace_back("Access-Control-Max-Age", "86400");
    return reply;
}

}  // namespace

// By appending: formatting would be a tenth of what a small file costs.
std::string HttpReply::head(bool keep_alive) const {
    std::string out;
    out.reserve(512);
    out.append("HTTP/1.1 ").append(std::to_string(status)).append(" ").append(reason_of(status)).append("\r\n");
    for (const auto& [name, value] : fields) out.append(name).append(": ").append(value).append("\r\n");
    if (status != 204 && status != 304)
        out.append("Content-Length: ").append(std::to_string(source ? length : text.size())).append("\r\n");
    return out += keep_alive ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n";
}

HttpReply plain_reply(unsigned status, const std::string& sentence) {
    HttpReply reply;
    reply.status = status;
    reply.fields.emplace_back("Content-Type", "text/plain; charset=utf-8");
    reply.fields.emplace_back("Cache-Control", "no-store");
    reply.fields.emplace_back("X-Content-Type-Options", "nosniff");
    reply.text = sentence + "\n";
    return reply;
}

RangeKind parse_range(std::string_view field, std::uint64_t bytes, ByteRange& range) {
    constexpr std::string_view kUnit = "bytes=";
    if (!field.starts_with(kUnit)) return RangeKind::Whole;
    field.remove_prefix(kUnit.size());
    const std::size_t dash = field.find('-');
    if (dash == std::string_view::npos || field.size() > 40) return RangeKind::Whole;
    const auto number = [](std::string_view text) -> std::optional<std::uint64_t> {
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
        return value;
    };
    const std::optional<std::uint64_t> first = number(field.substr(0, dash)), last = number(field.substr(dash + 1));
    const bool open_end = dash + 1 == field.size();
    if (dash == 0) {  // the last so many bytes
        if (!last) return RangeKind::Whole;
        if (*last == 0 || bytes == 0) return RangeKind::Unsatisfiable;
        range = {bytes - std::min(*last, bytes), bytes - 1};
        return RangeKind::Part;
    }
    if (!first || (!last && !open_end) || (last && *last < *first)) return RangeKind::Whole;
    if (*first >= bytes) return RangeKind::Unsatisfiable;
    range = {*first, open_end ? bytes - 1 : std::min(*last, bytes - 1)};
    return RangeKind::Part;
}

bool accepts(std::string_view field, std::string_view coding) {
    while (!field.empty()) {
        std::string_view one = field.substr(0, field.find(','));
        field.remove_prefix(std::min(field.size(), one.size() + 1));
        one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
        const std::string_view name = one.substr(0, one.find_first_of("; "));
        if (name != coding) continue;
        const std::size_t weight = one.find("q=");
        return weight == std::string_view::npos || one.find_first_of("123456789", weight) != std::string_view::npos;
    }
    return false;
}

Site::Site(OpenModel open, CheckToken allow, Catalogue& catalogue, const Metrics& metrics, const std::string& page)
    : open_(std::move(open)),
      allow_(std::move(allow)),
      catalogue_(catalogue),
      metrics_(metrics),
      page_(page.empty() ? Descriptor() : open_folder(page)) {}

HttpReply Site::answer(const HttpRequest& request) const {
    const std::string_view target = request.target;
    const std::string_view raw_path = target.substr(0, target.find('?'));
    const std::string_view query = raw_path.size() == target.size() ? "" : target.substr(raw_path.size() + 1);
    const std::optional<std::string> path = protocol::percent_decode(raw_path);
    if (!path || !path->starts_with('/')) return plain_reply(400, "the target is not a path");
    if (request.method == "OPTIONS") return preflight();
    if (request.method != "GET" && request.method != "HEAD") {
        HttpReply reply = plain_reply(405, "only GET, HEAD and OPTIONS are answered");
        reply.fields.emplace_back("Allow", "GET, HEAD, OPTIONS");
        return reply;
    }
    HttpReply reply = *path == "/models" ? models(request, query)
                      : path->starts_with(kModels)
                          ? model(request, std::string_view(*path).substr(kModels.size()), query)
                      : *path == "/healthz" ? health()
                      : *path == "/metrics" ? metrics()
                                            : page(request, *path);
    if (request.method == "HEAD") reply.without_body = true;
    return reply;
}

HttpReply Site::model(const HttpRequest& request, std::string_view path, std::string_view query) const {
    const auto refuse = [](unsigned status, const std::string& sentence) {
        HttpReply reply = plain_reply(status, sentence);
        share(reply);
        return reply;
    };
    if (!path.ends_with(".mvw")) return refuse(404, "no such model");
    if (allow_) {
        const std::string token = token_of(request, query);
        if (const Result<void> allowed = allow_(token, path); !allowed)
            return refuse(token.empty() ? 401 : 403, allowed.error().message);
    }
    const Result<ModelPtr> model = open_(path);
    if (!model && model.error().code == Errc::NeedMoreData) {
        HttpReply later;
        later.waits_for = path;
        return later;
    }
    if (!model) return refuse(model.error().code == Errc::Io ? 404 : 500, model.error().message);
    const std::string version = to_hex((*model)->toc().header.content_id);
    const std::string wanted = query_value(query, "v");
    // A name with a version means those bytes for ever: others must not be kept under it.
    if (!wanted.empty() && wanted != version) return refuse(404, "the model has another version now");
    HttpReply reply = tagged_body(request, "\"" + version + "\"", *model, (*model)->file_bytes());
    if (reply.status != 416) {
        reply.fields.emplace_back("Content-Type", "model/vnd.mvw");
        const char* caching = wanted.empty() ? kRevalidate : kImmutable;
        reply.fields.emplace_back("Cache-Control", allow_ ? "private, no-cache" : caching);
    }
    share(reply);
    return reply;
}

HttpReply Site::models(const HttpRequest& request, std::string_view query) const {
    const std::string token = token_of(request, query);
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ModelSummary& m : catalogue_.list()) {
        if (allow_ && !allow_(token, m.name)) continue;
        list.push_back({{"name", m.name},
                        {"url", fmt::format("/models/{}.mvw?v={}", protocol::percent_encode(m.name), m.version)},
                        {"version", m.version},
                        {"bytes", m.bytes},
                        {"levels", m.levels},
                        {"parts", m.parts},
                        {"base_faces", m.base_faces},
                        {"faces", m.faces}});
    }
    HttpReply reply;
    reply.fields.emplace_back("Content-Type", "application/json");
    reply.fields.emplace_back("Cache-Control", allow_ ? "no-store" : "no-cache");
    share(reply);
    reply.text =
        nlohmann::ordered_json{{"models", list}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    return reply;
}

HttpReply Site::page(const HttpRequest& request, std::string_view path) const {
    std::string name(path.substr(1));
    if (name.empty() || name.ends_with('/')) name += "index.html";
    std::optional<PageFile> file;
    if (page_.ok() && is_plain_name(name)) file = open_page_file(page_.get(), name, request.accept_encoding);
    if (!file) return plain_reply(404, path == "/" && !page_.ok() ? "this server has no page" : "no such file");
    const std::string tag = fmt::format("\"{:x}-{:x}{}\"", file->stamp.modified_ns, file->stamp.bytes,
                                        file->coding == nullptr ? "" : file->coding);
    HttpReply reply =
        tagged_body(request, tag, std::make_shared<const FileSource>(std::move(file->file)), file->stamp.bytes);
    if (reply.status == 416) return reply;
    if (file->coding != nullptr) reply.fields.emplace_back("Content-Encoding", file->coding);
    reply.fields.emplace_back("Vary", "Accept-Encoding");
    reply.fields.emplace_back("Content-Type", type_of(name));
    reply.fields.emplace_back("Cache-Control", "no-cache");
    reply.fields.emplace_back("Content-Security-Policy", kPolicy);
    reply.fields.emplace_back("X-Content-Type-Options", "nosniff");
    reply.fields.emplace_back("Referrer-Policy", "no-referrer");
    return reply;
}

HttpReply Site::health() const {
    return draining_ ? plain_reply(503, "draining") : plain_reply(200, "ok");
}

HttpReply Site::metrics() const {
    HttpReply reply;
    reply.fields.emplace_back("Content-Type", "text/plain; version=0.0.4; charset=utf-8");
    reply.fields.emplace_back("Cache-Control", "no-store");
    const std::chrono::duration<double> up = std::chrono::steady_clock::now() - begun_;
    reply.text = metrics_.text(catalogue_.list().size(), up.count());
    return reply;
}

}  // namespace mvw::server
