#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stb_image.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "codec/mesh/io/mesh_io.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

constexpr const char* kTetrahedron = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

TEST(ViewCommand, WritesAPictureOfTheSizeAskedFor) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    const ProgramRun run =
        run_mvw({"view", folder / "a.off", "--screenshot", folder / "a.png", "--size", "120x80", "--wireframe"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    int w = 0, h = 0, n = 0;
    EXPECT_NE(stbi_info((folder / "a.png").c_str(), &w, &h, &n), 0);
    EXPECT_EQ(w, 120);
    EXPECT_EQ(h, 80);
}

TEST(ViewCommand, DrawsTheLevelAskedForOfAnEncodedModel) {
    const ScratchFolder folder;
    ASSERT_TRUE(write_mesh(folder / "a.ply", torus(48, 24)).ok());
    ASSERT_EQ(run_mvw({"encode", folder / "a.ply", folder / "a.mvw"}).exit_code, 0);
    const auto draw = [&](const std::vector<std::string>& extra) {
        std::vector<std::string> arguments{"view",           folder / "a.mvw", "--screenshot",
                                           folder / "a.png", "--size",         "99x99"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        EXPECT_EQ(run_mvw(arguments).exit_code, 0);
        return read_text(folder / "a.png");
    };
    EXPECT_NE(draw({}), draw({"--level", "0"}));
    EXPECT_EQ(run_mvw({"view", folder / "a.ply", "--screenshot", folder / "b.png", "--level", "0"}).exit_code, 2);
}

TEST(ViewCommand, AnimatesAModelRefining) {
    const ScratchFolder folder;
    ASSERT_TRUE(write_mesh(folder / "a.ply", torus(48, 24)).ok());
    ASSERT_EQ(run_mvw({"encode", folder / "a.ply", folder / "a.mvw"}).exit_code, 0);
    const ProgramRun run =
        run_mvw({"view", folder / "a.mvw", "--animation", folder / "a.webp", "--size", "120x90", "--pitch", "60"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const std::string webp = read_text(folder / "a.webp");
    EXPECT_EQ(webp.substr(0, 4) + webp.substr(8, 4), "RIFFWEBP");
    std::size_t frames = 0;
    for (std::size_t at = webp.find("ANMF"); at != std::string::npos; at = webp.find("ANMF", at + 4)) ++frames;
    EXPECT_GE(frames, 4u);
    EXPECT_EQ(run_mvw({"view", folder / "a.ply", "--animation", folder / "b.webp"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"view", folder / "a.mvw", "--animation", folder / "no/where.webp"}).exit_code, 1);
}

TEST(ViewCommand, SaysWhatIsWrongWithItsArguments) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    EXPECT_EQ(run_mvw({"view", folder / "a.off"}).exit_code, 2);
    EXPECT_THAT(run_mvw({"view", folder / "a.off"}).errors, testing::HasSubstr("--screenshot"));
    EXPECT_EQ(run_mvw({"view", folder / "a.mvw", "--controls"}).exit_code, 2);
    for (const char* size : {"12", "12x", "x12", "12x12x", "0x10", "99999x10"}) {
        const ProgramRun run = run_mvw({"view", folder / "a.off", "--screenshot", folder / "b.png", "--size", size});
        EXPECT_EQ(run.exit_code, 2) << size;
        EXPECT_EQ(read_text(folder / "b.png"), "");
    }
}

TEST(ViewCommand, NamesTheFileThatItCannotReadOrWrite) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    const ProgramRun missing = run_mvw({"view", folder / "b.off", "--screenshot", folder / "a.png"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_THAT(missing.errors, testing::HasSubstr(folder / "b.off"));
    const ProgramRun nowhere = run_mvw({"view", folder / "a.off", "--screenshot", folder / "no/where.png"});
    EXPECT_EQ(nowhere.exit_code, 1);
    EXPECT_THAT(nowhere.errors, testing::HasSubstr(folder / "no/where.png"));
}

/// A display of its own, gone with the object.
class VirtualDisplay {
 public:
    VirtualDisplay() {
        display_ = ":" + std::to_string(400 + ::getpid() % 500);
        pid_ = ::fork();
        if (pid_ == 0) {
            ::execlp("Xvfb", "Xvfb", display_.c_str(), "-screen", "0", "1000x700x24", "-nolisten", "tcp", nullptr);
            ::_exit(127);
        }
        ::setenv("DISPLAY", display_.c_str(), 1);
        const std::string socket = "/tmp/.X11-unix/X" + display_.substr(1);
        for (int i = 0; i < 200 && ::access(socket.c_str(), F_OK) != 0; ++i) ::usleep(50'000);
    }
    ~VirtualDisplay() {
        ::unsetenv("DISPLAY");
        ::kill(pid_, SIGTERM);
        ::waitpid(pid_, nullptr, 0);
    }
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;

 private:
    std::string display_;
    pid_t pid_ = 0;
};

using Pixels = std::vector<unsigned char>;

Pixels read_pixels(const std::string& path, int width, int height) {
    int w = 0, h = 0, n = 0;
    stbi_uc* pixels = stbi_load(path.c_str(), &w, &h, &n, 3);
    EXPECT_TRUE(pixels != nullptr && w == width && h == height) << path;
    if (pixels == nullptr || w != width || h != height) return {};
    Pixels picture(pixels, pixels + std::size_t{3} * static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    stbi_image_free(pixels);
    return picture;
}

std::size_t differing(const Pixels& a, const Pixels& b) {
    if (a.size() != b.size()) return std::max(a.size(), b.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += std::abs(a[i] - b[i]) > 16;
    return count;
}

TEST(ViewCommand, AWindowShowsTheModelAndItsControls) {
    const VirtualDisplay display;
    const ScratchFolder folder;
    const auto shoot = [&](const std::string& model, const std::vector<std::string>& extra = {}) {
        std::vector<std::string> arguments{"view",         test_data_folder() + "/" + model + ".mvw",
                                           "--screenshot", folder / "a.png",
                                           "--controls",   "--size",
                                           "640x420"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        const ProgramRun run = run_mvw(arguments);
        EXPECT_EQ(run.exit_code, 0) << run.errors;
        return read_pixels(folder / "a.png", 640, 420);
    };
    const Pixels plain = shoot("golden_mixed");
    EXPECT_LT(differing(plain, shoot("golden_mixed")), 3000u);  // figures of time and frames
    EXPECT_GT(differing(plain, shoot("golden_mixed", {"--wireframe"})), 5000u);
    EXPECT_GT(differing(plain, shoot("golden_mixed", {"--level", "0"})), 5000u);
    EXPECT_GT(differing(plain, shoot("golden_mixed", {"--layer", "0"})), 2000u);
    EXPECT_GT(differing(plain, shoot("golden_mixed", {"--z-up"})), 5000u);
    // As they were when somebody looked at them: all but 3 % of the picture's values.
    for (const char* model : {"golden_mixed", "golden_colors"}) {
        const Pixels now = shoot(model);
        const std::string reference = test_data_folder() + "/window/" + model + ".png";
        if (std::getenv("MVW_UPDATE_PICTURES") != nullptr)
            std::filesystem::copy_file(folder / "a.png", reference, std::filesystem::copy_options::overwrite_existing);
        EXPECT_LT(differing(now, read_pixels(reference, 640, 420)), now.size() * 3 / 100) << reference;
    }
}

/// A square of backs, with fronts behind it: 0.2 % of the diagonal away on the left, 2 % on the right.
std::string backs_before_fronts() {
    std::string obj;
    unsigned vertices = 0;
    const auto add_square = [&](double from_x, double to_x, double z, bool front) {
        for (const auto& [x, y] : {std::pair{from_x, -0.5}, {to_x, -0.5}, {to_x, 0.5}, {from_x, 0.5}})
            obj += fmt::format("v {} {} {}\n", x, y, z);
        const unsigned a = vertices + 1, b = a + 1, c = a + 2, d = a + 3;
        obj += front ? fmt::format("f {} {} {} {}\n", a, b, c, d) : fmt::format("f {} {} {} {}\n", d, c, b, a);
        vertices += 4;
    };
    const double diagonal = std::sqrt(2.0);
    add_square(-0.5, 0.5, 0, false);
    add_square(-0.5, 0, -0.002 * diagonal, true);
    add_square(0, 0.5, -0.02 * diagonal, true);
    return obj;
}

/// Pixels that are redder than anything but backs.
std::size_t red_pixels(const Pixels& picture) {
    std::size_t count = 0;
    for (std::size_t i = 0; i + 2 < picture.size(); i += 3)
        count += picture[i] > 80 && 5 * picture[i] > 7 * picture[i + 1] && 5 * picture[i] > 7 * picture[i + 2];
    return count;
}

TEST(ViewCommand, BacksAreSeenUnlessAFrontIsCloseBehindThem) {
    const VirtualDisplay display;
    const ScratchFolder folder;
    write_text(folder / "a.obj", backs_before_fronts());
    ASSERT_EQ(run_mvw({"encode", folder / "a.obj", folder / "a.mvw"}).exit_code, 0);
    for (const bool window : {false, true}) {
        std::vector<std::string> arguments{
            "view", folder / "a.mvw", "--screenshot", folder / "a.png", "--size", "640x420", "--yaw", "0", "--pitch",
            "0"};
        if (window) arguments.emplace_back("--controls");
        ASSERT_EQ(run_mvw(arguments).exit_code, 0);
        const Pixels picture = read_pixels(folder / "a.png", 640, 420);
        ASSERT_FALSE(picture.empty());
        Pixels left, right;  // of the middle of the square, which lies in the middle of what the controls leave free
        const int middle = window ? 480 : 320;
        for (int y = 150; y < 270; ++y)
            for (int x = -60; x < 60; ++x) {
                const std::size_t at =
                    3 * (std::size_t{640} * static_cast<std::size_t>(y) + static_cast<std::size_t>(middle + x));
                if (std::abs(x) < 4) continue;
                Pixels& side = x < 0 ? left : right;
                side.insert(side.end(), picture.begin() + static_cast<std::ptrdiff_t>(at),
                            picture.begin() + static_cast<std::ptrdiff_t>(at + 3));
            }
        EXPECT_EQ(red_pixels(left), 0u) << (window ? "window" : "picture");
        EXPECT_EQ(red_pixels(right), right.size() / 3) << (window ? "window" : "picture");
    }
}

TEST(ViewCommand, WithoutADisplayThereIsNoWindow) {
    ::unsetenv("DISPLAY");
    ::unsetenv("WAYLAND_DISPLAY");
    const ProgramRun run = run_mvw({"view", test_data_folder() + "/golden_mixed.mvw"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, testing::HasSubstr("display"));
}

}  // namespace
}  // namespace mvw
