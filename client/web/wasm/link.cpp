#include "client/web/wasm/link.h"

#include <iterator>
#include <type_traits>

namespace mvw::web {
namespace {

template <typename Time>
double milliseconds(Time time) {
    return std::chrono::duration<double, std::milli>(time).count();
}

}  // namespace

client::Clock::time_point Link::at(double milliseconds) {
    return client::Clock::time_point(
        std::chrono::duration_cast<client::Clock::duration>(std::chrono::duration<double, std::milli>(milliseconds)));
}

void Link::add(client::Actions actions) {
    actions_.erase(actions_.begin(), actions_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
    actions_.insert(actions_.end(), std::make_move_iterator(actions.begin()), std::make_move_iterator(actions.end()));
}

void Link::look(const client::View& view, double now) {
    view_ = view;
    choose(now);
}

void Link::choose(double now) {
    const Decoder& decoder = model_.decoder();
    if (!view_ || decoder.header() == nullptr) return;
    std::size_t vertices = 0;
    for (std::size_t part = 0; part < decoder.header()->parts.size(); ++part)
        if (const BaseMesh* base = decoder.base(part)) vertices += base->vertex_count();
    if (vertices != placed_vertices_) {
        placed_vertices_ = vertices;
        places_ = client::place_tiles(decoder);
    }
    client::Wants wants;
    wants.tiles = choose_tiles(places_, *view_);
    if (wants.tiles == chosen_) return;
    chosen_ = wants.tiles;
    add(session_.want(std::move(wants), at(now)));
}

Step Link::next(double now, std::string& text, double& number) {
    if (next_ == actions_.size()) return Step::Nothing;
    const Step step = take(now, text, number);
    if (step == Step::Received) choose(now);  // another part's base may have come
    return step;
}

Step Link::take(double now, std::string& text, double& number) {
    return std::visit(
        [&](auto& action) {
            using A = std::decay_t<decltype(action)>;
            if constexpr (std::is_same_v<A, client::Connect>) {
                return Step::Connect;
            } else if constexpr (std::is_same_v<A, client::SendBytes>) {
                text.assign(reinterpret_cast<const char*>(action.bytes.data()), action.bytes.size());
                return Step::Send;
            } else if constexpr (std::is_same_v<A, client::SetTimer>) {
                number = milliseconds(action.at - at(now));
                return Step::Timer;
            } else if constexpr (std::is_same_v<A, client::Disconnect>) {
                return Step::Disconnect;
            } else if constexpr (std::is_same_v<A, client::Opened>) {
                model_.take(action);
                return Step::Opened;
            } else if constexpr (std::is_same_v<A, client::Received>) {
                model_.take(action);
                return Step::Received;
            } else if constexpr (std::is_same_v<A, client::Satisfied>) {
                return Step::Satisfied;
            } else if constexpr (std::is_same_v<A, client::Broken>) {
                text = action.why.message;
                number = milliseconds(action.retry_in);
                return Step::Broken;
            } else if constexpr (std::is_same_v<A, client::Resumed>) {
                return Step::Resumed;
            } else if constexpr (std::is_same_v<A, client::Restarted>) {
                model_.take(action);
                placed_vertices_ = 0;
                chosen_.clear();
                return Step::Restarted;
            } else {
                static_assert(std::is_same_v<A, client::Failed>);
                text = action.why.message;
                return Step::Failed;
            }
        },
        actions_[next_++]);
}

}  // namespace mvw::web
