#include "client/viewer/image.h"

#include <gtest/gtest.h>
#include <stb_image.h>

#include <cstdio>
#include <filesystem>

namespace mvw {
namespace {

Image plain(unsigned width, unsigned height, std::uint8_t value) {
    return {width, height, std::vector<std::uint8_t>(std::size_t{3} * width * height, value)};
}

TEST(Png, ReadsBackAsWritten) {
    Image image = plain(7, 5, 0);
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<std::uint8_t>(2 * i);
    const std::string path = testing::TempDir() + "mvw_png_test.png";
    ASSERT_TRUE(write_png(path, image).ok());
    int w = 0, h = 0, n = 0;
    std::uint8_t* back = stbi_load(path.c_str(), &w, &h, &n, 3);
    ASSERT_NE(back, nullptr);
    EXPECT_EQ(w, 7);
    EXPECT_EQ(h, 5);
    EXPECT_EQ(std::vector<std::uint8_t>(back, back + image.rgb.size()), image.rgb);
    stbi_image_free(back);
    std::filesystem::remove(path);
}

TEST(Png, NamesTheFileThatCannotBeWritten) {
    const auto written = write_png("/nowhere/at/all.png", plain(2, 2, 0));
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().code, Errc::Io);
    EXPECT_NE(written.error().message.find("/nowhere/at/all.png"), std::string::npos);
}

TEST(ContactSheet, PlacesPicturesInRowsWithTheirCaptions) {
    const std::vector<SheetEntry> entries{
        {plain(60, 40, 100), "a"}, {plain(50, 40, 110), "b\nc"}, {plain(60, 30, 120), ""}};
    const Image sheet = contact_sheet(entries, 2);
    EXPECT_GT(sheet.width, 120u);
    EXPECT_GT(sheet.height, 2 * 40u + 2 * 2 * 20u);
    std::size_t by_value[256] = {};
    for (std::size_t i = 0; i < sheet.rgb.size(); i += 3) ++by_value[sheet.rgb[i]];
    EXPECT_EQ(by_value[100], 60u * 40u);
    EXPECT_EQ(by_value[110], 50u * 40u);
    EXPECT_EQ(by_value[120], 60u * 30u);
    EXPECT_GT(by_value[40], 40u);  // ink
}

TEST(ContactSheet, CutsCaptionsThatAreTooLong) {
    const Image sheet = contact_sheet({{plain(10, 10, 0), std::string(5000, '#')}}, 3);
    EXPECT_EQ(sheet.width, 10u + 2 * 12u);
}

}  // namespace
}  // namespace mvw
