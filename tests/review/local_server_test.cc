// Who is answered, and who is not.
#include "lake/review/local_server.h"

#include <gmock/gmock.h>
#include <httplib.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include "lake/core/error.h"

namespace lake::review {
namespace {

using testing::HasSubstr;

// A server at work, asked by a client that may say anything.
class Server : public testing::Test {
 protected:
  Server() : server_(0) {
    server_.Get("", [](const LocalRequest&) { return LocalReply{"text/html", "page"}; });
    server_.Get("frame/", [](const LocalRequest& request) { return LocalReply{"text/plain", request.rest}; });
    server_.Post("edit", [](const LocalRequest& request) -> LocalReply {
      if (request.body == "{}") throw Error("that changes nothing");
      return {"application/json", request.body};
    });
    server_.Get("report", [](const LocalRequest&) {
      return LocalReply{.type = "text/html", .body = "<h1>report</h1>", .is_framed = true};
    });
    server_.GetHeld("window", [this] {
      ++held_;
      return std::shared_ptr<void>(this, [](Server* server) { --server->held_; });
    });
    server_.Get("broken", [](const LocalRequest&) -> LocalReply { throw std::length_error("too long"); });
    const std::string address = server_.Address();
    const std::size_t host = address.find("//") + 2, path = address.find('/', host);
    host_ = address.substr(host, path - host);
    path_ = address.substr(path);
    thread_ = std::thread([this] { server_.Serve([this] { return done_.load(); }); });
  }
  ~Server() override {
    done_ = true;
    thread_.join();
  }

  httplib::Headers Headers(const std::string& host) const { return {{"Host", host}}; }
  int Status(const std::string& path, const httplib::Headers& headers = {}) {
    const auto result = Client().Get(path, headers);
    return result ? result->status : 0;
  }
  httplib::Client Client() const { return httplib::Client("http://" + host_); }

