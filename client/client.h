// The client library's front door: a URL in, refinements out.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/feed.h"
#include "client/pace.h"
#include "client/url.h"
#include "client/view.h"

namespace mvw::client {

struct StreamOptions {
    Wants wants;
    std::optional<View> view{};  // as by look(); where it leaves levels out, the first request is for level 0 alone
    RetryPolicy retry;
    Limits limits;
    std::string token;
    std::string ca_file;       // PEM file of who signs servers' certificates; empty: the system's
    std::string cache_folder;  // chunks are kept there between runs; empty: nowhere
    std::uint64_t cache_bytes = 1ull << 30;
    bool keep_chunks = false;  // for Feed::file() and Feed::decoder_of()
    PacePtr pace{};            // the link is read no faster than that; null: as fast as it goes
};

/// How a stream went, up to the moment of asking.
struct Summary {
    protocol::EndReason reason = protocol::EndReason::Complete;
    std::uint64_t model_payload_bytes = 0;  // of all the model's chunks, wanted or not
    double seconds = 0;                     // from the start to the last thing that was wanted
    std::optional<double> first_mesh_seconds;
    std::uint64_t cached_bytes = 0;  // of payloads that the disk cache had
    unsigned resumed = 0;            // connections that took over from broken ones
    unsigned restarted = 0;          // times that the model changed on the server and was begun anew
};

/// What an owner may listen to; each may be empty.
struct Callbacks {
    Feed::OnRefined refined;                    // on the decoding thread
    std::function<void(const Opened&)> opened;  // on the network thread, like all that follow
    std::function<void(const Broken&)> broken;
    std::function<void()> resumed;
    std::function<void()> restarted;
};

/// One model on its way: two threads, network and decoding. All calls from any thread but those two, except want(),
/// look() and cancel(), which may come from anywhere.
class Stream {
 public:
    Stream(const Url& url, StreamOptions options, Callbacks callbacks);
    ~Stream();  // leaves the server without a word
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    /// Wants something else from now on; chunks that are held are not sent again.
    void want(Wants wants);
    /// Chooses among what is wanted for a camera from now on, as choose_tiles() does, as soon as the tiles' places are
    /// known. Goes with wants that list no tiles; more than a few times a second is of no use.
    void look(const View& view);
    /// Wants nothing more: wait() returns soon.
    void cancel();
    /// Returns when all that is wanted is decoded, or with the reason why that will never be.
    Result<Summary> wait();

    /// After wait(): what has come.
    [[nodiscard]] const Feed& feed() const;

 private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mvw::client
