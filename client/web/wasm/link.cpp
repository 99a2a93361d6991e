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

Step Link::next(double now, std::string& text, double& number) {
    if (next_ == actions_.size()) return Step::Nothing;
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
