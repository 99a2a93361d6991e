// Byte ranges from an HTTP store, over connections that are kept. The one file of the origin that sees Beast is its
// .cpp.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>

#include <memory>
#include <string>

#include "codec/bytes.h"
#include "server/origin/store_url.h"

namespace mvw::server {

/// What the store said.
struct RangeAnswer {
    unsigned status = 0;      // 206 with the fields below; 304, 404, ... without them
    std::string validator{};  // its strong ETag, else Last-Modified; empty: it has neither
    std::uint64_t first = 0, file_bytes = 0;
    Bytes body{};
};

/// GETs with a Range. All calls on the io_context's one thread.
class HttpClient {
 public:
    /// `ca_file`: PEM file of who signs the store's certificates; empty: the system's. At most `max_connections` at
    /// once, whoever asks later waits. Io where the file cannot be read.
    static Result<std::unique_ptr<HttpClient>> make(boost::asio::io_context& io, const std::string& ca_file,
                                                    std::size_t max_connections);
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    /// Bytes `first` to `last`, or as far as the file goes. `unless`: the validator of what is known, for a 304. A
    /// store that does not answer, or with "not now", is asked again, three times in all. A store that has the file and
    /// ignores Range is an error. Io where no answer is to be had.
    boost::asio::awaitable<Result<RangeAnswer>> get(StoreUrl url, std::uint64_t first, std::uint64_t last,
                                                    std::string unless);

 private:
    class Impl;
    explicit HttpClient(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace mvw::server
