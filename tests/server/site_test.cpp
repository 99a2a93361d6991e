#include "server/site.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "server/token.h"
#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw::server {
namespace {

using test::make_stream_file;

std::string field(const HttpReply& reply, const std::string& name) {
    for (const auto& [n, v] : reply.fields)
        if (n == name) return v;
    return {};
}

std::string body(const HttpReply& reply) {
    if (!reply.source) return reply.text;
    Bytes bytes(reply.length);
    EXPECT_TRUE(reply.source->read(reply.offset, bytes).ok());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string as_text(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class SiteTest : public testing::Test {
 protected:
    void SetUp() override {
        folder_.put("a.mvw", file_);
        folder_.put("sub dir/b.mvw", make_stream_file({.seed = 2}));
        store_ = Store::open_folder(folder_.path(), 16).value();
        catalogue_ = std::make_unique<Catalogue>(*store_);
        write_text(page_ / "index.html", "<html>");
        write_text(page_ / "mvw.wasm", "wasm");
        build();
    }
    void build(const CheckToken& allow = {}) {
        site_ = std::make_unique<Site>([this](std::string_view n) { return store_->open(n); }, allow, *catalogue_,
                                       metrics_, page_ / "");
    }
    [[nodiscard]] HttpReply get(const std::string& target, HttpRequest request = {}) const {
        request.target = target;
        if (request.method.empty()) request.method = "GET";
        return site_->answer(request);
    }

    const Bytes file_ = make_stream_file();
    test::TemporaryFolder folder_;
    ScratchFolder page_;
    std::unique_ptr<Store> store_;
    std::unique_ptr<Catalogue> catalogue_;
    Metrics metrics_;
    std::unique_ptr<Site> site_;
};

TEST_F(SiteTest, ModelComesWholeWithItsContentIdAsTag) {
    const HttpReply reply = get("/models/a.mvw");
    EXPECT_EQ(reply.status, 200u);
    EXPECT_EQ(body(reply), as_text(file_));
    EXPECT_EQ(field(reply, "ETag"), "\"" + to_hex(read_header(file_).value().content_id) + "\"");
    EXPECT_EQ(field(reply, "Accept-Ranges"), "bytes");
    EXPECT_EQ(field(reply, "Access-Control-Allow-Origin"), "*");
    EXPECT_EQ(field(reply, "Cache-Control"), "public, no-cache");
    EXPECT_NE(reply.head(true).find("Content-Length: " + std::to_string(file_.size()) + "\r\n"), std::string::npos);
}

TEST_F(SiteTest, RangesGiveThoseBytesAndNoOthers) {
    const std::string all = as_text(file_), size = std::to_string(all.size());
    const HttpReply middle = get("/models/a.mvw", {.range = "bytes=5-9"});
    EXPECT_EQ(middle.status, 206u);
    EXPECT_EQ(body(middle), all.substr(5, 5));
    EXPECT_EQ(field(middle, "Content-Range"), "bytes 5-9/" + size);
    EXPECT_EQ(body(get("/models/a.mvw", {.range = "bytes=100-"})), all.substr(100));
    EXPECT_EQ(body(get("/models/a.mvw", {.range = "bytes=-7"})), all.substr(all.size() - 7));
    EXPECT_EQ(body(get("/models/a.mvw", {.range = "bytes=10-99999999999"})), all.substr(10));
    const HttpReply beyond = get("/models/a.mvw", {.range = "bytes=" + size + "-"});
    EXPECT_EQ(beyond.status, 416u);
    EXPECT_EQ(field(beyond, "Content-Range"), "bytes */" + size);
    for (const char* ignored : {"bytes=9-5", "bytes=a-b", "lines=1-2", "bytes=0-1,4-5", "bytes=", "bytes=-",
                                "bytes=99999999999999999999999-"})
        EXPECT_EQ(get("/models/a.mvw", {.range = ignored}).status, 200u) << ignored;
}

TEST_F(SiteTest, ConditionsAreKept) {
    const std::string tag = field(get("/models/a.mvw"), "ETag");
    const HttpReply same = get("/models/a.mvw", {.if_none_match = "\"x\", W/" + tag});
    EXPECT_EQ(same.status, 304u);
    EXPECT_TRUE(same.without_body);
    EXPECT_EQ(same.head(true).find("Content-Length"), std::string::npos);
    EXPECT_EQ(get("/models/a.mvw", {.if_none_match = "\"x\""}).status, 200u);
    EXPECT_EQ(get("/models/a.mvw", {.range = "bytes=0-3", .if_range = tag}).status, 206u);
    EXPECT_EQ(get("/models/a.mvw", {.range = "bytes=0-3", .if_range = "\"old\""}).status, 200u);
}

TEST_F(SiteTest, NameWithAVersionIsImmutableAndNeverAnotherModel) {
    const std::string version = to_hex(read_header(file_).value().content_id);
    EXPECT_EQ(field(get("/models/a.mvw?v=" + version), "Cache-Control"), "public, max-age=31536000, immutable");
    folder_.put("a.mvw", make_stream_file({.seed = 3}));
    EXPECT_EQ(get("/models/a.mvw?v=" + version).status, 404u);
    EXPECT_EQ(field(get("/models/a.mvw?v=" + version), "Cache-Control"), "no-store");
    EXPECT_NE(field(get("/models/a.mvw"), "ETag"), "\"" + version + "\"");
}

TEST_F(SiteTest, ListNamesEverySoundModelAsItIsNow) {
    folder_.put("broken.mvw", Bytes(100));
    const auto list = [&] { return nlohmann::json::parse(get("/models").text)["models"]; };
    ASSERT_EQ(list().size(), 2u);
    EXPECT_EQ(list()[0]["name"], "a");
    EXPECT_EQ(list()[0]["bytes"], file_.size());
    EXPECT_EQ(get(list()[1]["url"]).status, 200u) << list()[1]["url"];
    const std::string before = list()[0]["version"];
    folder_.put("a.mvw", make_stream_file({.seed = 3}));
    folder_.put("c.mvw", file_);
    ASSERT_EQ(list().size(), 3u);
    EXPECT_NE(list()[0]["version"], before);
    std::filesystem::remove(folder_.path("c.mvw"));
    EXPECT_EQ(list().size(), 2u);
}

TEST_F(SiteTest, NothingOutsideItsFoldersIsReached) {
    folder_.put("outside/secret.mvw", file_);
    std::filesystem::create_symlink("/etc/passwd", folder_.path("link.mvw"));
    std::filesystem::create_symlink("/etc", folder_.path("etc"));
    std::filesystem::create_symlink("/etc/passwd", page_ / "passwd");
    std::filesystem::create_symlink("/etc", page_ / "etc");
    for (const char* target :
         {"/models/../a.mvw", "/models/%2e%2e/a.mvw", "/models/..%2fa.mvw", "/models/link.mvw",
          "/models/etc/passwd.mvw", "/models//a.mvw", "/models/a%00.mvw", "/models/a", "/passwd", "/etc/passwd",
          "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/.hidden", "/..", "/etc/", "/models/.mvw"})
        EXPECT_EQ(get(target).status, 404u) << target;
    for (const char* target : {"models", "", "*", "http://h/models/a.mvw", "/%", "/%2", "/%zz"})
        EXPECT_EQ(get(target).status, 400u) << target;
}

TEST_F(SiteTest, PackedCopiesOfThePageGoToThoseWhoAcceptThem) {
    write_text(page_ / "mvw.wasm.br", "b");
    write_text(page_ / "mvw.wasm.gz", "gz");
    const auto accepting = [&](const std::string& codings) { return get("/mvw.wasm", {.accept_encoding = codings}); };
    const HttpReply br = accepting("gzip, deflate, br"), gz = accepting("deflate,gzip;q=0.5"), plain = accepting("");
    EXPECT_EQ(body(br), "b");
    EXPECT_EQ(field(br, "Content-Encoding"), "br");
    EXPECT_EQ(body(gz), "gz");
    EXPECT_EQ(field(gz, "Content-Encoding"), "gzip");
    EXPECT_EQ(body(plain), "wasm");
    EXPECT_EQ(field(plain, "Content-Encoding"), "");
    for (const HttpReply* reply : {&br, &gz, &plain}) {
        EXPECT_EQ(field(*reply, "Content-Type"), "application/wasm");
        EXPECT_EQ(field(*reply, "Vary"), "Accept-Encoding");
    }
    EXPECT_NE(field(br, "ETag"), field(plain, "ETag"));
    EXPECT_EQ(body(accepting("br;q=0, gzip")), "gz");
    EXPECT_EQ(body(accepting("brotli, xgzip")), "wasm");
    EXPECT_EQ(field(get("/models/a.mvw", {.accept_encoding = "br, gzip"}), "Content-Encoding"), "");
}

TEST_F(SiteTest, PackedCopyOfAFileThatHasChangedIsNotSent) {
    write_text(page_ / "index.html.gz", "old");
    const auto before = std::filesystem::last_write_time(page_ / "index.html") - std::chrono::seconds(1);
    std::filesystem::last_write_time(page_ / "index.html.gz", before);
    EXPECT_EQ(body(get("/", {.accept_encoding = "gzip"})), "<html>");
}

TEST_F(SiteTest, PageComesWithItsTypesAndAStrictPolicy) {
    const HttpReply page = get("/");
    EXPECT_EQ(body(page), "<html>");
    EXPECT_EQ(field(page, "Content-Type"), "text/html; charset=utf-8");
    const std::string policy = field(page, "Content-Security-Policy");
    EXPECT_NE(policy.find("default-src 'none'; script-src 'self' 'wasm-unsafe-eval';"), std::string::npos);
    EXPECT_EQ(policy.find("unsafe-inline"), std::string::npos);
    EXPECT_EQ(field(page, "X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(field(get("/mvw.wasm"), "Content-Type"), "application/wasm");
    EXPECT_EQ(get("/none.js").status, 404u);
}

TEST_F(SiteTest, HeadHasTheFieldsAndNoBody) {
    const HttpReply reply = get("/models/a.mvw", {.method = "HEAD"});
    EXPECT_TRUE(reply.without_body);
    EXPECT_NE(reply.head(true).find("Content-Length: " + std::to_string(file_.size())), std::string::npos);
    EXPECT_EQ(get("/models/a.mvw", {.method = "POST"}).status, 405u);
    const HttpReply preflight = get("/models/a.mvw", {.method = "OPTIONS"});
    EXPECT_EQ(preflight.status, 204u);
    EXPECT_NE(field(preflight, "Access-Control-Allow-Headers").find("Range"), std::string::npos);
}

TEST_F(SiteTest, TokensOpenWhatTheirPatternNames) {
    const std::string key = "a key of at least 16 bytes";
    build([keys = TokenKeys({key})](std::string_view token, std::string_view name) {
        return keys.check(token, name, 5);
    });
    const std::string token = make_token(key, "sub*", 10).value(), late = make_token(key, "sub*", 5).value();
    EXPECT_EQ(get("/models/a.mvw").status, 401u);
    EXPECT_EQ(get("/models/sub%20dir/b.mvw", {.authorization = "Bearer " + token}).status, 200u);
    EXPECT_EQ(get("/models/sub%20dir/b.mvw?token=" + token).status, 200u);
    EXPECT_EQ(get("/models/sub%20dir/b.mvw?token=" + late).status, 403u);
    EXPECT_EQ(get("/models/a.mvw?token=" + token).status, 403u);
    EXPECT_EQ(get("/models/none.mvw?token=" + token).status, 403u) << "whether it exists is nobody's business";
    EXPECT_EQ(nlohmann::json::parse(get("/models").text)["models"].size(), 0u);
    EXPECT_EQ(nlohmann::json::parse(get("/models?token=" + token).text)["models"].size(), 1u);
    EXPECT_EQ(field(get("/models/sub%20dir/b.mvw?token=" + token), "Cache-Control"), "private, no-cache");
}

TEST_F(SiteTest, HealthAndMetricsTellTheState) {
    EXPECT_EQ(get("/healthz").status, 200u);
    metrics_.opened[0] = 3;
    metrics_.closed[0] = 1;
    metrics_.http_answers[404] = 7;
    const std::string text = get("/metrics").text;
    EXPECT_NE(text.find("mvw_connections{transport=\"tcp\"} 2\n"), std::string::npos) << text;
    EXPECT_NE(text.find("mvw_http_answers_total{status=\"404\"} 7\n"), std::string::npos);
    EXPECT_NE(text.find("mvw_models 2\n"), std::string::npos);
    site_->drain();
    EXPECT_EQ(get("/healthz").status, 503u);
}

}  // namespace
}  // namespace mvw::server
