#include "tools/bench/process.h"

#include <gtest/gtest.h>

namespace mvw::bench {
namespace {

TEST(Process, KeepsOutputAndErrorsApart) {
    const auto run = run_process({"sh", "-c", "echo out; echo err >&2; exit 3"});
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(run->exit_code, 3);
    EXPECT_EQ(run->out, "out\n");
    EXPECT_EQ(run->errors, "err\n");
    EXPECT_GT(run->seconds, 0);
}

TEST(Process, TakesMoreOutputThanAPipeHolds) {
    const auto run = run_process({"sh", "-c", "head -c 1000000 /dev/zero"});
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(run->out.size(), 1000000u);
}

TEST(Process, TellsASignalFromAnExit) {
    const auto run = run_process({"sh", "-c", "kill -9 $$"});
    ASSERT_TRUE(run.ok());
    EXPECT_EQ(run->exit_code, -1);
}

TEST(Process, NamesTheProgramThatIsNotThere) {
    const auto run = run_process({"no-such-program-here"});
    ASSERT_FALSE(run.ok());
    EXPECT_EQ(run.error().code, Errc::Io);
    EXPECT_NE(run.error().message.find("no-such-program-here"), std::string::npos);
}

TEST(BackgroundProcess, SaysItsFirstLineAndEndsWithTheObject) {
    auto started = BackgroundProcess::start({"sh", "-c", "echo hello; echo more; sleep 60"});
    ASSERT_TRUE(started.ok());
    EXPECT_EQ(started->first_line(20), "hello");
}

TEST(BackgroundProcess, DoesNotWaitForeverForALine) {
    auto silent = BackgroundProcess::start({"sleep", "60"});
    ASSERT_TRUE(silent.ok());
    EXPECT_EQ(silent->first_line(0.05), "");
    auto ended = BackgroundProcess::start({"true"});
    ASSERT_TRUE(ended.ok());
    EXPECT_EQ(ended->first_line(20), "");
}

}  // namespace
}  // namespace mvw::bench
