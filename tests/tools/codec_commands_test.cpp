#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tests/support/encoded_models.h"
#include "tests/support/program.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

using testing::HasSubstr;

struct SmallFile {
    ScratchFolder folder;
    std::string path = folder / "ball.mvw";
    SmallFile() { EXPECT_TRUE(write_file(path, small_file().file).ok()); }
};

TEST(EncodeCommand, ReportsItsFiguresAndWritesAFileThatVerifies) {
    const ScratchFolder folder;
    ASSERT_TRUE(write_mesh(folder / "in.ply", plain(bumpy_ball(4))).ok());
    const ProgramRun run = run_mvw({"encode", folder / "in.ply", folder / "out.mvw", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(run.errors, "") << "quiet where standard error is no terminal";
    const auto json = nlohmann::json::parse(run.out);
    for (const char* key :
         {"input_vertices", "input_faces", "parts", "draco_area_share", "base_faces", "levels", "vertices", "bytes",
          "base_bytes", "rms", "max", "psnr", "tangential_share", "seconds", "peak_mb", "transform"})
        EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json["input_vertices"], 1026);
    EXPECT_EQ(json["transform"], "seeded-normal");
    EXPECT_EQ(run_mvw({"verify", folder / "out.mvw"}).exit_code, 0);
}

TEST(EncodeCommand, RefusesInOneLineWhatItCannotEncode) {
    const ScratchFolder folder;
    write_text(folder / "flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n");
    for (const std::string& bad : {folder / "none.off", folder / "flat.off"}) {
        const ProgramRun run = run_mvw({"encode", bad, folder / "out.mvw"});
        EXPECT_EQ(run.exit_code, 1);
        EXPECT_THAT(run.errors, HasSubstr(bad));
        EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
    }
    EXPECT_EQ(run_mvw({"encode", folder / "flat.off", folder / "out.mvw", "--transform", "magic"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"encode", "--help"}).exit_code, 0);
}

TEST(DecodeCommand, StopsWhereItIsToldTo) {
    const SmallFile file;
    const auto decoded = [&](std::vector<std::string> options) {
        options.insert(options.begin(), {"decode", file.path, file.folder / "out.ply", "--json"});
        const ProgramRun run = run_mvw(options);
        EXPECT_EQ(run.exit_code, 0) << run.errors;
        EXPECT_EQ(run.errors, "");
        return nlohmann::json::parse(run.out);
    };
    EXPECT_EQ(decoded({})["vertices"], 258);
    EXPECT_EQ(decoded({"--level", "1"})["vertices"], 18);
    EXPECT_EQ(decoded({"--level", "1"})["level"], 1);
    EXPECT_LE(decoded({"--max-bytes", "300"})["bytes_used"], 300);
    EXPECT_LT(decoded({"--target-error", "0.01"})["bytes_used"], decoded({})["bytes_used"]);
}

TEST(DecodeCommand, ACutFileGivesItsBestMeshAndSaysSo) {
    const SmallFile file;
    const Bytes& bytes = small_file().file;
    ASSERT_TRUE(write_file(file.path, ByteSpan(bytes).first(bytes.size() / 2)).ok());
    const ProgramRun run = run_mvw({"decode", file.path, file.folder / "out.ply"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_THAT(run.errors, HasSubstr("cut at byte " + std::to_string(bytes.size() / 2)));
    ASSERT_TRUE(write_file(file.path, ByteSpan(bytes).first(60)).ok());
    const ProgramRun nothing = run_mvw({"decode", file.path, file.folder / "out.ply"});
    EXPECT_EQ(nothing.exit_code, 1);
    EXPECT_THAT(nothing.errors, HasSubstr(file.path));
}

TEST(DecodeCommand, TilesAndTheOriginalComeWhereAskedFor) {
    const ScratchFolder folder;
    EncodeOptions options;
    options.target_error = 1e-3;
    options.tile_count = 4;
    options.keep_original = 12;
    options.profile = Profile::Fast;
    ASSERT_TRUE(write_file(folder / "b.mvw", encode_parts({bumpy_ball(4)}, options).file).ok());
    const auto bytes_used = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"decode", folder / "b.mvw", folder / "out.ply", "--json"});
        const ProgramRun run = run_mvw(arguments);
        EXPECT_EQ(run.exit_code, 0) << run.errors;
        return nlohmann::json::parse(run.out)["bytes_used"].get<int>();
    };
    EXPECT_LT(bytes_used({"--tiles", "1"}), bytes_used({"--tiles", "0-3"}));
    EXPECT_EQ(bytes_used({"--tiles", "0,1-2,3"}), bytes_used({}));
    EXPECT_EQ(run_mvw({"decode", folder / "b.mvw", folder / "out.ply", "--tiles", "1,x"}).exit_code, 2);
    (void)bytes_used({"--original"});
    CleanReport report;
    EXPECT_EQ(read_mesh(folder / "out.ply", report)->faces.size(), plain(bumpy_ball(4)).faces.size());
    const SmallFile without;
    EXPECT_EQ(run_mvw({"decode", without.path, folder / "out.ply", "--original"}).exit_code, 1);
}

