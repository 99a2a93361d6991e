#include "server/protocol/message_stream.h"

#include <utility>

namespace mvw::protocol {

void MessageStream::add(ByteSpan bytes) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(used_));
    used_ = 0;
    if (buffer_.empty() && buffer_.capacity() > 64u << 10) buffer_ = {};  // one large message must not pin memory
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<Message> MessageStream::next() {
    Result<Parsed> parsed = read_message(ByteSpan(buffer_).subspan(used_), limits_);
    if (!parsed) return parsed.error();
    used_ += parsed->consumed;
    return std::move(parsed->message);
}

void MessageStream::clear() {
    buffer_.clear();
    used_ = 0;
}

}  // namespace mvw::protocol
