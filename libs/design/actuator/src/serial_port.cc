#include "serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "lake/core/error.h"

namespace lake::actuator {
namespace {

constexpr int kPatience_ms = 1000;

bool WaitFor(int file, short events, int most_ms) {
  pollfd poll_file{file, events, 0};
  return poll(&poll_file, 1, most_ms) > 0;
}

}  // namespace

SerialPort::SerialPort(const std::filesystem::path& path)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (file_ < 0)
    throw Fail("{}: the serial line cannot be opened ({}); is the board plugged in, and are you in the group dialout?",
               path.string(), std::strerror(errno));
  termios settings{};
  const bool is_line = tcgetattr(file_, &settings) == 0;
  if (!is_line || flock(file_, LOCK_EX | LOCK_NB) != 0)
    throw Fail("{}: {}", path.string(),
               is_line ? "another program has this serial line; close its serial monitor" : "this is no serial line");
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);  // the line's end does not reset the board
  cfsetspeed(&settings, B115200);
  tcsetattr(file_, TCSANOW, &settings);
  tcflush(file_, TCIOFLUSH);
}

std::string SerialPort::Read(double most_s) {
  std::array<char, 512> buffer;
  if (!WaitFor(file_, POLLIN, static_cast<int>(std::lround(1e3 * most_s)))) return {};
  const ssize_t count = read(file_, buffer.data(), buffer.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  if (count <= 0) throw Fail("{}: the serial line is gone; was the board unplugged?", path_.string());
  return {buffer.data(), static_cast<std::size_t>(count)};
}

void SerialPort::Write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(file_, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (!(count < 0 && (errno == EAGAIN || errno == EINTR) && WaitFor(file_, POLLOUT, kPatience_ms))) {
      throw Fail("{}: the serial line takes nothing; was the board unplugged?", path_.string());
    }
  }
}

}  // namespace lake::actuator