TEST(InfoCommand, ACutFileIsToldFromItsChunks) {
    const SmallFile file;
    const Bytes& bytes = small_file().file;
    ASSERT_TRUE(write_file(file.path, ByteSpan(bytes).first(bytes.size() / 2)).ok());
    const ProgramRun run = run_mvw({"info", file.path, "--chunks", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, HasSubstr("cut at byte"));
    EXPECT_GT(nlohmann::json::parse(run.out)["chunks"].size(), 2u);
}

TEST(VerifyCommand, BytesBehindTheEndAreAFault) {
    const SmallFile file;
    Bytes longer = small_file().file;
    longer.push_back(std::byte{0});
    ASSERT_TRUE(write_file(file.path, longer).ok());
    EXPECT_THAT(run_mvw({"verify", file.path}).errors, HasSubstr("1 bytes behind its end"));
    EXPECT_EQ(run_mvw({"decode", file.path, file.folder / "out.ply"}).exit_code, 0);
}

TEST(DecodeCommand, RefusesOtherFilesAndUnknownEndings) {
    const SmallFile file;
    write_text(file.folder / "text.mvw", "solid cube\n");
    EXPECT_EQ(run_mvw({"decode", file.folder / "text.mvw", file.folder / "out.ply"}).exit_code, 1);
    EXPECT_EQ(run_mvw({"decode", file.path, file.folder / "out.txt"}).exit_code, 2);
}

TEST(InfoCommand, ListsPointsOfFallingErrorUpToTheWholeFile) {
    const SmallFile file;
    const ProgramRun run = run_mvw({"info", file.path, "--chunks", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto json = nlohmann::json::parse(run.out);
    EXPECT_EQ(json["bytes"], small_file().file.size());
    EXPECT_EQ(json["levels"], 3);
    ASSERT_GE(json["points"].size(), 3u);
    for (std::size_t i = 1; i < json["points"].size(); ++i) {
        EXPECT_LT(json["points"][i - 1]["bytes"], json["points"][i]["bytes"]);
        EXPECT_GE(json["points"][i - 1]["error"], json["points"][i]["error"]);
    }
    EXPECT_EQ(json["chunks"].size(), toc_of(small_file().file).chunks.size());
    EXPECT_EQ(run_mvw({"info", file.path}).exit_code, 0);
}

TEST(VerifyCommand, NamesTheDamagedChunk) {
    const SmallFile file;
    EXPECT_EQ(run_mvw({"verify", file.path}).exit_code, 0);
    const ChunkEntry chunk = toc_of(small_file().file).chunks[2];
    Bytes damaged = small_file().file;
    damaged[chunk.offset] ^= std::byte{4};
    ASSERT_TRUE(write_file(file.path, damaged).ok());
    const ProgramRun run = run_mvw({"verify", file.path});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, HasSubstr("chunk at byte " + std::to_string(chunk.offset)));
}

TEST(VerifyCommand, NoticesEveryFlippedByte) {
    const SmallFile file;
    for (std::size_t at = 0; at < small_file().file.size(); at += 23) {
        Bytes damaged = small_file().file;
        damaged[at] ^= std::byte{0x20};
        ASSERT_TRUE(write_file(file.path, damaged).ok());
        EXPECT_EQ(run_mvw({"verify", file.path}).exit_code, 1) << "byte " << at;
    }
}

}  // namespace
}  // namespace mvw
