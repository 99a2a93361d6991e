// How fast a link may be, to feel a slower one than there is.
#pragma once
#include <atomic>
#include <limits>
#include <memory>

namespace mvw::client {

/// Shared by an owner, who may change it at any time from any thread, and what reads.
struct Pace {
    std::atomic<double> bytes_per_second = std::numeric_limits<double>::infinity();
};
using PacePtr = std::shared_ptr<const Pace>;

}  // namespace mvw::client
