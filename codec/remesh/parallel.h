// Splits work over a few threads.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

namespace mvw {

/// Calls work(begin, end) for disjoint slices that cover [0, n), one a thread; returns when all are done.
template <typename Work>
void parallel_slices(std::size_t n, unsigned threads, const Work& work) {
    const std::size_t slice = (n + threads - 1) / threads;
    std::vector<std::jthread> workers;
    for (std::size_t begin = slice; begin < n; begin += slice)
        workers.emplace_back([&work, begin, slice, n] { work(begin, std::min(n, begin + slice)); });
    work(std::size_t{0}, std::min(slice, n));
}

/// Calls work(i) for each i of [0, n), in rising order as threads become free; returns when all are done.
template <typename Work>
void for_each_index(std::size_t n, unsigned threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    const auto serve = [&] {
        for (std::size_t i = next++; i < n; i = next++) work(i);
    };
    std::vector<std::jthread> helpers;
    for (unsigned t = 1; t < threads && t < n; ++t) helpers.emplace_back(serve);
    serve();
}

/// Calls a(threads) and b(threads): with two threads or more at the same time, each with its share of them.
template <typename A, typename B>
void side_by_side(unsigned threads, const A& a, const B& b) {
    if (threads < 2) {
        a(1u);
        b(1u);
        return;
    }
    std::future<void> other = std::async(std::launch::async, [&] { b(threads / 2); });
    a(threads - threads / 2);
    other.get();
}

}  // namespace mvw
