// Cuts a byte stream into messages.
#pragma once
#include <cstddef>

#include "server/protocol/messages.h"

namespace mvw::protocol {

/// Holds the bytes that came and were not yet a whole message; never more than one message's limit and one read.
class MessageStream {
 public:
    explicit MessageStream(const MessageLimits& limits) : limits_(limits) {}

    void add(ByteSpan bytes);
    /// The next message; NeedMoreData where it is not all there. Views in it (payloads) live until the next add().
    Result<Message> next();
    /// True while part of a message waits for the rest of it.
    [[nodiscard]] bool partial() const { return used_ < buffer_.size(); }
    void clear();

 private:
    MessageLimits limits_;
    Bytes buffer_;
    std::size_t used_ = 0;  // bytes of buffer_ already handed out
};

}  // namespace mvw::protocol
