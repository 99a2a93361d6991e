#include "client/viewer/window/controls.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace mvw::client {
namespace {

constexpr ImU32 kAccent = IM_COL32(242, 166, 90, 255);

std::string bytes_text(double bytes) {
    if (bytes < 1024) return fmt::format("{:.0f} B", bytes);
    if (bytes < 1024 * 1024) return fmt::format("{:.1f} KB", bytes / 1024);
    return fmt::format("{:.1f} MB", bytes / 1024 / 1024);
}

void row(const char* name, const std::string& value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextDisabled("%s", name);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(value.c_str());
}

void draw_figures(const Panel& p) {
    if (!ImGui::BeginTable("figures", 2)) return;
    row("Bytes", fmt::format("{} of {}", bytes_text(static_cast<double>(p.state.bytes)),
                             bytes_text(static_cast<double>(p.file_bytes))));
    row("Error", fmt::format("{:.2g} % ({:.1f} dB)", p.state.error * 100, -20 * std::log10(p.state.error)));
    row("Vertices", fmt::format("{}", p.vertices));
    row("Triangles", fmt::format("{}", p.triangles));
    row("Level", fmt::format("{} of {}", p.drawn_level, p.levels));
    row("Mesh made in", fmt::format("{:.0f} ms", p.draw_seconds * 1000));
    row("Frames", fmt::format("{:.0f} /s", p.frame_rate));
    ImGui::EndTable();
}

/// Error against bytes, logarithmic along, the present point at its end.
void draw_plot(const Panel& p) {
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 90), corner = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, IM_COL32(255, 255, 255, 12), 4);
    ImGui::Dummy(size);
    if (p.curve.empty()) return;
    const auto [low, high] =
        std::minmax_element(p.curve.begin(), p.curve.end(), [](const auto& a, const auto& b) { return a[1] < b[1]; });
    const float bottom = (*low)[1] - 3, top = (*high)[1] + 3, left = std::log(p.curve.front()[0]);
    const float right = std::max(std::log(std::max<float>(1, static_cast<float>(p.file_bytes))), left + 1);
    std::vector<ImVec2> points;
    for (const auto& [bytes, level] : p.curve)
        points.emplace_back(corner.x + 6 + (std::log(bytes) - left) / (right - left) * (size.x - 12),
                            corner.y + size.y - 6 - (level - bottom) / (top - bottom) * (size.y - 12));
    list.AddPolyline(points.data(), static_cast<int>(points.size()), kAccent, 0, 2);
    list.AddCircleFilled(points.back(), 4, kAccent);
    ImGui::TextDisabled("error against bytes, %.0f to %.0f dB", static_cast<double>((*low)[1]),
                        static_cast<double>((*high)[1]));
}

}  // namespace

void Panel::note(const LiveFrame& frame) {
    state = frame.state;
    vertices = frame.drawable.positions.size();
    triangles = frame.drawable.triangles.size() / 3;
    drawn_level = frame.drawable.level;
    levels = frame.levels;
    file_bytes = frame.file_bytes;
    draw_seconds = frame.draw_seconds;
    has_colors = !frame.drawable.colors.empty();
    curve = frame.curve;
    for (auto& point : curve) point[1] = -20 * std::log10(std::max(point[1], 1e-7f));
}

DrawableOptions Panel::drawable_options() const {
    return {static_cast<unsigned>(level), look.edges, look.base_edges};
}

bool draw_panel(Panel& p) {
    bool anew = false;
    ImGui::SetNextWindowPos({16, 16}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({280, 0}, ImGuiCond_Always);
    ImGui::Begin("mvw", nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings);
    ImGui::TextColored({0.95f, 0.65f, 0.35f, 1}, "%s",
                       !p.message.empty() ? "no connection"
                       : p.ended          ? "complete"
                                          : "refining");
    if (!p.message.empty()) ImGui::TextWrapped("%s", p.message.c_str());
    draw_figures(p);
    draw_plot(p);
    ImGui::Separator();
    anew |= ImGui::Checkbox("Wireframe", &p.look.edges);
    ImGui::SameLine(140);
    anew |= ImGui::Checkbox("Base edges", &p.look.base_edges);
    ImGui::Checkbox("Flat", &p.look.flat);
    ImGui::SameLine(140);
    if (p.has_colors) ImGui::Checkbox("Colours", &p.look.colors);
    ImGui::Checkbox("Z up", &p.camera.z_up);
    int level = std::min(p.level, static_cast<int>(p.levels));
    if (p.levels > 0 && ImGui::SliderInt("Level", &level, 0, static_cast<int>(p.levels))) {
        p.level = level == static_cast<int>(p.levels) ? 255 : level;
        anew = true;
    }
    ImGui::TextDisabled("drag: turn   right: move   wheel: zoom\nW wires  B base  F flat  0 back");
    ImGui::End();
    return anew;
}

}  // namespace mvw::client
