// The client's HTTP session against a server that sends any bytes in any slices: it ends with a word, hands out no
// damaged chunk, and asks for a bounded number of ranges. First byte: what is wanted; second: how the server behaves;
// then the file.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "client/http_session.h"
#include "codec/container/crc32c.h"

namespace {

using namespace mvw;
using namespace mvw::client;

constexpr int kMaxRequests = 2000;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    Wants wants;
    if (data[0] & 1) wants.max_level = data[0] >> 4;
    if (data[0] & 2) wants.byte_budget = 64u * (data[0] >> 2);
    if (data[0] & 4) wants.target_error = 0.01f;
    const bool ranges = (data[1] & 1) != 0;
    const std::size_t slice = 1 + (data[1] >> 1);
    const auto* begin = reinterpret_cast<const std::byte*>(data + 2);
    const Bytes file(begin, begin + (size - 2));  // a block of its own, so that reading past it is seen

    HttpSession session(wants);
    Clock::time_point now{};
    std::optional<Get> get;
    std::optional<Clock::time_point> timer;
    bool over = false;
    int requests = 0;
    const auto take = [&](HttpActions actions) {
        for (HttpAction& action : actions) {
            if (auto* g = std::get_if<Get>(&action)) get = *g;
            if (std::holds_alternative<Abandon>(action)) get.reset();
            if (auto* t = std::get_if<SetTimer>(&action)) timer = t->at;
            if (auto* r = std::get_if<Received>(&action))
                if (crc32c(r->payload) != r->crc32c) std::abort();
            over |= std::holds_alternative<Satisfied>(action) || std::holds_alternative<Failed>(action);
        }
    };
    take(session.start(now));
    while (!over) {
        if (!get) {
            if (!timer) std::abort();  // waits for nothing
            now = std::max(now, *timer);
            timer.reset();
            take(session.on_timer(now));
            continue;
        }
        if (++requests > kMaxRequests) std::abort();
        const Get asked = *get;
        const bool part = ranges && (asked.first > 0 || asked.last);
        HttpAnswer answer{part ? 206u : 200u, "\"1\"", part ? asked.first : 0};
        if (part && asked.first >= file.size()) answer.status = 416;
        get.reset();
        bool abandoned = false;
        const auto pass = [&](HttpActions actions) {
            for (const HttpAction& a : actions) abandoned |= std::holds_alternative<Abandon>(a);
            take(std::move(actions));
        };
        pass(session.on_answer(answer, now));
        const std::size_t end = part && asked.last
                                    ? static_cast<std::size_t>(std::min<std::uint64_t>(*asked.last + 1, file.size()))
                                    : file.size();
        for (std::size_t at = answer.first; at < end && !abandoned && !over && answer.status < 300; at += slice)
            pass(session.on_body(ByteSpan(file).subspan(at, std::min(slice, end - at)), now));
        if (!abandoned && !over && answer.status < 300) pass(session.on_body_end(now));
    }
    return 0;
}
