#include "tools/bench/cuts.h"

#include <gtest/gtest.h>

#include "tests/support/encoded_models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw::bench {
namespace {

TEST(Cuts, MoreBytesOfAFileNeverRaiseItsError) {
    const Mesh ball = plain(bumpy_ball(4));
    EncodeOptions options;
    options.target_error = 1e-4;
    const Bytes file = encode_parts({bumpy_ball(4)}, options).file;
    const Cuts cuts = cut(ball, file, 60, 8'000);
    EXPECT_LE(cuts.largest_rise, 0.05);
    EXPECT_GE(cuts.qualities, 45u) << "but for cuts some bytes apart, each is a quality of its own";
    EXPECT_EQ(cuts.points.back().bytes, file.size());
}

}  // namespace
}  // namespace mvw::bench
