#include "lake/core/child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/processes.h"

extern char** environ;

namespace lake {

namespace fs = std::filesystem;

namespace {

// What a program writes to one of its outputs.
class Stream {
 public:
  using Take = std::function<void(std::string_view bytes)>;

  explicit Stream(const fs::path& program) {
    std::array<int, 2> pipe;
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw Fail("{}: {}", program.string(), std::strerror(errno));
    read_ = pipe[0];
    write_ = pipe[1];
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() {
    CloseWrite();
    CloseRead();
  }

  int WriteEnd() const { return write_; }
  int ReadEnd() const { return read_; }  // -1 once all was read
  void CloseWrite() { Close(write_); }
  void CloseRead() { Close(read_); }

  void Read(const Take& take) {
    std::array<char, 4096> bytes;
    const ssize_t count = read(read_, bytes.data(), bytes.size());
    if (count > 0) return take({bytes.data(), static_cast<std::size_t>(count)});
    if (count == 0 || errno != EINTR) CloseRead();
  }

 private:
  static void Close(int& end) {
    if (end >= 0) close(std::exchange(end, -1));
  }

  int read_ = -1, write_ = -1;
};

// Hands out what is said line by line; '\r' ends a line too, as progress has it.
class Lines {
 public:
  explicit Lines(const std::function<void(const std::string&)>& say) : say_(say) {}

  void Add(std::string_view bytes) {
    for (const char c : bytes)
      if (c != '\n' && c != '\r')
        line_ += c;
      else
        End();
  }
  void End() {
    if (!line_.empty()) say_(std::exchange(line_, {}));
  }

 private:
  const std::function<void(const std::string&)>& say_;
  std::string line_;
};

// A program that is listened to; ended with this object if it still runs.
class Child {
 public:
  Child(const fs::path& program, const std::vector<std::string>& arguments)
      : name_(program.string()), output_(program), said_(program) {
    std::vector<std::string> words = {name_};
    words.insert(words.end(), arguments.begin(), arguments.end());
    pid_ = StartChild(words, {.out = output_.WriteEnd(), .err = said_.WriteEnd()});
    output_.CloseWrite();
    said_.CloseWrite();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    output_.CloseRead();  // it must not wait for a reader
    said_.CloseRead();
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    WaitForEnd(pid_);
  }

  // Hands out what it writes until it ends; returns its exit status, or 128 + the signal that ended it. Throws what
  // `check` throws.
  int Follow(const Stream::Take& take_output, const Stream::Take& take_said, const std::function<void()>& check) {
    while (output_.ReadEnd() >= 0 || said_.ReadEnd() >= 0) {
      check();
      std::array<pollfd, 2> waiting{{{output_.ReadEnd(), POLLIN, 0}, {said_.ReadEnd(), POLLIN, 0}}};
      if (poll(waiting.data(), waiting.size(), 100) <= 0) continue;
      if (waiting[0].revents != 0) output_.Read(take_output);
      if (waiting[1].revents != 0) said_.Read(take_said);
    }
    const std::optional<int> status = WaitForEnd(std::exchange(pid_, 0));
    if (!status) throw Fail("{}: its exit status is unknown", name_);
    return WIFEXITED(*status) ? WEXITSTATUS(*status) : 128 + WTERMSIG(*status);
  }

 private:
  std::string name_;
  Stream output_, said_;
  pid_t pid_ = 0;
};

}  // namespace

bool IsInPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  for (const std::string& folder : SplitText(path ? path : "", ':'))
    if (access((fs::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

int WriteTo(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) throw Fail("{}: {}", file.string(), std::strerror(errno));
  return descriptor;
}

pid_t StartChild(const std::vector<std::string>& words, const ChildStreams& streams) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (streams.in < 0)
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  else
    posix_spawn_file_actions_adddup2(&actions, streams.in, STDIN_FILENO);
  if (streams.out >= 0) posix_spawn_file_actions_adddup2(&actions, streams.out, STDOUT_FILENO);
  if (streams.err >= 0) posix_spawn_file_actions_adddup2(&actions, streams.err, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  std::vector<std::string> texts = words;
  std::vector<char*> arguments;
  for (std::string& text : texts) arguments.push_back(text.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw Fail("{}: cannot be started: {}", words.front(), std::strerror(error));
  return child;
}

ChildEnd RunChild(const fs::path& program, const std::vector<std::string>& arguments,
                  const std::function<void(const std::string&)>& say, const std::function<void()>& check) {
  ChildEnd end;
  const std::function<void(const std::string&)> keep = [&](const std::string& line) {
    end.last_line = line;
    say(line);
  };
  Lines lines(keep);
  end.code = Child(program, arguments)
                 .Follow([&](std::string_view bytes) { end.output += bytes; },
                         [&](std::string_view bytes) { lines.Add(bytes); }, check);
  lines.End();
  return end;
}

}  // namespace lake
