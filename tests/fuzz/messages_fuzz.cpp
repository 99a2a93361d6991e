// Any bytes give a message, a wish for more, or an error; a message that clients or servers write comes back the same.
#include <cstdint>
#include <cstdlib>
#include <type_traits>

#include "server/protocol/messages.h"

namespace {

using namespace mvw::protocol;

// Bytes have one meaning: written again, they are the same. Floats and varints may have been spelled otherwise, so the
// second writing is compared with the third.
template <typename M>
void check_round_trip(const M& message) {
    const mvw::Bytes once = write_message(message);
    MessageLimits limits;
    limits.max_body_bytes = static_cast<std::uint32_t>(once.size());
    const mvw::Result<Parsed> again = read_message(once, limits);
    if (!again || again->consumed != once.size() || write_message(std::get<M>(again->message)) != once) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes bytes(begin, begin + size);  // a block of its own, so that reading past it is seen
    const mvw::Result<Parsed> parsed = read_message(bytes, {});
    if (!parsed) return 0;
    if (parsed->consumed > size) std::abort();
    std::visit(
        [](const auto& m) {
            using M = std::decay_t<decltype(m)>;
            if constexpr (!std::is_same_v<M, Chunk> && !std::is_same_v<M, Index>) check_round_trip(m);
        },
        parsed->message);
    return 0;
}
