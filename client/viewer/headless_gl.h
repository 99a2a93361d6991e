// An OpenGL 3.3 core context without a window or display server: EGL's surfaceless platform.
#pragma once
#include <memory>

#include "codec/result.h"

namespace mvw {

/// Current on the thread that made it, until destroyed there; one at a time on a thread. The display behind it is
/// started once and kept for the life of the process: drivers do not like to be unloaded, and starting them takes a
/// while.
class HeadlessGl {
 public:
    /// Io where EGL, the surfaceless platform or OpenGL 3.3 is missing.
    static Result<HeadlessGl> create();
    ~HeadlessGl();
    HeadlessGl(HeadlessGl&&) noexcept;
    HeadlessGl& operator=(HeadlessGl&&) noexcept;

 private:
    struct State;
    explicit HeadlessGl(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mvw
