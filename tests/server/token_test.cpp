#include "server/token.h"

#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace mvw::server {
namespace {

constexpr const char* kKey = "0123456789abcdef-key";
constexpr std::int64_t kNow = 1'800'000'000;

TEST(Token, AllowsWhatItsPatternNamesUntilItExpires) {
    const TokenKeys keys({kKey});
    const std::string token = make_token(kKey, "scans/*", kNow + 10).value();
    EXPECT_TRUE(keys.check(token, "scans/bunny", kNow).ok());
    EXPECT_TRUE(keys.check(token, "scans/deep/bunny.mvw", kNow).ok());
    EXPECT_FALSE(keys.check(token, "other/bunny", kNow).ok());
    EXPECT_FALSE(keys.check(token, "scans", kNow).ok());
    EXPECT_TRUE(keys.check(token, "scans/bunny", kNow + 9).ok());
    EXPECT_FALSE(keys.check(token, "scans/bunny", kNow + 10).ok());
    EXPECT_FALSE(keys.check("", "scans/bunny", kNow).ok());
}

TEST(Token, AnyChangedCharacterIsRefused) {
    const TokenKeys keys({kKey});
    const std::string token = make_token(kKey, "*", kNow + 10).value();
    ASSERT_TRUE(keys.check(token, "a", kNow).ok());
    for (std::size_t i = 0; i < token.size(); ++i) {
        std::string changed = token;
        changed[i] = changed[i] == '1' ? '2' : '1';
        EXPECT_FALSE(keys.check(changed, "a", kNow).ok()) << changed;
        EXPECT_FALSE(keys.check(token.substr(0, i), "a", kNow).ok());
    }
    EXPECT_FALSE(keys.check(token + "A", "a", kNow).ok());
}

TEST(Token, EitherOfTwoKeysSignsAndNoOther) {
    const TokenKeys keys({"an old key of enough bytes", kKey});
    EXPECT_TRUE(keys.check(make_token(kKey, "*", kNow + 1).value(), "a", kNow).ok());
    EXPECT_TRUE(keys.check(make_token("an old key of enough bytes", "*", kNow + 1).value(), "a", kNow).ok());
    EXPECT_FALSE(keys.check(make_token("somebody else's good key", "*", kNow + 1).value(), "a", kNow).ok());
}

TEST(Token, KeyFilesAreReadWithCommentsAndRefusedWithShortKeys) {
    const ScratchFolder folder;
    write_text(folder / "keys", std::string("# first\n\n") + kKey + "\r\nanother key of 16+ bytes\n");
    EXPECT_EQ(TokenKeys::read(folder / "keys").value().keys(),
              (std::vector<std::string>{kKey, "another key of 16+ bytes"}));
    write_text(folder / "short", "tooshort\n");
    EXPECT_EQ(TokenKeys::read(folder / "short").error().code, Errc::InvalidArgument);
    write_text(folder / "none", "# nothing\n");
    EXPECT_EQ(TokenKeys::read(folder / "none").error().code, Errc::InvalidArgument);
    EXPECT_EQ(TokenKeys::read(folder / "absent").error().code, Errc::Io);
    EXPECT_EQ(make_token("short", "*", kNow).error().code, Errc::InvalidArgument);
}

TEST(Token, StarsMatchAnyRun) {
    EXPECT_TRUE(matches("*", ""));
    EXPECT_TRUE(matches("a*c*", "abbbc"));
    EXPECT_TRUE(matches("*bunny", "scans/bunny"));
    EXPECT_FALSE(matches("a*c", "abcd"));
    EXPECT_FALSE(matches("", "a"));
    EXPECT_TRUE(matches("a**b", "ab"));
}

}  // namespace
}  // namespace mvw::server
