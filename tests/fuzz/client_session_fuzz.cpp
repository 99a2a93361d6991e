// A server that says anything, in any slices, over connections that come and go: the client's session never takes a
// chunk whose checksum is wrong, never one twice, and ends what it cannot use.
#include <cstdint>
#include <cstdlib>
#include <set>

#include "client/session.h"
#include "codec/container/crc32c.h"
#include "tests/support/stream_models.h"

namespace {

using namespace mvw;
using namespace mvw::client;

class Owner {
 public:
    void take(const Actions& actions) {
        for (const Action& action : actions) {
            connecting |= std::holds_alternative<Connect>(action);
            if (const auto* chunk = std::get_if<Received>(&action)) {
                if (crc32c(chunk->payload) != chunk->crc32c || !held_.insert(chunk->index).second) std::abort();
            } else if (std::holds_alternative<Restarted>(action)) {
                held_.clear();
            } else if (const auto* timer = std::get_if<SetTimer>(&action)) {
                due = timer->at;
            }
        }
    }
    bool connecting = false;
    Clock::time_point due{};

 private:
    std::set<std::uint32_t> held_;
};

// What an honest server says first; the fuzzer goes on from there.
Bytes honest_opening() {
    static const auto model = test::MemoryModel::make(test::make_stream_file({.payload_bytes = 60}));
    Bytes said = write_message(protocol::Hello{});
    const auto count = static_cast<std::uint32_t>(model->toc().chunks.size());
    const Bytes opened =
        write_message(protocol::Model{count, model->file_bytes(), model->payload_bytes(), model->header()});
    said.insert(said.end(), opened.begin(), opened.end());
    return said;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    Session session("bunny", "", {});
    Owner owner;
    Clock::time_point now{};
    owner.take(session.start(now));
    const std::size_t slice = data[1] + 1u;
    for (std::size_t at = 2; at < size; at += slice) {
        if (owner.connecting) {
            owner.connecting = false;
            owner.take(session.on_connected(now));
            if (data[0] % 2 == 0) owner.take(session.on_bytes(honest_opening(), now));
        }
        const auto* begin = reinterpret_cast<const std::byte*>(data + at);
        owner.take(session.on_bytes(Bytes(begin, begin + std::min(slice, size - at)), now));
        if (data[at] % 16 == 1) owner.take(session.on_disconnected({Errc::Io, 0, "cut"}, now));
        if (data[at] % 16 == 2) owner.take(session.want({}, now));
        if (data[at] % 16 == 3) owner.take(session.cancel(now));
        now = std::max(now + std::chrono::milliseconds(1), owner.due);
        owner.take(session.on_timer(now));
    }
    return 0;
}
