#include "client/viewer/window/window.h"

#include <epoxy/gl.h>
// GLFW after epoxy, without headers of its own.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>

#include "client/viewer/image.h"
#include "client/viewer/window/controls.h"

namespace mvw::client {
namespace {

using Seconds = std::chrono::duration<double>;

/// A window with a current context and Dear ImGui in it.
class Glfw {
 public:
    static Result<std::unique_ptr<Glfw>> open(const WindowOptions& options) {
        if (glfwInit() == GLFW_FALSE) return Error{Errc::Io, 0, "no display: a window cannot be opened here"};
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_SAMPLES, 4);
        GLFWwindow* window =
            glfwCreateWindow(options.width, options.height, ("mvw - " + options.place).c_str(), nullptr, nullptr);
        if (window == nullptr) {
            glfwTerminate();
            return Error{Errc::Io, 0, "no window with OpenGL 3.3 can be had"};
        }
        return std::unique_ptr<Glfw>(new Glfw(window));
    }
    ~Glfw() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
        glfwDestroyWindow(window_);
        glfwTerminate();
    }
    Glfw(const Glfw&) = delete;
    Glfw& operator=(const Glfw&) = delete;

    [[nodiscard]] GLFWwindow* get() const { return window_; }

 private:
    explicit Glfw(GLFWwindow* window) : window_(window) {
        glfwMakeContextCurrent(window);
        glfwSwapInterval(1);
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        ImGui::StyleColorsDark();
        ImGui::GetStyle().WindowRounding = 8;
        ImGui::GetStyle().FrameRounding = 4;
        ImGui_ImplGlfw_InitForOpenGL(window, true);
        ImGui_ImplOpenGL3_Init("#version 330 core");
    }
    GLFWwindow* window_;
};

void steer_by_mouse(Turntable& camera, int height) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse) return;
    if (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0)) {
        camera.yaw -= static_cast<double>(io.MouseDelta.x) / height * 230;
        camera.pitch = std::clamp(camera.pitch + static_cast<double>(io.MouseDelta.y) / height * 230, -89.0, 89.0);
    }
    if (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0)) {
        camera.pan_x += static_cast<double>(io.MouseDelta.x) / height / camera.zoom;
        camera.pan_y -= static_cast<double>(io.MouseDelta.y) / height / camera.zoom;
    }
    camera.zoom = std::clamp(camera.zoom * std::exp(0.15 * static_cast<double>(io.MouseWheel)), 0.2, 60.0);
}

/// True where the next drawable must hold something else.
bool steer_by_keys(Panel& panel) {
    if (ImGui::GetIO().WantCaptureKeyboard) return false;
    const auto pressed = [](int key) { return ImGui::IsKeyPressed(key); };
    Turntable& camera = panel.camera;
    if (pressed(GLFW_KEY_LEFT)) camera.yaw += 7;
    if (pressed(GLFW_KEY_RIGHT)) camera.yaw -= 7;
    if (pressed(GLFW_KEY_UP)) camera.pitch = std::min(89.0, camera.pitch + 7);
    if (pressed(GLFW_KEY_DOWN)) camera.pitch = std::max(-89.0, camera.pitch - 7);
    if (pressed(GLFW_KEY_EQUAL)) camera.zoom = std::min(60.0, camera.zoom * 1.15);
    if (pressed(GLFW_KEY_MINUS)) camera.zoom = std::max(0.2, camera.zoom / 1.15);
    if (pressed(GLFW_KEY_0)) camera.yaw = 30, camera.pitch = 15, camera.zoom = 1, camera.pan_x = camera.pan_y = 0;
    if (pressed(GLFW_KEY_F)) panel.look.flat = !panel.look.flat;
    if (pressed(GLFW_KEY_C)) panel.look.colors = !panel.look.colors;
    const bool wires = pressed(GLFW_KEY_W), base = pressed(GLFW_KEY_B);
    if (wires) panel.look.edges = !panel.look.edges;
    if (base) panel.look.base_edges = !panel.look.base_edges;
    return wires || base;
}

