// The messages of the native protocol: structs, and how they are written and read. No I/O. PROTOCOL.md is normative.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "codec/container/chunk.h"
#include "server/protocol/chunk_set.h"

namespace mvw::protocol {

inline constexpr std::uint32_t kMagic = 0x5057564D;  // "MVWP"
inline constexpr std::uint16_t kVersion = 1;         // the only one so far
inline constexpr std::size_t kHeadBytes = 5;         // u32 body length, u8 type
inline constexpr std::size_t kChunkFieldBytes = 19;  // of a CHUNK body before its payload

using ContentId = std::array<std::uint8_t, 16>;

/// On the wire: append values, never renumber (PROTOCOL.md 3).
enum class MessageType : std::uint8_t {
    Hello = 1,
    Open = 2,
    Request = 3,
    Cancel = 4,
    GetIndex = 5,
    Ping = 6,
    Pong = 7,
    Model = 8,
    Chunk = 9,
    End = 10,
    Index = 11,
    Error = 12,
};

/// Why an ERROR was sent. On the wire: append values, never renumber (PROTOCOL.md 3.12).
enum class ErrorCode : std::uint8_t {
    Malformed = 1,      // the peer's bytes contradict PROTOCOL.md; the connection ends
    Unsupported = 2,    // no common version, or an unknown required feature; the connection ends
    LimitExceeded = 3,  // a message, set or chunk over a limit; the connection ends
    NotFound = 4,       // no such model; another OPEN may follow
    Forbidden = 5,      // the token does not allow this model; another OPEN may follow
    Changed = 6,        // the model is no longer the one opened or held; another OPEN may follow
    TooBusy = 7,        // too many connections or requests; come back later; the connection ends
    Timeout = 8,        // nothing heard for too long; the connection ends
    ShuttingDown = 9,   // the server stops; come back later; the connection ends
    Internal = 10,      // the server could not read what it serves; the connection ends
};

/// True where the connection outlives the error.
constexpr bool is_recoverable(ErrorCode code) {
    return code == ErrorCode::NotFound || code == ErrorCode::Forbidden || code == ErrorCode::Changed;
}

/// First message of each side.
struct Hello {
    std::uint16_t version = kVersion;      // client: the highest it speaks; server: the one both will use
    std::uint16_t min_version = kVersion;  // client: the lowest it speaks; server: as version
    std::uint32_t features = 0;            // required-feature bits: an unknown one ends the connection
    std::uint32_t max_message_bytes = 0;   // largest message body that the sender accepts
    std::uint16_t keep_alive_seconds = 0;  // the sender gives up on a peer silent for so long; 0: never
    friend bool operator==(const Hello&, const Hello&) = default;
};

/// How soon one tile is wanted, and how fine.
struct TilePriority {
    std::uint16_t part = 0, tile = 0;
    std::uint8_t priority = 1;     // higher first; 0: not at all
    std::uint8_t max_level = 255;  // in addition to the request's own
    friend constexpr bool operator==(const TilePriority&, const TilePriority&) = default;
};

/// What a client wants. A new one replaces the one before it.
struct Request {
    std::uint32_t id = 0;             // comes back in END
    std::uint8_t max_level = 255;     // finest level wanted
    std::uint8_t max_layer = 255;     // finest layer wanted
    std::uint8_t other_priority = 1;  // of tiles not listed; 0: only the listed ones
    float target_error = 0;           // nothing beyond the first chunk that leaves at most this; 0: no such end
    std::uint64_t byte_budget = 0;    // header and payloads that the client will hold in all; 0: no such end
    std::vector<TilePriority> tiles{};
    ChunkSet held{};  // all but these
    friend bool operator==(const Request&, const Request&) = default;
};

/// Names a model and carries the first request, so that chunks come back one round trip after the connection stands.
struct Open {
    std::string model{};     // path below the served folder, with or without ".mvw"
    std::string token{};     // access token, empty where none is needed
    ContentId content_id{};  // of the model that request.held is about; zeros where nothing is held
    Request request{};
    friend bool operator==(const Open&, const Open&) = default;
};

/// Ends the request of that id; END follows.
struct Cancel {
    std::uint32_t id = 0;
    friend constexpr bool operator==(const Cancel&, const Cancel&) = default;
};

/// Asks for the open model's table of contents.
struct GetIndex {
    friend constexpr bool operator==(const GetIndex&, const GetIndex&) = default;
};

struct Ping {
    std::uint64_t nonce = 0;
    friend constexpr bool operator==(const Ping&, const Ping&) = default;
};

struct Pong {
    std::uint64_t nonce = 0;
    friend constexpr bool operator==(const Pong&, const Pong&) = default;
};

/// Answers OPEN: the file's header as it is on disk, and the size of what may follow.
struct Model {
    std::uint32_t chunk_count = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t payload_bytes = 0;  // of all chunks
    ByteSpan header;                  // header_bytes at the file's start; read: a view into the input
};

/// One chunk.
struct Chunk {
    std::uint32_t index = 0;  // place in file order
    ChunkId id;
    std::uint32_t crc32c = 0;  // of the payload
    float error = 0;           // left once this chunk and all before it in file order are there
    ByteSpan payload;          // read: a view into the input
};

/// On the wire: append values, never renumber (PROTOCOL.md 3.10).
enum class EndReason : std::uint8_t {
    Complete = 0,   // everything that matches has been sent
    Budget = 1,     // the next chunk would go over the budget
    Cancelled = 2,  // by CANCEL
};

/// The request of that id is done; nothing more comes until another one.
struct End {
    std::uint32_t id = 0;
    EndReason reason = EndReason::Complete;
    std::uint32_t chunks = 0;  // sent for this request
    std::uint64_t bytes = 0;   // of their payloads
    friend constexpr bool operator==(const End&, const End&) = default;
};

/// Answers GET_INDEX: the index as it is on disk.
struct Index {
    ByteSpan bytes;  // read: a view into the input
};

struct ErrorMessage {
    ErrorCode code = ErrorCode::Internal;
    std::string sentence;  // for people, UTF-8
    friend bool operator==(const ErrorMessage&, const ErrorMessage&) = default;
};

using Message =
    std::variant<Hello, Open, Request, Cancel, GetIndex, Ping, Pong, Model, Chunk, End, Index, ErrorMessage>;

/// Caps applied to a message before anything is allocated for it.
struct MessageLimits {
    std::uint32_t max_body_bytes = 256u << 10;
    std::uint32_t max_name_bytes = 1024;
    std::uint32_t max_token_bytes = 4096;
    std::uint32_t max_tiles = 1u << 15;  // of one request
};

/// A whole message, head included.
Bytes write_message(const Hello&);
Bytes write_message(const Open&);
Bytes write_message(const Request&);
Bytes write_message(const Cancel&);
Bytes write_message(const GetIndex&);
Bytes write_message(const Ping&);
Bytes write_message(const Pong&);
Bytes write_message(const Model&);
Bytes write_message(const End&);
Bytes write_message(const ErrorMessage&);
/// Head and fields alone; exactly chunk.length payload bytes must follow.
Bytes write_chunk_head(std::uint32_t index, const ChunkEntry& chunk);
/// A CHUNK's fields before its payload, kChunkFieldBytes of them; the client's cache keeps them in the same form.
void write_chunk_fields(ByteWriter& out, const Chunk& chunk);
Chunk read_chunk_fields(ByteReader& in);
/// Head alone; exactly index_bytes bytes must follow.
Bytes write_index_head(std::uint32_t index_bytes);

/// A message and the input bytes it took.
struct Parsed {
    Message message;
    std::size_t consumed = 0;
};

/// Reads the message at the start of `in`. NeedMoreData until all of it is there; LimitExceeded as soon as its head
/// says that it is too large; Malformed where fields and length disagree; Unsupported for an unknown type.
Result<Parsed> read_message(ByteSpan in, const MessageLimits& limits);

}  // namespace mvw::protocol
