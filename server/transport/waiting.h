// Waits in a coroutine for what another thread will say. Inside the transport folder only.
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include <boost/asio/post.hpp>

#include "server/transport/carrier.h"

namespace mvw::server {

/// Calls `begin` with a function that is to be called once, from any thread, with a T; gives that T. The caller runs on
/// `strand`. What is called after the coroutine has gone is forgotten.
template <typename T>
asio::awaitable<T> wait_for(Strand strand, std::function<void(std::function<void(T)>)> begin) {
    struct Answer {
        explicit Answer(const Strand& s) : bell(s) {}
        Timer bell;
        std::optional<T> value;
    };
    const auto answer = std::make_shared<Answer>(strand);
    answer->bell.expires_at(std::chrono::steady_clock::time_point::max());
    begin([weak = std::weak_ptr<Answer>(answer)](T value) {
        if (const auto there = weak.lock())
            asio::post(there->bell.get_executor(), [there, value = std::move(value)]() mutable {
                there->value = std::move(value);
                there->bell.cancel();
            });
    });
    error_code ignored;
    while (!answer->value) co_await answer->bell.async_wait(into(ignored));
    co_return std::move(*answer->value);
}

}  // namespace mvw::server
