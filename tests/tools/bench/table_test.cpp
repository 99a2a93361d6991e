#include "tools/bench/table.h"

#include <gtest/gtest.h>

namespace mvw::bench {
namespace {

TEST(Table, QuotesWhatCsvWouldMisread) {
    const Table table{{"a", "b"}, {{"1,5", "say \"x\""}, {"", "two\nlines"}}};
    EXPECT_EQ(table.csv(), "a,b\n\"1,5\",\"say \"\"x\"\"\"\n,\"two\nlines\"\n");
}

TEST(Table, EscapesBarsInMarkdown) {
    const Table table{{"a", "b"}, {{"x|y", "two\nlines"}}};
    EXPECT_EQ(table.markdown(), "| a | b |\n| --- | --- |\n| x\\|y | two lines |\n");
}

}  // namespace
}  // namespace mvw::bench
