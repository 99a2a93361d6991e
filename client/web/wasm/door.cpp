// The door between JavaScript and the module: functions of numbers and of places in the module's memory, nothing else.
// src/module.js wraps every one of them and is their only caller.
#include <emscripten/emscripten.h>

#include <algorithm>
#include <cstdlib>

#include "client/web/wasm/link.h"
#include "client/web/wasm/model.h"

namespace {

using mvw::web::Link;
using mvw::web::Model;

/// What the last call said beside its number.
std::string text;
std::array<double, 8> numbers;

int answer(const mvw::Result<void>& result) {
    if (result.ok()) return 0;
    text = result.error().message;
    return 1 + static_cast<int>(result.error().code);
}

void put_state(const mvw::DecodeState& state) {
    numbers[0] = static_cast<double>(state.bytes);
    numbers[1] = state.level;
    numbers[2] = static_cast<double>(state.error);
    numbers[3] = state.chunks;
    numbers[4] = state.damaged;
}

template <typename T>
const void* array_of(const std::vector<T>& values, unsigned& bytes) {
    bytes = static_cast<unsigned>(values.size() * sizeof(T));
    return values.data();
}

unsigned length_of_array = 0;

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE void* mvw_allocate(unsigned bytes) {
    return std::malloc(bytes);
}
EMSCRIPTEN_KEEPALIVE void mvw_release(void* memory) {
    std::free(memory);
}
EMSCRIPTEN_KEEPALIVE const char* mvw_text() {
    return text.data();
}
EMSCRIPTEN_KEEPALIVE unsigned mvw_text_length() {
    return static_cast<unsigned>(text.size());
}
EMSCRIPTEN_KEEPALIVE const double* mvw_numbers() {
    return numbers.data();
}

// A model. Functions that can fail return 0, or 1 + Errc with a sentence in mvw_text().
EMSCRIPTEN_KEEPALIVE Model* mvw_model_new(double memory_bytes) {
    return new Model(static_cast<std::uint64_t>(memory_bytes));
}
EMSCRIPTEN_KEEPALIVE void mvw_model_delete(Model* model) {
    delete model;
}
EMSCRIPTEN_KEEPALIVE int mvw_model_feed(Model* model, const std::byte* bytes, unsigned length) {
    return answer(model->feed({bytes, length}));
}
EMSCRIPTEN_KEEPALIVE int mvw_model_index(Model* model, const std::byte* bytes, unsigned length) {
    return answer(model->take_index({bytes, length}));
}
/// JSON in mvw_text(); its length.
EMSCRIPTEN_KEEPALIVE unsigned mvw_model_describe(Model* model) {
    text = model->describe();
    return mvw_text_length();
}
/// numbers: bytes, level, error, chunks, damaged, whether complete, revision.
EMSCRIPTEN_KEEPALIVE void mvw_model_state(Model* model) {
    put_state(model->decoder().state());
    numbers[5] = model->complete();
    numbers[6] = static_cast<double>(model->decoder().revision());
}
/// Sixteen hexadecimal digits in mvw_text().
EMSCRIPTEN_KEEPALIVE void mvw_model_digest(Model* model) {
    text.clear();
    for (std::uint64_t digest = model->decoder().coefficient_digest(), i = 0; i < 16; ++i, digest <<= 4)
        text += "0123456789abcdef"[digest >> 60];
}
/// lines: 1 for the triangles' edges, 2 for the base mesh's. numbers: as the state, of what was drawn, then level and
/// parts of the drawable, and whether it is solid.
EMSCRIPTEN_KEEPALIVE int mvw_model_draw(Model* model, unsigned level, unsigned layer, double bytes, unsigned lines) {
    mvw::web::View view{level, layer, bytes, {}};
    view.lines.edges = (lines & 1) != 0;
    view.lines.base_edges = (lines & 2) != 0;
    const int result = answer(model->draw(view));
    put_state(model->drawn_state());
    numbers[5] = model->drawable().level;
    numbers[6] = model->drawable().parts;
    numbers[7] = model->drawable().solid;
    return result;
}
/// Arrays: 0 positions, 1 normals (f32), 2 colours (u8), 3 triangles, 4 edges, 5 base edges (u32), 6 points (f64).
/// Valid until the next call that draws or feeds; the length in bytes is mvw_array_bytes()'s.
EMSCRIPTEN_KEEPALIVE const void* mvw_model_array(Model* model, unsigned which) {
    const mvw::client::Drawable& d = model->drawable();
    switch (which) {
        case 0:
            return array_of(d.positions, length_of_array);
        case 1:
            return array_of(d.normals, length_of_array);
        case 2:
            return array_of(d.colors, length_of_array);
        case 3:
            return array_of(d.triangles, length_of_array);
        case 4:
            return array_of(d.edges, length_of_array);
        case 5:
            return array_of(d.base_edges, length_of_array);
        default:
            return array_of(model->points(), length_of_array);
    }
}
EMSCRIPTEN_KEEPALIVE unsigned mvw_array_bytes() {
    return length_of_array;
}

// A session for a model; times are milliseconds of one clock that never goes back.
EMSCRIPTEN_KEEPALIVE Link* mvw_link_new(Model* model, const char* name, unsigned name_length, const char* token,
                                        unsigned token_length, unsigned seed) {
    return new Link(*model, {name, name_length}, {token, token_length}, seed);
}
EMSCRIPTEN_KEEPALIVE void mvw_link_delete(Link* link) {
    delete link;
}
EMSCRIPTEN_KEEPALIVE void mvw_link_start(Link* link, double now) {
    link->start(now);
}
EMSCRIPTEN_KEEPALIVE void mvw_link_connected(Link* link, double now) {
    link->connected(now);
}
EMSCRIPTEN_KEEPALIVE void mvw_link_bytes(Link* link, const std::byte* bytes, unsigned length, double now) {
    link->bytes({bytes, length}, now);
}
EMSCRIPTEN_KEEPALIVE void mvw_link_disconnected(Link* link, double now) {
    link->disconnected(now);
}
EMSCRIPTEN_KEEPALIVE void mvw_link_timer(Link* link, double now) {
    link->timer(now);
}
/// camera: 16 numbers from the model to the eye, column-major; two of scale, nearest, height of the picture in pixels.
EMSCRIPTEN_KEEPALIVE void mvw_link_look(Link* link, const float* camera, double now) {
    mvw::client::View view;
    std::copy_n(camera, view.from_model.size(), view.from_model.begin());
    view.scale_x = camera[16];
    view.scale_y = camera[17];
    view.nearest = camera[18];
    view.height = static_cast<unsigned>(camera[19]);
    link->look(view, now);
}
/// The next thing to do (link.h), with its number in numbers[0], its sentence or bytes in mvw_text().
EMSCRIPTEN_KEEPALIVE int mvw_link_next(Link* link, double now) {
    return static_cast<int>(link->next(now, text, numbers[0]));
}

}  // extern "C"
