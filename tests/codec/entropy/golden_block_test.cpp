// Bytes that must never change without a new version of the format. Every platform must write and read these.
#include <gtest/gtest.h>

#include <string>

#include "codec/entropy/dec_block.h"
#include "codec/entropy/enc_block.h"

namespace mvw {
namespace {

std::string hex(ByteSpan bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string text;
    for (const std::byte b : bytes) {
        text += kDigits[std::to_integer<unsigned>(b) >> 4];
        text += kDigits[std::to_integer<unsigned>(b) & 15];
    }
    return text;
}

/// A patch of a tetrahedron with a few active places, in whole steps.
std::vector<float> coefficients(std::size_t count) {
    std::vector<float> scaled(count, 0.0f);
    for (std::size_t at = 0; at < count; ++at)
        if (at % 60 < 12) scaled[at] = static_cast<float>(static_cast<int>(at * 37 % 19) - 9);
    return scaled;
}

TEST(GoldenBlock, PlanesOfTwoLevelsHaveTheseBytes) {
    const BaseMesh base = BaseMesh::create(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}).value();
    const Tiling tiling(base, std::vector<std::uint16_t>(4, 0), 1);
    const BlockShape coarse(base, tiling, 0, 2), fine(base, tiling, 0, 3);
    const EncodedBlock below = encode_block(coarse, 3, coefficients(coarse.size() * 3), {}, 0.4f);
    const EncodedBlock block = encode_block(fine, 3, coefficients(fine.size() * 3), below.entries, 0.4f);
    std::vector<std::string> planes;
    for (const EncodedBlock* b : {&below, &block})
        for (const EncodedPlane& p : b->planes) planes.push_back(std::to_string(p.plane) + " " + hex(p.bytes));
    const std::vector<std::string> expected = {"3 00010480",
                                               "2 7c20bad4b280",
                                               "1 a23d853ab0",
                                               "0 0f8c10250c",
                                               "3 00010496eba1de0894",
                                               "2 7d8a514b5c71236fd91482dce60b6d98",
                                               "1 9ce19e44497ef447fba940e56c",
                                               "0 10324f7a4ce24e98ada1909446"};
    EXPECT_EQ(planes, expected);
}

}  // namespace
}  // namespace mvw
