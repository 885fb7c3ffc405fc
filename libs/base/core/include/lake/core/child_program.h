// Starts other programs and reads what they print.
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

// Starts a program, by its path or found in PATH, with its arguments. No other function does. The program gets a
// process group of its own, so Ctrl-C reaches this program alone, which then ends the other (WaitForChild in
// processes.h). Throws Error naming the program where it cannot be started.
pid_t StartChild(const std::vector<std::string>& words, const ChildStreams& streams);

struct ChildEnd {
  int code = 0;           // its exit status; 128 + the signal that ended it
  std::string last_line;  // of stderr
  std::string output;     // all that it wrote to stdout
};

// Runs a program to its end. `say` gets each line of its stderr. `check` is called ten times a second; if it throws,
// the program is ended by SIGTERM and waited for, and the exception passes on. Throws Error naming the program where it
// cannot be started.
ChildEnd RunChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const std::function<void(const std::string& line)>& say, const std::function<void()>& check);

}  // namespace lake