  std::atomic<int> held_ = 0;
  LocalServer server_;
  std::string host_, path_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

TEST_F(Server, AnswersToItsOwnAddressOnly) {
  EXPECT_EQ(Client().Get(path_)->body, "page");
  EXPECT_EQ(Status("/"), 403);
  std::string wrong = path_;
  wrong[3] = wrong[3] == '0' ? '1' : '0';
  EXPECT_EQ(Status(wrong), 403);
  EXPECT_EQ(Status(path_.substr(0, path_.size() - 1)), 403);
  EXPECT_EQ(Status(path_, {{"Host", "evil.example"}}), 403) << "a name that is rebound to 127.0.0.1";
  EXPECT_EQ(Status(path_, {{"Host", host_ + ".evil.example"}}), 403);
  EXPECT_EQ(Status(path_, {{"Host", "127.0.0.1"}}), 403) << "of another port";
  EXPECT_EQ(Status(path_, {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(Status(path_, {{"Origin", "null"}}), 403);
  EXPECT_EQ(Status(path_, {{"Origin", "http://" + host_}}), 200);
}

TEST_F(Server, ServesNoFiles) {
  for (const char* path : {"frame/../../../../etc/passwd", "../etc/passwd", "%2e%2e/%2e%2e/etc/passwd",
                           "..%2f..%2fetc/passwd", "frame/%00", "/etc/passwd"}) {
    const auto result = Client().Get(path_ + path);
    ASSERT_TRUE(result) << path;
    EXPECT_THAT(result->body, testing::Not(HasSubstr("root:"))) << path;
  }
  EXPECT_EQ(Status(path_ + "nothing"), 404);
  EXPECT_EQ(Client().Get(path_ + "frame/12.jpg")->body, "12.jpg");
}

// The library would compress a trial's tables for a second and more, which are read on the same machine.
TEST_F(Server, SendsWhatABrowserAsksForAsItIs) {
  const std::string text = "{\"text\":\"" + std::string(100'000, 'a') + "\"}";
  const httplib::Headers as_a_browser = {{"Accept-Encoding", "gzip, deflate, br"}};
  httplib::Client client = Client();
  client.set_decompress(false);
  const auto result = client.Post(path_ + "edit", as_a_browser, text, "application/json");
  EXPECT_EQ(result->body, text);
  EXPECT_FALSE(result->has_header("Content-Encoding"));
  EXPECT_EQ(client.Post(path_ + "edit", "", "application/json")->body, "");
}

TEST_F(Server, TakesJsonFromItsOwnPageOnly) {
  EXPECT_EQ(Client().Post(path_ + "edit", R"({"op":"undo"})", "application/json")->status, 200);
  EXPECT_EQ(Client().Post(path_ + "edit", "op=undo", "application/x-www-form-urlencoded")->status, 415);
  EXPECT_EQ(Client().Post(path_ + "edit", "{\"op\":1}", "text/plain")->status, 415);
  const auto foreign =
      Client().Post(path_ + "edit", {{"Origin", "http://evil.example"}}, R"({"a":1})", "application/json");
  EXPECT_EQ(foreign->status, 403);
  EXPECT_EQ(Client().Get(path_ + "edit")->status, 404);
  EXPECT_EQ(Client().Put(path_ + "edit", "{}", "application/json")->status, 405);
  EXPECT_EQ(Client().Delete(path_)->status, 405);
  EXPECT_EQ(Client().Options(path_)->status, 405);
  EXPECT_EQ(Client().Post(path_ + "edit", std::string(2 << 20, 'x'), "application/json")->status, 413);
}

TEST_F(Server, SaysWhyNot) {
  const auto result = Client().Post(path_ + "edit", "{}", "application/json");
  EXPECT_EQ(result->status, 400);
  EXPECT_EQ(result->body, R"({"error":"that changes nothing"})");
  const auto broken = Client().Get(path_ + "broken");
  EXPECT_EQ(broken->status, 500);
  EXPECT_EQ(broken->body,
            "{\"error\":\"a library failed at this input (too long): is the input damaged, or of an unusual size? If "
            "it is neither, please "
            "report this together with the input\"}")
      << "a library's exception is told to the page too";
}

TEST_F(Server, LetsNothingInFromElsewhere) {
  const auto result = Client().Get(path_);
  EXPECT_THAT(result->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'none'"));
  EXPECT_EQ(result->get_header_value("Referrer-Policy"), "no-referrer");
  EXPECT_EQ(result->get_header_value("X-Content-Type-Options"), "nosniff");
}

TEST_F(Server, AFramedDocumentMayAskForNothing) {
  const auto result = Client().Get(path_ + "report");
  ASSERT_EQ(result->get_header_value_count("Content-Security-Policy"), 1u) << "two of them are both in force";
  const std::string policy = result->get_header_value("Content-Security-Policy");
  EXPECT_THAT(policy, testing::StartsWith("sandbox allow-scripts; default-src 'none'"));
  EXPECT_THAT(policy, testing::Not(HasSubstr("connect-src")));
  EXPECT_THAT(policy, testing::Not(HasSubstr("allow-same-origin")));
  EXPECT_EQ(Client().Get(path_)->get_header_value_count("Content-Security-Policy"), 1u);
}

// How the program knows that a window is open: it is as long as its connection, however it is closed.
TEST_F(Server, HoldsWhatAConnectionHolds) {
  EXPECT_EQ(held_, 0);
  std::atomic<bool> is_closed = false, is_over = false;
  std::thread window([&] {
    Client().Get(path_ + "window", [&](const char*, std::size_t) { return !is_closed; });
    is_over = true;
  });
  while (held_ == 0 && !is_over) std::this_thread::yield();
  EXPECT_EQ(Status(path_), 200) << "others are answered meanwhile";
  EXPECT_EQ(held_, 1);
  is_closed = true;
  window.join();
  while (held_ != 0) std::this_thread::yield();
}

TEST_F(Server, RefusesAPortInUse) {
  const int port = std::stoi(host_.substr(host_.find(':') + 1));
  try {
    const LocalServer second(port);
    FAIL() << "the port was shared";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(host_ + ": the port is in use"));
    EXPECT_THAT(error.what(), HasSubstr("--port"));
  }
}

// 127.0.0.2 stands for another address of the machine; a container's port has another number outside.
TEST(ServerElsewhere, AnswersAddressesInFiguresOnly) {
  LocalServer server(0, "0.0.0.0");
  server.Get("", [](const LocalRequest&) { return LocalReply{"text/html", "page"}; });
  const std::string address = server.Address();
  EXPECT_THAT(address, testing::StartsWith("http://127.0.0.1:"));
  const std::string port = address.substr(17, address.find('/', 17) - 17), path = address.substr(17 + port.size());
  std::atomic<bool> done = false;
  std::thread thread([&] { server.Serve([&] { return done.load(); }); });
  httplib::Client client("http://127.0.0.2:" + port);
  const auto status = [&](const httplib::Headers& headers) { return client.Get(path, headers)->status; };
  EXPECT_EQ(status({}), 200);
  EXPECT_EQ(status({{"Host", "192.168.1.7:8080"}}), 200);
  EXPECT_EQ(status({{"Host", "localhost:8080"}}), 200);
  EXPECT_EQ(status({{"Host", "evil.example:" + port}}), 403) << "a name that is rebound to this machine";
  EXPECT_EQ(status({{"Host", "192.168.1.7:8080"}, {"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(client.Get("/")->status, 403) << "without the token";
  done = true;
  thread.join();
}

TEST(ServerElsewhere, RefusesWhatIsNoAddressOfThisMachine) {
  EXPECT_THROW(LocalServer(0, "example.org"), UsageError);
  EXPECT_THROW(LocalServer(0, "203.0.113.1"), Error);  // RFC 5737: nobody's
}

TEST(ServerToken, IsAnotherEachTime) {
  const LocalServer one(0), other(0);
  const auto token = [](const LocalServer& server) { return server.Address().substr(server.Address().size() - 33); };
  EXPECT_NE(token(one), token(other));
  EXPECT_THAT(token(one), testing::MatchesRegex("[0-9a-f]{32}/"));
}

}  // namespace
}  // namespace lake::review
