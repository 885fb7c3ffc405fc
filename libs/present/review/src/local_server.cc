#include "lake/review/local_server.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <sys/random.h>

#include <array>
#include <chrono>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"
#include "lake/core/json.h"

namespace lake::review {
namespace {

constexpr const char* kLoopback = "127.0.0.1";
constexpr const char* kJson = "application/json";

// 128 bits of the system's own generator, in hexadecimal digits.
std::string RandomToken() {
  std::array<unsigned char, 16> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("the system gives no random numbers for the page's address");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

// Takes as long for every text of that length, so that the time does not show how much of it was right.
bool IsSame(std::string_view given, std::string_view secret) {
  if (given.size() != secret.size()) return false;
  unsigned differences = 0;
  for (std::size_t i = 0; i < secret.size(); ++i) differences |= static_cast<unsigned>(given[i] ^ secret[i]);
  return differences == 0;
}

void Refuse(int status, const std::string& why, httplib::Response& response) {
  response.status = status;
  response.set_content(Json{{"error", why}}.dump(-1, ' ', false, Json::error_handler_t::replace), kJson);
}

constexpr const char* kPolicy = "Content-Security-Policy";

// As if it came from nowhere: what it asks of this server has no origin, and is refused.
constexpr const char* kFramedPolicy =
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

// Nothing from elsewhere, in no other page's frame, kept nowhere.
httplib::Headers DefaultHeaders() {
  return {{kPolicy,
           "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
           "frame-src 'self'; "
           "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Referrer-Policy", "no-referrer"},
          {"X-Content-Type-Options", "nosniff"}};
}

}  // namespace

struct LocalServer::Impl {
  struct Route {
    std::string method, path;
    Handler handler;
    std::function<std::shared_ptr<void>()> hold;  // instead of the handler
  };

  // No name that somebody's DNS server could bind to this machine.
  bool MayBeAsked(const std::string& host) const {
    if (host == fmt::format("{}:{}", kLoopback, port) || host == fmt::format("localhost:{}", port)) return true;
    if (listen == kLoopback) return false;
    const std::string name = host.substr(0, host.find(':'));
    in_addr address;
    return name == "localhost" || inet_pton(AF_INET, name.c_str(), &address) == 1;
  }

  // Whose request it is; an empty text lets it pass.
  std::string Objection(const httplib::Request& request) const {
    const std::string host = request.get_header_value("Host"), origin = request.get_header_value("Origin");
    if (!MayBeAsked(host)) return fmt::format("this address answers to {} only", listen);
    if (request.has_header("Origin") && origin != "http://" + host) return "another page's script may not ask this";
    const std::string_view path = request.path;
    if (path.size() < token.size() + 2 || path[0] != '/' || path[token.size() + 1] != '/' ||
        !IsSame(path.substr(1, token.size()), token))
      return "the address needs the token that was printed with it";
    return {};
  }

  httplib::Server::HandlerResponse Answer(const httplib::Request& request, httplib::Response& response) const {
    using enum httplib::Server::HandlerResponse;
    const std::string objection = Objection(request);
    if (!objection.empty()) {
      Refuse(403, objection, response);
      return Handled;
    }
    if (request.method == "POST") return Unhandled;  // comes back with its body
    if (request.method == "GET" || request.method == "HEAD")
      Dispatch("GET", request, response);
    else
      Refuse(405, "only GET, HEAD and POST are answered", response);
    return Handled;
  }

  void AnswerPost(const httplib::Request& request, httplib::Response& response) const {
    if (!request.get_header_value("Content-Type").starts_with(kJson))
      return Refuse(415, "what is sent must be JSON", response);
    Dispatch("POST", request, response);
  }

  void Dispatch(const std::string& method, const httplib::Request& request, httplib::Response& response) const {
    const std::string path = request.path.substr(token.size() + 2);
    for (const Route& route : routes) {
      const bool is_folder = route.path.ends_with('/');
      if (route.method != method || (is_folder ? !path.starts_with(route.path) : path != route.path)) continue;
      if (route.hold) return Hold(route.hold(), response);
      return Call(route, {path.substr(route.path.size()), request.body}, response);
    }
    Refuse(404, "there is nothing of that name", response);
  }

