// mvw serve and mvw fetch as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "codec/bytes.h"
#include "codec/encoder.h"
#include "codec/mesh/io/files.h"
#include "server/server.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"
#include "tests/support/stream_models.h"

namespace mvw {
namespace {

class FetchTest : public testing::Test {
 protected:
    void SetUp() override {
        EncodeOptions options;
        options.threads = 1;
        options.choose_transform = false;  // a given one makes a file of levels
        file_ = encode(torus(46, 22), options).value().file;
        served_.put("torus.mvw", file_);
        server::ServerOptions server;
        server.folder = served_.path();
        server.tcp.port = server.http.port = 0;
        server_ = server::Server::start(server).value();
        url_ = "mvw://" + to_string(server_->tcp_address()) + "/torus";
    }
    ProgramRun fetch(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "fetch");
        return run_mvw(arguments);
    }

    ScratchFolder scratch_;
    test::TemporaryFolder served_;
    Bytes file_;
    std::unique_ptr<server::Server> server_;
    std::string url_;
};

TEST_F(FetchTest, WritesTheSameMeshAsDecodingTheFile) {
    const ProgramRun run = fetch({url_, scratch_ / "torus.ply"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(run.out + run.errors, "") << "not quiet although this is no terminal";
    ASSERT_EQ(run_mvw({"decode", served_.path("torus.mvw"), scratch_ / "decoded.ply"}).exit_code, 0);
    EXPECT_EQ(read_text(scratch_ / "torus.ply"), read_text(scratch_ / "decoded.ply"));
    EXPECT_FALSE(read_text(scratch_ / "torus.ply").empty());
}

TEST_F(FetchTest, ContainerIsTheServedFileByteForByteWhenAllIsFetched) {
    ASSERT_EQ(fetch({url_ + ".mvw", scratch_ / "torus.mvw"}).exit_code, 0);
    EXPECT_EQ(read_file(scratch_ / "torus.mvw").value(), file_);
}

TEST_F(FetchTest, JsonHasTheFieldsOfTheContractAndNothingElse) {
    const ProgramRun run = fetch({url_, scratch_ / "torus.obj", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto json = nlohmann::ordered_json::parse(run.out);
    std::vector<std::string> names;
    for (const auto& [name, value] : json.items()) names.push_back(name);
    EXPECT_EQ(names, (std::vector<std::string>{"bytes", "level", "vertices", "error", "seconds", "first_mesh_seconds",
                                               "resumed"}));
    EXPECT_GT(json["vertices"], 100);
    EXPECT_LE(json["first_mesh_seconds"], json["seconds"]);
    EXPECT_EQ(json["resumed"], 0);
}

TEST_F(FetchTest, LevelBudgetAndTargetErrorAreHonoured) {
    const auto fetched = [&](const std::vector<std::string>& options) {
        std::vector<std::string> arguments{url_, scratch_ / "part.ply", "--json"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const ProgramRun run = fetch(arguments);
        EXPECT_EQ(run.exit_code, 0) << run.errors;
        return nlohmann::json::parse(run.out);
    };
    const auto whole = fetched({});
    const auto level = fetched({"--level", "1"});
    EXPECT_EQ(level["level"], 1);
    EXPECT_LT(level["bytes"], whole["bytes"]);
    EXPECT_LT(level["vertices"], whole["vertices"]);
    const auto budget = fetched({"--max-bytes", std::to_string(file_.size() / 2)});
    EXPECT_LE(budget["bytes"], file_.size() / 2);
    EXPECT_GT(budget["bytes"], file_.size() / 4);
    const double target = 4 * whole["error"].get<double>();
    const auto error = fetched({"--target-error", std::to_string(target)});
    EXPECT_LE(error["error"], target * 1.001);
    EXPECT_LT(error["bytes"], whole["bytes"]);
}

TEST_F(FetchTest, SnapshotsAreMeshesWithARowEach) {
    const ProgramRun run = fetch({url_, scratch_ / "torus.off", "--snapshots", scratch_ / "steps"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto rows = static_cast<std::size_t>(std::count(run.out.begin(), run.out.end(), '\n'));
    ASSERT_GT(rows, 3u);  // and the heading
    for (std::size_t i = 0; i + 1 < rows; ++i) {
        const std::string name = scratch_ / ("steps/00" + std::to_string(i) + ".off");
        EXPECT_NE(run.out.find(name), std::string::npos);
        EXPECT_FALSE(read_text(name).empty()) << name;
    }
    const std::string last = scratch_ / ("steps/00" + std::to_string(rows - 2) + ".off");
    EXPECT_EQ(read_text(last), read_text(scratch_ / "torus.off"));
}

TEST_F(FetchTest, FailuresAreOneLineThatNamesTheUrlAndTheReason) {
    const std::string nothing = url_ + "_that_is_not_there";
    const ProgramRun missing = fetch({nothing, scratch_ / "a.ply"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_EQ(missing.errors, "mvw: " + nothing + ": the server says: no such model\n");

    const ProgramRun small = fetch({url_, scratch_ / "a.ply", "--max-bytes", "10"});
    EXPECT_EQ(small.exit_code, 1);
    EXPECT_NE(small.errors.find(url_), std::string::npos);

    for (const std::string bad : {"bunny", "ftp://h/m", "mvw://h", "mvw://h:x/m"})
        EXPECT_EQ(fetch({bad, scratch_ / "a.ply"}).exit_code, 2) << bad;
    EXPECT_EQ(fetch({url_, scratch_ / "a.txt"}).exit_code, 2);
    EXPECT_TRUE(read_text(scratch_ / "a.ply").empty());

    server_.reset();
    const ProgramRun gone = fetch({url_, scratch_ / "a.ply"});
    EXPECT_EQ(gone.exit_code, 1);
    EXPECT_NE(gone.errors.find("given up"), std::string::npos);
}

TEST(Serve, WrongUsageAndMissingFoldersHaveTheirExitCodes) {
    EXPECT_EQ(run_mvw({"serve"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"serve", "/", "--tcp", "::1"}).exit_code, 2);
    const ProgramRun missing = run_mvw({"serve", "/no/such/folder", "--tcp", "127.0.0.1:0"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_NE(missing.errors.find("/no/such/folder"), std::string::npos);
}

}  // namespace
}  // namespace mvw
