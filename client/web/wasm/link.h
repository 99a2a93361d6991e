// A session of the native protocol (client/session.h) whose chunks go to a model, for a WebSocket that JavaScript
// holds.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "client/session.h"
#include "client/view.h"
#include "client/web/wasm/model.h"

namespace mvw::web {

/// What JavaScript does next. Numbers are those of src/websocket.js.
enum class Step : int {
    Nothing = 0,
    Connect = 1,
    Send = 2,   // text: the bytes
    Timer = 3,  // number: milliseconds from now
    Disconnect = 4,
    Opened = 5,
    Received = 6,   // a chunk is in the model
    Satisfied = 7,  // all is there
    Broken = 8,     // text: why; number: milliseconds until the next try
    Resumed = 9,
    Restarted = 10,  // the server has another model under this name now; the old one is gone
    Failed = 11,     // text: why; nothing more will come
};

class Link {
 public:
    Link(Model& model, std::string name, std::string token, unsigned seed)
        : model_(model), session_(std::move(name), std::move(token), {}, {}, {}, seed) {}

    // What happened, at a time in milliseconds; then next() until it is Nothing.
    void start(double now) { add(session_.start(at(now))); }
    void connected(double now) { add(session_.on_connected(at(now))); }
    void bytes(ByteSpan in, double now) { add(session_.on_bytes(in, at(now))); }
    void disconnected(double now) {
        add(session_.on_disconnected({Errc::Io, 0, "the connection to the server is gone"}, at(now)));
    }
    void timer(double now) { add(session_.on_timer(at(now))); }
    /// From now on tiles come in the order in which they matter to this camera, as soon as it is known where they are.
    void look(const client::View& view, double now);

    Step next(double now, std::string& text, double& number);

 private:
    static client::Clock::time_point at(double milliseconds);
    void add(client::Actions actions);
    void choose(double now);
    Step take(double now, std::string& text, double& number);

    Model& model_;
    client::Session session_;
    client::Actions actions_;
    std::size_t next_ = 0;

    std::optional<client::View> view_;
    std::vector<client::TilePlace> places_;
    std::size_t placed_vertices_ = 0;
    std::vector<protocol::TilePriority> chosen_;  // what was last asked for
};

}  // namespace mvw::web
