#include "server/protocol/messages.h"

#include <cmath>
#include <cstring>
#include <utility>

namespace mvw::protocol {
namespace {

// Starts a message whose length is filled in by finish().
ByteWriter begin(MessageType type) {
    ByteWriter out;
    out.u32(0);
    out.u8(static_cast<std::uint8_t>(type));
    return out;
}

// The message, its head's length field set; `following` bytes of body are sent separately.
Bytes finish(ByteWriter& out, std::size_t following = 0) {
    Bytes bytes = out.take();
    const auto length = static_cast<std::uint32_t>(bytes.size() - kHeadBytes + following);
    std::memcpy(bytes.data(), &length, sizeof length);  // little-endian hosts only, as ByteReader asserts
    return bytes;
}

void write_text(ByteWriter& out, std::string_view text) {
    out.u16(static_cast<std::uint16_t>(text.size()));
    out.bytes(std::as_bytes(std::span(text.data(), text.size())));
}

void write_request(ByteWriter& out, const Request& m) {
    out.u32(m.id);
    out.u8(m.max_level);
    out.u8(m.max_layer);
    out.u8(m.other_priority);
    out.f32(m.target_error);
    out.u64(m.byte_budget);
    out.varint(m.tiles.size());
    for (const TilePriority& t : m.tiles) {
        out.u16(t.part);
        out.u16(t.tile);
        out.u8(t.priority);
        out.u8(t.max_level);
    }
    m.held.write(out);
}

Result<std::string> read_text(ByteReader& in, std::uint32_t limit, const char* what) {
    const std::uint16_t length = in.u16();
    if (length > limit)
        return Error{Errc::LimitExceeded, in.offset(),
                     std::string(what) + " is " + std::to_string(length) + " bytes, limit is " + std::to_string(limit)};
    const ByteSpan bytes = in.bytes(length);
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Result<Request> read_request(ByteReader& in, const MessageLimits& limits) {
    constexpr std::size_t kTileBytes = 6;
    Request m;
    m.id = in.u32();
    m.max_level = in.u8();
    m.max_layer = in.u8();
    m.other_priority = in.u8();
    m.target_error = in.f32();
    m.byte_budget = in.u64();
    const std::uint64_t tiles = in.varint();
    if (!in.ok()) return in.error();
    if (!std::isfinite(m.target_error) || m.target_error < 0)
        return Error{Errc::Malformed, in.offset(), "target error is not a number from 0 up"};
    if (tiles > limits.max_tiles)
        return Error{Errc::LimitExceeded, in.offset(),
                     "request lists " + std::to_string(tiles) + " tiles, limit is " + std::to_string(limits.max_tiles)};
    if (tiles > in.remaining() / kTileBytes) return in.error();
    m.tiles.reserve(tiles);
    for (std::uint64_t i = 0; i < tiles; ++i) {
        TilePriority t;
        t.part = in.u16();
        t.tile = in.u16();
        t.priority = in.u8();
        t.max_level = in.u8();
        m.tiles.push_back(t);
    }
    Result<ChunkSet> held = ChunkSet::read(in);
    if (!held) return held.error();
    m.held = std::move(held).value();
    return m;
}

Result<Message> read_hello(ByteReader& in) {
    if (in.u32() != kMagic && in.ok()) return Error{Errc::Malformed, in.offset(), "not the mvw protocol"};
    Hello m;
    m.version = in.u16();
    m.min_version = in.u16();
    m.features = in.u32();
    m.max_message_bytes = in.u32();
    m.keep_alive_seconds = in.u16();
    return Message{m};
}

Result<Message> read_open(ByteReader& in, const MessageLimits& limits) {
    Open m;
    Result<std::string> model = read_text(in, limits.max_name_bytes, "model name");
    if (!model) return model.error();
    m.model = std::move(model).value();
    Result<std::string> token = read_text(in, limits.max_token_bytes, "token");
    if (!token) return token.error();
    m.token = std::move(token).value();
    for (std::uint8_t& b : m.content_id) b = in.u8();
    Result<Request> request = read_request(in, limits);
    if (!request) return request.error();
    m.request = std::move(request).value();
    return Message{std::move(m)};
}

Result<Message> read_model(ByteReader& in) {
    Model m;
    m.chunk_count = in.u32();
    m.file_bytes = in.u64();
    m.payload_bytes = in.u64();
    m.header = in.bytes(in.remaining());
    return Message{m};
}

Result<Message> read_chunk(ByteReader& in) {
    Chunk m = read_chunk_fields(in);
    m.payload = in.bytes(in.remaining());
    if (std::isnan(m.error) || m.error < 0) return Error{Errc::Malformed, in.offset(), "chunk error is not a number"};
    return Message{m};
}

Result<Message> read_end(ByteReader& in) {
    End m;
    m.id = in.u32();
    m.reason = EndReason{in.u8()};
    m.chunks = in.u32();
    m.bytes = in.u64();
    if (m.reason > EndReason::Cancelled) return Error{Errc::Malformed, in.offset(), "unknown end reason"};
    return Message{m};
}

Result<Message> read_error(ByteReader& in) {
    ErrorMessage m;
    m.code = ErrorCode{in.u8()};
    Result<std::string> sentence = read_text(in, 0xFFFF, "sentence");
    if (!sentence) return sentence.error();
    m.sentence = std::move(sentence).value();
    if (m.code < ErrorCode::Malformed || m.code > ErrorCode::Internal)
        return Error{Errc::Malformed, in.offset(), "unknown error code"};
    return Message{std::move(m)};
}

Result<Message> read_body(MessageType type, ByteReader& in, const MessageLimits& limits) {
    switch (type) {
        case MessageType::Hello:
            return read_hello(in);
        case MessageType::Open:
            return read_open(in, limits);
        case MessageType::Request: {
            Result<Request> request = read_request(in, limits);
            if (!request) return request.error();
            return Message{std::move(request).value()};
        }
        case MessageType::Cancel:
            return Message{Cancel{in.u32()}};
        case MessageType::GetIndex:
            return Message{GetIndex{}};
        case MessageType::Ping:
            return Message{Ping{in.u64()}};
        case MessageType::Pong:
            return Message{Pong{in.u64()}};
        case MessageType::Model:
            return read_model(in);
        case MessageType::Chunk:
            return read_chunk(in);
        case MessageType::End:
            return read_end(in);
        case MessageType::Index:
            return Message{Index{in.bytes(in.remaining())}};
        case MessageType::Error:
            return read_error(in);
    }
    return Error{Errc::Unsupported, 0, "unknown message type " + std::to_string(static_cast<unsigned>(type))};
}

}  // namespace

Bytes write_message(const Hello& m) {
    ByteWriter out = begin(MessageType::Hello);
    out.u32(kMagic);
    out.u16(m.version);
    out.u16(m.min_version);
    out.u32(m.features);
    out.u32(m.max_message_bytes);
    out.u16(m.keep_alive_seconds);
    return finish(out);
}

Bytes write_message(const Open& m) {
    ByteWriter out = begin(MessageType::Open);
    write_text(out, m.model);
    write_text(out, m.token);
    out.bytes(std::as_bytes(std::span(m.content_id)));
    write_request(out, m.request);
    return finish(out);
}

Bytes write_message(const Request& m) {
    ByteWriter out = begin(MessageType::Request);
    write_request(out, m);
    return finish(out);
}

Bytes write_message(const Cancel& m) {
    ByteWriter out = begin(MessageType::Cancel);
    out.u32(m.id);
    return finish(out);
}

Bytes write_message(const GetIndex&) {
    ByteWriter out = begin(MessageType::GetIndex);
    return finish(out);
}

Bytes write_message(const Ping& m) {
    ByteWriter out = begin(MessageType::Ping);
    out.u64(m.nonce);
    return finish(out);
}

Bytes write_message(const Pong& m) {
    ByteWriter out = begin(MessageType::Pong);
    out.u64(m.nonce);
    return finish(out);
}

Bytes write_message(const Model& m) {
    ByteWriter out = begin(MessageType::Model);
    out.u32(m.chunk_count);
    out.u64(m.file_bytes);
    out.u64(m.payload_bytes);
    out.bytes(m.header);
    return finish(out);
}

Bytes write_message(const End& m) {
    ByteWriter out = begin(MessageType::End);
    out.u32(m.id);
    out.u8(static_cast<std::uint8_t>(m.reason));
    out.u32(m.chunks);
    out.u64(m.bytes);
    return finish(out);
}

Bytes write_message(const ErrorMessage& m) {
    ByteWriter out = begin(MessageType::Error);
    out.u8(static_cast<std::uint8_t>(m.code));
    write_text(out, std::string_view(m.sentence).substr(0, 0xFFFF));
    return finish(out);
}

Bytes write_chunk_head(std::uint32_t index, const ChunkEntry& chunk) {
    ByteWriter out = begin(MessageType::Chunk);
    write_chunk_fields(out, {index, chunk.id, chunk.crc32c, chunk.error, {}});
    return finish(out, chunk.length);
}

void write_chunk_fields(ByteWriter& out, const Chunk& chunk) {
    out.u32(chunk.index);
    out.u16(chunk.id.part);
    out.u16(chunk.id.tile);
    out.u8(chunk.id.level);
    out.u8(chunk.id.layer);
    out.u8(static_cast<std::uint8_t>(chunk.id.channel));
    out.u32(chunk.crc32c);
    out.f32(chunk.error);
}

Chunk read_chunk_fields(ByteReader& in) {
    Chunk m;
    m.index = in.u32();
    m.id.part = in.u16();
    m.id.tile = in.u16();
    m.id.level = in.u8();
    m.id.layer = in.u8();
    m.id.channel = Channel{in.u8()};
    m.crc32c = in.u32();
    m.error = in.f32();
    return m;
}

Bytes write_index_head(std::uint32_t index_bytes) {
    ByteWriter out = begin(MessageType::Index);
    return finish(out, index_bytes);
}

Result<Parsed> read_message(ByteSpan in, const MessageLimits& limits) {
    ByteReader head(in);
    const std::uint32_t length = head.u32();
    const auto type = MessageType{head.u8()};
    if (!head.ok()) return head.error();
    if (length > limits.max_body_bytes)
        return Error{
            Errc::LimitExceeded, 0,
            "message is " + std::to_string(length) + " bytes, limit is " + std::to_string(limits.max_body_bytes)};
    if (type < MessageType::Hello || type > MessageType::Error)
        return Error{Errc::Unsupported, 0, "unknown message type " + std::to_string(static_cast<unsigned>(type))};
    if (head.remaining() < length) return Error{Errc::NeedMoreData, in.size(), "the message goes on"};

    ByteReader body(in.subspan(kHeadBytes, length));
    Result<Message> message = read_body(type, body, limits);
    // All of the body is here: what runs past its end, or leaves bytes over, contradicts its length.
    if (!body.ok() || (!message && message.error().code == Errc::NeedMoreData))
        return Error{Errc::Malformed, kHeadBytes + body.offset(), "message fields go beyond its length"};
    if (!message) return message.error();
    if (body.remaining() != 0)
        return Error{Errc::Malformed, kHeadBytes + body.offset(), "message is longer than its fields"};
    return Parsed{std::move(message).value(), kHeadBytes + length};
}

}  // namespace mvw::protocol
