#include "server/store.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/stream_models.h"

namespace mvw::server {
namespace {

using test::make_stream_file;

class StoreTest : public testing::Test {
 protected:
    void SetUp() override { store_ = Store::open_folder(folder_.path(), 2).value(); }
    Errc open_code(const std::string& name) {
        const Result<ModelPtr> r = store_->open(name);
        return r.ok() ? Errc::NeedMoreData : r.error().code;
    }
    static Bytes content(const ModelPtr& model) {
        Bytes bytes(model->file_bytes());
        EXPECT_TRUE(model->read(0, bytes).ok());
        return bytes;
    }

    test::TemporaryFolder folder_;
    std::unique_ptr<Store> store_;
};

TEST_F(StoreTest, FindsModelsByNameWithAndWithoutEndingAndInFolders) {
    const Bytes file = make_stream_file();
    folder_.put("a.mvw", file);
    folder_.put("scans/old/b.mvw", file);
    EXPECT_EQ(content(store_->open("a").value()), file);
    EXPECT_EQ(content(store_->open("a.mvw").value()), file);
    EXPECT_EQ(content(store_->open("scans/old/b").value()), file);
    const auto list = store_->list();
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0].name, "a");
    EXPECT_EQ(list[1].name, "scans/old/b");
    EXPECT_EQ(list[1].stamp.bytes, file.size());
}

TEST_F(StoreTest, MissingFolderIsAnError) {
    EXPECT_FALSE(Store::open_folder(folder_.path("none"), 2).ok());
}

TEST_F(StoreTest, NothingOutsideTheFolderCanBeReached) {
    const Bytes file = make_stream_file();
    folder_.put("outside.mvw", file);
    folder_.put("served/a.mvw", file);
    folder_.put("served/sub/b.mvw", file);
    std::filesystem::create_symlink("../outside.mvw", folder_.path("served/link.mvw"));
    std::filesystem::create_directory_symlink("..", folder_.path("served/up"));
    std::filesystem::create_directory(folder_.path("served/dir.mvw"));
    store_ = Store::open_folder(folder_.path("served"), 2).value();
    EXPECT_TRUE(store_->open("a").ok());
    for (const std::string name : {"../outside", "..", ".", "", "/", "/a", "a/", "sub//b", "sub/../a", "./a",
                                   "sub/../../outside", "link", "up/outside", "up/served/a", "dir", "a\\b", "sub"})
        EXPECT_EQ(open_code(name), Errc::Io) << name;
    EXPECT_EQ(open_code(folder_.path("outside")), Errc::Io);
    EXPECT_EQ(open_code(std::string("a\0b", 3)), Errc::Io);
    EXPECT_EQ(store_->list().size(), 2u);
}

TEST_F(StoreTest, AddedReplacedAndRemovedFilesAreNoticed) {
    EXPECT_EQ(open_code("a"), Errc::Io);
    const Bytes first = make_stream_file(), second = make_stream_file({.seed = 2});
    folder_.put("a.mvw", first);
    const ModelPtr old = store_->open("a").value();
    EXPECT_EQ(store_->open("a").value(), old) << "an unchanged file is not read again";
    folder_.put("a.mvw", second);
    EXPECT_EQ(content(store_->open("a").value()), second);
    EXPECT_TRUE(old->intact());
    EXPECT_EQ(content(old), first) << "whoever is in the middle of the old file gets the old bytes";
    std::filesystem::remove(folder_.path("a.mvw"));
    EXPECT_EQ(open_code("a"), Errc::Io);
}

TEST_F(StoreTest, OverwritingInPlaceIsNoticedByThoseWhoReadIt) {
    folder_.put("a.mvw", make_stream_file());
    const ModelPtr old = store_->open("a").value();
    EXPECT_TRUE(old->intact());
    folder_.overwrite("a.mvw", make_stream_file({.payload_bytes = 250, .seed = 2}));
    EXPECT_FALSE(old->intact());
    EXPECT_NE(store_->open("a").value(), old);
}

TEST_F(StoreTest, ShrunkFileIsAReadErrorAndNoCrash) {
    const Bytes file = make_stream_file();
    folder_.put("a.mvw", file);
    const ModelPtr model = store_->open("a").value();
    std::filesystem::resize_file(folder_.path("a.mvw"), 100);
    Bytes bytes(file.size());
    EXPECT_EQ(model->read(0, bytes).error().code, Errc::Io);
}

TEST_F(StoreTest, UnsoundFilesAreRefusedAtEveryTruncation) {
    const Bytes file = make_stream_file({.tiles = 1, .levels = 1, .layers = 1, .payload_bytes = 30});
    for (std::size_t n = 0; n < file.size(); ++n) {
        folder_.put("a.mvw", ByteSpan(file).first(n));
        EXPECT_NE(open_code("a"), Errc::NeedMoreData) << n;
        EXPECT_NE(open_code("a"), Errc::Io) << n;
    }
    folder_.put("a.mvw", file);
    EXPECT_TRUE(store_->open("a").ok());
}

TEST_F(StoreTest, KeepsAtMostTheGivenNumberReady) {
    for (const char* name : {"a", "b", "c"}) folder_.put(std::string(name) + ".mvw", make_stream_file());
    const std::weak_ptr<const ModelSource> a = store_->open("a").value();
    EXPECT_TRUE(store_->open("b").ok());
    EXPECT_FALSE(a.expired());
    EXPECT_TRUE(store_->open("c").ok());
    EXPECT_TRUE(a.expired());
}

}  // namespace
}  // namespace mvw::server
