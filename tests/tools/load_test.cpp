// Small runs of the load and soak benches: that they measure and notice.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw {
namespace {

/// AddressSanitizer keeps what has been freed for a while, which is not what is measured here.
void keep_little_of_what_is_freed() {
    ::setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 0);
}

TEST(LoadBench, MeasuresThroughputFirstChunksAndIdleMemory) {
    const test::TemporaryFolder folder;
    folder.put("a.mvw", test::make_stream_file({.payload_bytes = 5000}));
    keep_little_of_what_is_freed();
    const ProgramRun run = run_mvw({"bench", "load", folder.path(), "--idle", "300", "--clients", "4", "--streams",
                                    "50", "--seconds", "0.3", "--rounds", "1", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto rows = nlohmann::json::parse(run.out)["measures"];
    EXPECT_GE(rows.size(), 4u);
    const double idle = std::stod(rows.back()["value"].get<std::string>());
    EXPECT_LT(idle, 300 * 0.02 + 1) << "200 MB for 10,000 connections are 20 KB each";
}

TEST(SoakBench, ServerStaysUpAndItsMemoryFlat) {
    const test::TemporaryFolder folder;
    folder.put("a.mvw", test::make_stream_file({.payload_bytes = 5000}));
    keep_little_of_what_is_freed();
    const ProgramRun run = run_mvw({"bench", "soak", folder.path(), "--seconds", "4", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(nlohmann::json::parse(run.out)["steps"].size(), 20u);
}

}  // namespace
}  // namespace mvw
