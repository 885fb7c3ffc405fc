// Another program, started by this one and listened to.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lake {

// A file to be written anew; children do not inherit it. Throws Error naming the file.
int WriteTo(const std::filesystem::path& file);

// Descriptors that a program reads from and writes to; -1: it has nothing to read, and writes where this one does.
struct ChildStreams {
  int in = -1, out = -1, err = -1;
};

// Whether a program is found in PATH.
bool IsInPath(const std::string& program);

// Starts a program, by its path or found in PATH, with its arguments: the only place that does. It is in a process
// group of its own: Ctrl-C is for this program, which then ends the other (WaitForChild in processes.h). Throws Error
// naming the program where it cannot be started.
pid_t StartChild(const std::vector<std::string>& words, const ChildStreams& streams);

struct ChildEnd {
  int code = 0;           // its exit status; 128 + the signal that ended it
  std::string last_line;  // that it said on stderr
  std::string output;     // all that it wrote to stdout
};

// Runs it to its end. `say` gets what it says on stderr, line by line; what `check` throws, asked ten times a second,
// is thrown once the program has been ended by SIGTERM and waited for. Throws Error naming the program where it cannot
// be started.
ChildEnd RunChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const std::function<void(const std::string& line)>& say, const std::function<void()>& check);

}  // namespace lake
