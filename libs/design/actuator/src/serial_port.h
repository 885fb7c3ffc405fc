// A serial line of the operating system (POSIX termios), raw, 8N1.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lake/core/file_descriptor.h"

namespace lake::actuator {

class SerialPort {
 public:
  // 115200 baud. Throws Error naming the port: it cannot be opened, is no serial line, or another program has it.
  explicit SerialPort(const std::filesystem::path& path);

  // What has arrived, after waiting for at most so long; empty if nothing has. Throws Error if the line is gone.
  std::string Read(double most_s);

  // Throws Error if the line is gone or takes nothing for a second.
  void Write(std::string_view text);

 private:
  std::filesystem::path path_;
  FileDescriptor file_;
};

}  // namespace lake::actuator
