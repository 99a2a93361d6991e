// What an HTTP request gets, as a function: requests in, answers out, no socket. PROTOCOL.md 8 is normative; ranges and
// conditions follow RFC 9110.
#pragma once
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/catalogue.h"
#include "server/metrics.h"

namespace mvw::server {

/// The fields of a request that matter; empty where absent.
struct HttpRequest {
    std::string method{}, target{};
    std::string range{}, if_range{}, if_none_match{}, authorization{}, accept_encoding{};
};

/// Status, header fields and body: `text`, or `length` bytes of `source` from `offset`.
struct HttpReply {
    unsigned status = 200;
    std::vector<std::pair<std::string_view, std::string>>
        fields;  // names are literals; Content-Length is not among them
    std::string text;
    std::shared_ptr<const ByteSource> source;
    std::uint64_t offset = 0, length = 0;  // length: of the body, also where HEAD leaves it out
    bool without_body = false;             // HEAD, 204, 304
    std::string waits_for{};               // a model that is being looked up: no reply yet, ask again once it is known

    /// Status line and header fields, with the empty line at the end.
    [[nodiscard]] std::string head(bool keep_alive) const;
};

/// A reply of one line of text.
HttpReply plain_reply(unsigned status, const std::string& sentence);

/// Bytes first .. last of a body.
struct ByteRange {
    std::uint64_t first = 0, last = 0;
};
enum class RangeKind { Whole, Part, Unsatisfiable };
/// Reads a Range field against a body of `bytes`. Several ranges, other units and malformed fields count as none, as
/// RFC 9110 14.2 allows.
RangeKind parse_range(std::string_view field, std::uint64_t bytes, ByteRange& range);

/// Whether an Accept-Encoding field asks for a coding by its name (RFC 9110 12.5.3), with a weight above 0.
bool accepts(std::string_view field, std::string_view coding);

/// Everything under the server's HTTP address but WebSocket. Safe to use from several threads.
class Site {
 public:
    /// `page`: folder of the web page, empty for none. All references outlive the site.
    Site(OpenModel open, CheckToken allow, Catalogue& catalogue, const Metrics& metrics, const std::string& page);

    [[nodiscard]] HttpReply answer(const HttpRequest& request) const;
    /// From now on /healthz says that the server is about to stop.
    void drain() { draining_ = true; }

 private:
    [[nodiscard]] HttpReply model(const HttpRequest& request, std::string_view path, std::string_view query) const;
    [[nodiscard]] HttpReply models(const HttpRequest& request, std::string_view query) const;
    [[nodiscard]] HttpReply page(const HttpRequest& request, std::string_view path) const;
    [[nodiscard]] HttpReply health() const;
    [[nodiscard]] HttpReply metrics() const;

    OpenModel open_;
    CheckToken allow_;
    Catalogue& catalogue_;
    const Metrics& metrics_;
    Descriptor page_;
    std::atomic<bool> draining_ = false;
    const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace mvw::server
