// A peer that says anything, in any slices: the server's session answers with sound messages, never sends a chunk twice
// for one OPEN, never queues more than its limits, and says nothing after Close.
#include <cstdint>
#include <cstdlib>
#include <set>

#include "server/session.h"
#include "tests/support/stream_models.h"

namespace {

using namespace mvw;
using namespace mvw::server;

class Peer {
 public:
    explicit Peer(const ServerLimits& limits)
        : session([](std::string_view) -> Result<ModelPtr> { return model(); }, limits) {}

    void take(const Actions& actions) {
        for (const Action& action : actions) {
            if (closed) std::abort();
            if (const auto* bytes = std::get_if<SendBytes>(&action)) {
                check(bytes->bytes);
            } else if (const auto* range = std::get_if<SendRange>(&action)) {
                Bytes payload(range->length);
                if (!range->model->read(range->offset, payload)) std::abort();
            } else if (std::holds_alternative<Close>(action)) {
                closed = true;
            }
        }
    }

    Session session;
    bool closed = false;

 private:
    static ModelPtr model() {
        static const ModelPtr m = test::MemoryModel::make(test::make_stream_file({.payload_bytes = 60}));
        return m;
    }
    // Messages come whole, but for the payloads, which follow as ranges.
    void check(const Bytes& bytes) {
        ByteReader in(bytes);
        const std::uint32_t length = in.u32();
        const auto type = protocol::MessageType{in.u8()};
        if (type == protocol::MessageType::Model) sent_.clear();
        if (type == protocol::MessageType::Chunk) {
            if (!sent_.insert(in.u32()).second) std::abort();
        } else if (type != protocol::MessageType::Index && length != bytes.size() - protocol::kHeadBytes) {
            std::abort();
        }
    }
    std::set<std::uint32_t> sent_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    ServerLimits limits;
    limits.soft_queue_bytes = 1000;
    Peer peer(limits);
    Clock::time_point now{};
    peer.take(peer.session.on_start(now));
    if (data[0] % 2 == 0) {  // most peers greet
        protocol::Hello hello;
        hello.max_message_bytes = 1u << 20;
        peer.take(peer.session.on_bytes(write_message(hello), now));
    }
    const std::size_t slice = data[1] + 1u;
    for (std::size_t at = 2; at < size && !peer.closed; at += slice) {
        const auto* begin = reinterpret_cast<const std::byte*>(data + at);
        const Bytes bytes(begin, begin + std::min(slice, size - at));
        peer.take(peer.session.on_bytes(bytes, now));
        if (data[at] % 3 == 0) peer.take(peer.session.on_sent(peer.session.queued_bytes(), now));
        now += std::chrono::milliseconds(data[at] * 10);
        peer.take(peer.session.on_timer(now));
        if (peer.session.queued_bytes() > limits.soft_queue_bytes + limits.hard_queue_bytes + 2000) std::abort();
    }
    return 0;
}