Result<void> save_window(const std::string& path, int width, int height) {
    Image image;
    image.width = static_cast<unsigned>(width);
    image.height = static_cast<unsigned>(height);
    const std::size_t row = std::size_t{image.width} * 3;
    image.rgb.resize(row * image.height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
    const auto at = [&](std::size_t y) { return image.rgb.begin() + static_cast<std::ptrdiff_t>(y * row); };
    for (std::size_t y = 0; y < image.height / 2; ++y) std::swap_ranges(at(y), at(y + 1), at(image.height - 1 - y));
    return write_png(path, image);
}

/// Of kSpeeds, the one nearest below; the slowest where all are above.
std::size_t fastest_within(double bytes_per_second) {
    std::size_t k = 0;
    while (k + 1 < kSpeeds.size() && kSpeeds[k].bytes_per_second > bytes_per_second) ++k;
    return k;
}

/// One window's loop: takes what is there, draws, asks for what is in view.
class Loop {
 public:
    Loop(const WindowOptions& options, GLFWwindow* window)
        : options_(options), window_(window), stream_(options.stream) {
        panel_.speed = fastest_within(options.bytes_per_second);
        pace_->bytes_per_second = options.bytes_per_second;
        stream_.pace = pace_;
        panel_.layer = static_cast<int>(std::min(options.layer, 255u));
        panel_.level = static_cast<int>(std::min(options.level, 255u));
        panel_.look.edges = options.wireframe;
        panel_.look.flat = options.flat;
        panel_.camera.yaw = options.yaw;
        panel_.camera.pitch = options.pitch;
        panel_.camera.z_up = options.z_up;
        load();
    }

    Result<WindowSummary> run() {
        if (const Result<void> started = renderer_.start(); !started.ok()) return started.error();
        while (glfwWindowShouldClose(window_) == GLFW_FALSE) {
            glfwPollEvents();
            const Result<bool> more = frame();
            if (!more.ok()) return more.error();
            if (!*more) break;
        }
        return summary_;
    }

 private:
    /// False once the screenshot is written.
    Result<bool> frame() {
        const auto begun = std::chrono::steady_clock::now();
        take_frame();
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        int width = 0, height = 0;
        glfwGetFramebufferSize(window_, &width, &height);
        steer_by_mouse(panel_.camera, std::max(height, 1));
        panel_.frame_rate = static_cast<double>(ImGui::GetIO().Framerate);
        panel_.message = model_->message();
        panel_.ended = model_->ended();
        const bool by_key = steer_by_keys(panel_);
        const PanelEvents events = draw_panel(panel_);
        if (events.speed) pace_->bytes_per_second = kSpeeds[panel_.speed].bytes_per_second;
        if (events.again) load();
        if (events.choice || by_key) model_->show(panel_.choice());
        ImGui::Render();
        summary_.longest_wait =
            std::max(summary_.longest_wait, Seconds(std::chrono::steady_clock::now() - begun).count());

        glViewport(0, 0, width, height);
        panel_.camera.aim(static_cast<double>(width) / std::max(height, 1),
                          width > 2 * kPanelWidth ? kPanelWidth / width : 0);
        renderer_.draw(panel_.camera, panel_.look);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        ++summary_.frames;
        ask_for_view(height);
        if (!options_.screenshot.empty() && model_->settled() && ++settled_frames_ > 2) return shoot(width, height);
        glfwSwapBuffers(window_);
        return true;
    }

    /// From its first byte. No frame waits for the model that was there to end.
    void load() {
        if (model_) leaving_ = std::async(std::launch::async, [old = std::move(model_)]() mutable { old.reset(); });
        panel_.bytes.reset();
        asked_view_ = {};
        model_ = std::make_unique<LiveModel>(options_.place, stream_);
        model_->show(panel_.choice());
    }

    void take_frame() {
        const std::unique_ptr<LiveFrame> fresh = model_->take();
        if (!fresh) return;
        if (!std::exchange(fitted_, true)) panel_.camera.fit(fresh->drawable);
        panel_.note(*fresh);
        renderer_.upload(fresh->drawable);
    }

    /// A few times a second, where the camera has moved or a first mesh has come.
    void ask_for_view(int height) {
        const auto now = std::chrono::steady_clock::now();
        if (!fitted_ || model_->ended() || now - asked_at_ < std::chrono::milliseconds(250) ||
            panel_.camera.view == asked_view_)
            return;
        asked_at_ = now;
        asked_view_ = panel_.camera.view;
        const Turntable& camera = panel_.camera;
        View view{camera.view, camera.projection[0], camera.projection[5], 0.05f * camera.radius};
        view.height = static_cast<unsigned>(std::max(height, 1));
        model_->look(view);
    }

    Result<bool> shoot(int width, int height) {
        if (panel_.triangles == 0) return Error{Errc::Io, 0, panel_.message};
        if (const Result<void> saved = save_window(options_.screenshot, width, height); !saved.ok())
            return saved.error();
        return false;
    }

    const WindowOptions& options_;
    GLFWwindow* window_;
    StreamOptions stream_;
    const std::shared_ptr<Pace> pace_ = std::make_shared<Pace>();
    std::unique_ptr<LiveModel> model_;
    std::future<void> leaving_;  // the model before it, which takes a moment to end
    LiveRenderer renderer_;
    Panel panel_;
    bool fitted_ = false;
    std::array<float, 16> asked_view_{};
    std::chrono::steady_clock::time_point asked_at_;
    unsigned settled_frames_ = 0;
    WindowSummary summary_;
};

}  // namespace

Result<WindowSummary> run_window(const WindowOptions& options) {
    const Result<std::unique_ptr<Glfw>> window = Glfw::open(options);
    if (!window.ok()) return window.error();
    return Loop(options, (*window)->get()).run();
}

}  // namespace mvw::client
