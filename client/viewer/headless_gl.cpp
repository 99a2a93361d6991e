#include "client/viewer/headless_gl.h"

#include <epoxy/egl.h>

#include <mutex>

namespace mvw {
namespace {

std::mutex& only_one() {
    static std::mutex mutex;
    return mutex;
}

Error no_gl(const char* what) {
    return Error{Errc::Io, 0, std::string("cannot draw: ") + what + " (package libgl1-mesa-dri missing?)"};
}

}  // namespace

struct HeadlessGl::State {
    std::unique_lock<std::mutex> lock{only_one()};
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (display == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
        eglTerminate(display);
    }
};

HeadlessGl::HeadlessGl(std::unique_ptr<State> state) : state_(std::move(state)) {}
HeadlessGl::~HeadlessGl() = default;
HeadlessGl::HeadlessGl(HeadlessGl&&) noexcept = default;
HeadlessGl& HeadlessGl::operator=(HeadlessGl&&) noexcept = default;

Result<HeadlessGl> HeadlessGl::create() {
    auto state = std::make_unique<State>();
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
        return no_gl("EGL has no surfaceless platform");
    state->display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (state->display == EGL_NO_DISPLAY || !eglInitialize(state->display, nullptr, nullptr)) {
        state->display = EGL_NO_DISPLAY;
        return no_gl("EGL does not start");
    }
    if (!eglBindAPI(EGL_OPENGL_API)) return no_gl("EGL has no desktop OpenGL");
    const EGLint attributes[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    state->context = eglCreateContext(state->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (state->context == EGL_NO_CONTEXT ||
        !eglMakeCurrent(state->display, EGL_NO_SURFACE, EGL_NO_SURFACE, state->context))
        return no_gl("no OpenGL 3.3");
    return HeadlessGl(std::move(state));
}

}  // namespace mvw
