// Splits a loop over a few threads.
#pragma once
#include <algorithm>
#include <cstddef>
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

}  // namespace mvw
