#include "server/origin/cached_file.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/stream_models.h"

namespace mvw::server {
namespace {

constexpr std::uint64_t kBlock = CachedFile::kBlockBytes;

class CachedFileTest : public testing::Test {
 protected:
    CachedFileTest() : bytes_(3 * kBlock + 1000) {
        std::minstd_rand random(1);
        for (std::byte& b : bytes_) b = static_cast<std::byte>(random() >> 8);
    }
    [[nodiscard]] std::shared_ptr<CachedFile> open() const {
        return CachedFile::open(server::open_folder(folder_.path()).get(), "m", bytes_.size()).value();
    }
    static Bytes read(const CachedFile& file, std::uint64_t offset, std::size_t length) {
        Bytes out(length);
        EXPECT_TRUE(file.read(offset, out).ok());
        return out;
    }

    test::TemporaryFolder folder_;
    Bytes bytes_;
};

TEST_F(CachedFileTest, HasWhatWasPutAndNothingElse) {
    const auto file = open();
    EXPECT_FALSE(file->has(0, 1));
    ASSERT_TRUE(file->put(kBlock, ByteSpan(bytes_).subspan(kBlock, kBlock + 10)).ok());
    EXPECT_TRUE(file->has(kBlock, kBlock));
    EXPECT_FALSE(file->has(kBlock - 1, 2));
    EXPECT_FALSE(file->has(2 * kBlock, 1)) << "a block that came in part";
    EXPECT_EQ(read(*file, kBlock + 5, 100), Bytes(bytes_.begin() + kBlock + 5, bytes_.begin() + kBlock + 105));
    Bytes out(10);
    EXPECT_EQ(file->read(0, out).error().code, Errc::Io);
    ASSERT_TRUE(file->put(3 * kBlock, ByteSpan(bytes_).subspan(3 * kBlock)).ok());
    EXPECT_TRUE(file->has(3 * kBlock, 1000)) << "the last block is shorter";
    EXPECT_FALSE(file->has(3 * kBlock, 1001)) << "beyond the end";
}

TEST_F(CachedFileTest, IsThereAfterARestart) {
    ASSERT_TRUE(open()->put(0, bytes_).ok());
    const auto file = open();
    EXPECT_TRUE(file->has(0, bytes_.size()));
    EXPECT_EQ(read(*file, 0, bytes_.size()), bytes_);
}

TEST_F(CachedFileTest, BlocksWhoseBytesChangedAreNotTrusted) {
    ASSERT_TRUE(open()->put(0, bytes_).ok());
    Bytes damaged = bytes_;
    damaged[kBlock + 7] ^= std::byte{1};
    folder_.overwrite("m.origin", damaged);
    const auto file = open();
    EXPECT_TRUE(file->has(0, kBlock));
    EXPECT_FALSE(file->has(kBlock, 1));
    EXPECT_TRUE(file->has(2 * kBlock, kBlock + 1000));
    ASSERT_TRUE(file->put(kBlock, ByteSpan(bytes_).subspan(kBlock, kBlock)).ok());
    EXPECT_EQ(read(*open(), 0, bytes_.size()), bytes_) << "mended";
}

TEST_F(CachedFileTest, EveryCutOfTheListLeavesSoundBlocks) {
    ASSERT_TRUE(open()->put(0, bytes_).ok());
    for (std::size_t cut = 0; cut <= 32; ++cut) {
        std::filesystem::resize_file(folder_.path("m.blocks"), 32 - cut);
        const auto file = open();
        for (std::uint64_t block = 0; block < 4; ++block)
            EXPECT_EQ(file->has_block(block), (block + 1) * 8 <= 32 - cut) << cut;
    }
}

TEST_F(CachedFileTest, AnotherSizeStartsAnew) {
    ASSERT_TRUE(open()->put(0, bytes_).ok());
    bytes_.resize(2 * kBlock);
    const auto file = open();
    EXPECT_FALSE(file->has_block(0));
    EXPECT_EQ(file->blocks(), 2u);
}

}  // namespace
}  // namespace mvw::server