  static void Call(const Route& route, const LocalRequest& local, httplib::Response& response) {
    try {
      LocalReply reply = route.handler(local);
      response.status = reply.status;
      if (reply.is_framed) {
        response.headers.erase(kPolicy);
        response.set_header(kPolicy, kFramedPolicy);
      }
      response.set_header("Cache-Control", reply.may_keep ? "private, max-age=86400" : "no-store");
      Send(std::move(reply), response);
    } catch (const Error& error) {
      Refuse(400, error.what(), response);
    } catch (const nlohmann::json::exception&) {
      Refuse(400, "what was sent is not what is understood here", response);
    } catch (const Interrupted&) {
      Refuse(503, "the program is ending", response);
    } catch (const std::exception& error) {
      Refuse(500, FaultText(error), response);
    }
  }

  // As it is: what the library is given whole it compresses by Brotli at its best and slowest, which takes longer than
  // what it saves on the way to a browser on this machine.
  static void Send(LocalReply reply, httplib::Response& response) {
    if (reply.body.empty()) return response.set_content("", reply.type);
    const std::size_t size = reply.body.size();
    response.set_content_provider(
        size, reply.type, [body = std::move(reply.body)](std::size_t at, std::size_t length, httplib::DataSink& sink) {
          return sink.write(body.data() + at, length);
        });
  }

  static void Hold(std::shared_ptr<void> held, httplib::Response& response) {
    constexpr std::chrono::milliseconds kBeat{250};  // a connection that has gone is noticed at the second
    constexpr std::string_view kComment = ":\n\n";   // an event stream's
    response.set_header("Cache-Control", "no-store");
    response.set_chunked_content_provider(
        "text/event-stream",
        [kBeat, kComment](std::size_t, httplib::DataSink& sink) {
          std::this_thread::sleep_for(kBeat);
          return sink.write(kComment.data(), kComment.size());
        },
        [held = std::move(held)](bool) mutable { held.reset(); });
  }

  httplib::Server server;
  int port = 0;
  std::string listen;
  std::string token = RandomToken();
  std::vector<Route> routes;
};

LocalServer::LocalServer(int port, const std::string& listen) : impl_(std::make_unique<Impl>()) {
  if (in_addr address; inet_pton(AF_INET, listen.c_str(), &address) != 1)
    throw UsageError("--listen {}: an IPv4 address of this machine is needed, such as 0.0.0.0 for all of them", listen);
  impl_->listen = listen;
  constexpr std::size_t kMostBytes = 1 << 20, kMostRequests = 1000;
  constexpr std::size_t kThreads = 16;  // one for each connection; a browser opens six
  httplib::Server& server = impl_->server;
  // The library's default shares a port with whoever else asks for that.
  server.set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server.set_default_headers(DefaultHeaders());
  server.set_payload_max_length(kMostBytes);
  server.set_keep_alive_timeout(1);  // a connection that waits delays the end by as long
  server.set_keep_alive_max_count(kMostRequests);
  server.set_tcp_nodelay(true);
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };  // the library's own way; it deletes it
  server.set_pre_routing_handler(
      [this](const auto& request, auto& response) { return impl_->Answer(request, response); });
  server.Post("/.*", [this](const auto& request, auto& response) { impl_->AnswerPost(request, response); });
  if (port == 0)
    impl_->port = server.bind_to_any_port(listen);
  else
    impl_->port = server.bind_to_port(listen, port) ? port : -1;
  if (impl_->port <= 0)
    throw port == 0
        ? Fail("{}: no port can be opened; is it an address of this machine?", listen)
        : Fail(
              "{}:{}: the port is in use or not allowed, or this machine does not have that address; choose another "
              "with --port",
              listen, port);
}

LocalServer::~LocalServer() = default;

std::string LocalServer::Address() const {
  const std::string& host = impl_->listen == "0.0.0.0" ? kLoopback : impl_->listen;
  return fmt::format("http://{}:{}/{}/", host, impl_->port, impl_->token);
}

void LocalServer::Get(const std::string& path, Handler handler) {
  impl_->routes.push_back({"GET", path, std::move(handler), {}});
}

void LocalServer::Post(const std::string& path, Handler handler) {
  impl_->routes.push_back({"POST", path, std::move(handler), {}});
}

void LocalServer::GetHeld(const std::string& path, std::function<std::shared_ptr<void>()> begin) {
  impl_->routes.push_back({"GET", path, {}, std::move(begin)});
}

void LocalServer::Serve(const std::function<bool()>& is_done) {
  struct Listening {
    explicit Listening(httplib::Server& listening) : server(listening) {}
    ~Listening() {
      server.stop();
      thread.join();
    }
    httplib::Server& server;
    std::thread thread{[this] { server.listen_after_bind(); }};
  };
  const Listening listening(impl_->server);
  while (!impl_->server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  while (!is_done()) {
    ThrowIfInterrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace lake::review
