// In programs under the leak sanitizer: shared libraries stay loaded. What a library (GLFW's, of X11) leaves to its own
// global variables when it is unloaded would be reported as a leak, by no name that could be suppressed.
#include <dlfcn.h>

extern "C" int dlclose(void* /*handle*/) noexcept {
    return 0;
}
