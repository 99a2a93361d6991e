#include "client/viewer/headless_gl.h"

#include <epoxy/egl.h>

#include <string>

namespace mvw {
namespace {

Error no_gl(const char* what) {
    return Error{Errc::Io, 0, std::string("cannot draw: ") + what + " (package libgl1-mesa-dri missing?)"};
}

/// The surfaceless display, started; EGL_NO_DISPLAY where there is none.
EGLDisplay start_display() {
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) return EGL_NO_DISPLAY;
    EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return EGL_NO_DISPLAY;
    return display;
}

}  // namespace

struct HeadlessGl::State {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (context == EGL_NO_CONTEXT) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
    }
};

HeadlessGl::HeadlessGl(std::unique_ptr<State> state) : state_(std::move(state)) {}
HeadlessGl::~HeadlessGl() = default;
HeadlessGl::HeadlessGl(HeadlessGl&&) noexcept = default;
HeadlessGl& HeadlessGl::operator=(HeadlessGl&&) noexcept = default;

Result<HeadlessGl> HeadlessGl::create() {
    static const EGLDisplay display = start_display();
    if (display == EGL_NO_DISPLAY) return no_gl("EGL's surfaceless platform does not start");
    auto state = std::make_unique<State>();
    state->display = display;
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
