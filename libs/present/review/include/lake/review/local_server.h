// A web server for one person.
//
// By default it listens at 127.0.0.1 only. An address begins with a random token; whatever else is asked for is
// refused, as is a request by another name of the machine (DNS rebinding), one that another page's script sends, and
// every method but GET, HEAD and POST. It serves what its handlers return and no files.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace lake::review {

struct LocalRequest {
  std::string rest;  // of the path, behind the handler's own: "12.jpg" for frame/12.jpg
  std::string body;  // of a POST: JSON, 1 MB at most
};

struct LocalReply {
  std::string type;  // text/html; charset=utf-8, application/json, …
  std::string body;
  int status = 200;
  bool may_keep = false;  // the browser may keep it as long as it shows the page
  // A document of its own, shown in a frame of the page: its scripts may run, but may ask for nothing.
  bool is_framed = false;
};

class LocalServer {
 public:
  // An Error that it throws goes to the page, with status 400.
  using Handler = std::function<LocalReply(const LocalRequest&)>;

  // Takes the port of that IPv4 address of this machine (0.0.0.0: of all), any free one if 0. At another address than
  // 127.0.0.1, requests by any address in figures are answered, as a container's port may have another number outside.
  // Throws Error where the port is in use or the address is none of this machine's.
  explicit LocalServer(int port, const std::string& listen = "127.0.0.1");
  ~LocalServer();

  // http://ADDRESS:PORT/TOKEN/, with 127.0.0.1 for 0.0.0.0.
  std::string Address() const;

  // A path below the address, "trial"; all that begins with it if it ends in '/'. To be called before Serve().
  void Get(const std::string& path, Handler handler);
  void Post(const std::string& path, Handler handler);

  // An answer without an end (server-sent events that say nothing): what `begin` returns lives as long as the one who
  // asked keeps the connection.
  void GetHeld(const std::string& path, std::function<std::shared_ptr<void>()> begin);

  // Answers until `is_done` says true. Handlers run in several threads. Throws Interrupted once a signal has arrived.
  void Serve(const std::function<bool()>& is_done);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lake::review
