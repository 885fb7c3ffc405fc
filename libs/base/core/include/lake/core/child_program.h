// Another program, started by this one and listened to.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lake {

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
