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
    row("Bytes", fmt::format("{} of {}", bytes_text(p.bytes ? static_cast<double>(*p.bytes) : p.arrived),
                             bytes_text(static_cast<double>(p.file_bytes))));
    row("Error", fmt::format("{:.2g} % ({:.1f} dB)", p.state.error * 100, -20 * std::log10(p.state.error)));
    row("Vertices", fmt::format("{}", p.vertices));
    row("Triangles", fmt::format("{}", p.triangles));
    row("Level", fmt::format("{} of {}", p.drawn_level, p.levels));
    row("Decoding", fmt::format("{:.0f} ms", p.decode_seconds * 1000));
    row("Mesh made in", fmt::format("{:.0f} ms", p.draw_seconds * 1000));
    row("Frames", fmt::format("{:.0f} /s", p.frame_rate));
    ImGui::EndTable();
}

/// Error against bytes, logarithmic along, the present point on it; pulled, the model goes back to that many bytes.
/// True where people pulled.
bool draw_plot(Panel& p) {
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 90), corner = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, IM_COL32(255, 255, 255, 12), 4);
    ImGui::InvisibleButton("plot", size);
    if (p.curve.empty()) return false;
    const auto [low, high] =
        std::minmax_element(p.curve.begin(), p.curve.end(), [](const auto& a, const auto& b) { return a[1] < b[1]; });
    const float bottom = (*low)[1] - 3, top = (*high)[1] + 3, left = std::log(p.curve.front()[0]);
    const float right = std::max(std::log(std::max<float>(1, static_cast<float>(p.file_bytes))), left + 1);
    const auto across = [&](float bytes) {
        return corner.x + 6 + (std::log(bytes) - left) / (right - left) * (size.x - 12);
    };
    bool pulled = false;
    if (ImGui::IsItemActive()) {
        const float part = std::clamp((ImGui::GetIO().MousePos.x - corner.x - 6) / (size.x - 12), 0.0f, 1.0f);
        const float bytes = std::exp(left + part * (right - left));
        p.bytes = bytes < p.curve.back()[0] ? std::optional(bytes) : std::nullopt;
        pulled = true;
    }
    std::vector<ImVec2> points;
    ImVec2 present;
    for (const auto& [bytes, level] : p.curve) {
        points.emplace_back(across(bytes), corner.y + size.y - 6 - (level - bottom) / (top - bottom) * (size.y - 12));
        if (!p.bytes || bytes <= *p.bytes || points.size() == 1) present = points.back();
    }
    list.AddPolyline(points.data(), static_cast<int>(points.size()), kAccent, 0, 2);
    list.AddCircleFilled(present, 4, kAccent);
    ImGui::TextDisabled("error against bytes, %.0f to %.0f dB", static_cast<double>((*low)[1]),
                        static_cast<double>((*high)[1]));
    return pulled;
}

/// 0 to `most`; the last means all, kept as 255. True where it has changed.
bool slide(const char* name, int& value, unsigned most) {
    if (most == 0) return false;
    int shown = std::min(value, static_cast<int>(most));
    if (!ImGui::SliderInt(name, &shown, 0, static_cast<int>(most))) return false;
    value = shown == static_cast<int>(most) ? 255 : shown;
    return true;
}

void draw_link(Panel& p, PanelEvents& events) {
    for (std::size_t k = 0; k < kSpeeds.size(); ++k) {
        if (k > 0) ImGui::SameLine();
        if (ImGui::RadioButton(kSpeeds[k].name, p.speed == k)) {
            p.speed = k;
            events.speed = true;
        }
    }
    events.again = ImGui::Button("Load again");
}

}  // namespace

void Panel::note(const LiveFrame& frame) {
    state = frame.state;
    vertices = frame.drawable.positions.size();
    triangles = frame.drawable.triangles.size() / 3;
    drawn_level = frame.drawable.level;
    levels = frame.levels;
    file_bytes = frame.file_bytes;
    layers = frame.layers;
    arrived = frame.arrived;
    draw_seconds = frame.draw_seconds;
    decode_seconds = frame.decode_seconds;
    has_colors = !frame.drawable.colors.empty();
    curve = frame.curve;
    for (auto& point : curve) point[1] = -20 * std::log10(std::max(point[1], 1e-7f));
}

LiveChoice Panel::choice() const {
    LiveChoice choice;
    choice.lines = {static_cast<unsigned>(level), look.edges, look.base_edges};
    choice.layer = static_cast<unsigned>(layer);
    if (bytes) choice.bytes = static_cast<double>(*bytes);
    return choice;
}

PanelEvents draw_panel(Panel& p) {
    PanelEvents events;
    ImGui::SetNextWindowPos({16, 16}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({296, 0}, ImGuiCond_Always);
    ImGui::Begin("mvw", nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings);
    ImGui::TextColored({0.95f, 0.65f, 0.35f, 1}, "%s",
                       !p.message.empty() ? "no connection"
                       : p.ended          ? "complete"
                                          : "refining");
    if (!p.message.empty()) ImGui::TextWrapped("%s", p.message.c_str());
    draw_figures(p);
    events.choice |= draw_plot(p);
    if (p.bytes && ImGui::Button("Back to all")) {
        p.bytes.reset();
        events.choice = true;
    }
    ImGui::Separator();
    events.choice |= ImGui::Checkbox("Wireframe", &p.look.edges);
    ImGui::SameLine(140);
    events.choice |= ImGui::Checkbox("Base edges", &p.look.base_edges);
    ImGui::Checkbox("Flat", &p.look.flat);
    ImGui::SameLine(140);
    if (p.has_colors) ImGui::Checkbox("Colours", &p.look.colors);
    ImGui::Checkbox("Z up", &p.camera.z_up);
    events.choice |= slide("Level", p.level, p.levels);
    events.choice |= slide("Layer", p.layer, p.layers > 0 ? p.layers - 1 : 0);
    ImGui::Separator();
    draw_link(p, events);
    ImGui::TextDisabled("drag: turn   right: move   wheel: zoom\nW wires   B base   C colours\nF flat    0 back");
    ImGui::End();
    return events;
}

}  // namespace mvw::client
