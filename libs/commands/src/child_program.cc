#include "child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <functional>
#include <utility>

#include "lake/core/error.h"

extern char** environ;

namespace lake::commands {

namespace fs = std::filesystem;

namespace {

// A program that is listened to; ended with this object if it still runs.
class Child {
 public:
  Child(const fs::path& program, const std::vector<std::string>& arguments, ChildSays says) {
    std::array<int, 2> pipe;
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw Fail("{}: {}", program.string(), std::strerror(errno));
    read_ = pipe[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (says == ChildSays::kAll)
      posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
    else
      posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe[1], STDERR_FILENO);
    std::string name = program.string();
    std::vector<std::string> words = arguments;
    std::vector<char*> texts = {name.data()};
    for (std::string& word : words) texts.push_back(word.data());
    texts.push_back(nullptr);
    const int error = posix_spawn(&pid_, name.c_str(), &actions, nullptr, texts.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(pipe[1]);
    if (error != 0) {
      close(read_);
      throw Fail("{}: cannot be started: {}", program.string(), std::strerror(error));
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    close(read_);
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }

  // Hands out what it says, line by line, until it ends; returns its exit code. Throws what `check` throws.
  int Follow(const std::function<void(const std::string&)>& say, const std::function<void()>& check) {
    std::string line;
    std::array<char, 4096> bytes;
    while (true) {
      check();
      pollfd waiting{read_, POLLIN, 0};
      if (poll(&waiting, 1, 100) <= 0) continue;
      const ssize_t count = read(read_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) break;
      for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(count)))
        if (c != '\n' && c != '\r')
          line += c;
        else if (!line.empty())
          say(std::exchange(line, {}));
    }
    int status = 0;
    waitpid(std::exchange(pid_, 0), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  int read_ = -1;
  pid_t pid_ = 0;
};

}  // namespace

ChildEnd RunChild(const fs::path& program, const std::vector<std::string>& arguments,
                  const review::BackgroundJob::Control& control, ChildSays says) {
  ChildEnd end;
  const auto say = [&](const std::string& line) {
    end.last_line = line;
    control.say(line);
  };
  end.code = Child(program, arguments, says).Follow(say, control.throw_if_stopped);
  return end;
}

}  // namespace lake::commands
