#include "tools/bench/decode_speed.h"

#include <gtest/gtest.h>

#include "tests/support/encoded_models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw::bench {
namespace {

TEST(DecodeSpeed, DracoIsGivenTheSameVerticesAndComesAsNear) {
    EncodeOptions options;
    options.tile_count = 4;
    const Bytes file = encode_parts({bumpy_ball(4)}, options).file;
    const Mesh input = plain(bumpy_ball(5));
    const Mesh coded = plain(bumpy_ball(4));
    std::vector<Contender> contenders{own_decoder(input, file, 1, "mvw")};
    contenders.push_back(draco_decoder(input, coded, contenders[0].time.psnr));
    time_in_turn(contenders);
    const DecodeTime &own = contenders[0].time, &draco = contenders[1].time;
    EXPECT_EQ(own.bytes, file.size());
    EXPECT_EQ(own.vertices, draco.vertices);
    EXPECT_GE(draco.psnr, own.psnr - 0.05);
    EXPECT_GT(own.seconds, 0);
    EXPECT_GT(draco.seconds, 0);
}

TEST(DecodeSpeed, AChunkIsTimedWithTheMeshItGives) {
    const DecodeTime chunk = time_chunk(encode_parts({bumpy_ball(4)}, {}).file);
    EXPECT_EQ(chunk.vertices, plain(bumpy_ball(4)).positions.size());
    EXPECT_GT(chunk.bytes, 0u);
    EXPECT_GT(chunk.seconds, 0);
}

}  // namespace
}  // namespace mvw::bench
