// The exceptions of the project. A caller's mistake or a bad input throws one of these with a message of one line:
// what, where (file, line, frame), what to do. A solver that fails returns a status; only a program turns that into
// SolverError. A bug of our own is an assert.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace lake {

// An input or a run failed. Programs exit with 1. Line ends and other control characters, which come from names and
// cells of damaged files, become '?': a message is one line.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string message) : std::runtime_error(OneLine(std::move(message))) {}

  // Error("{}: no such marker '{}'", file, name)
  template <typename... Args>
  requires(sizeof...(Args) > 0) explicit Error(fmt::format_string<Args...> format, Args&&... args)
      : Error(fmt::format(format, std::forward<Args>(args)...)) {}

 private:
  static std::string OneLine(std::string text) {
    for (char& c : text)
      if (static_cast<unsigned char>(c) < ' ' || c == 0x7F) c = '?';
    return text;
  }
};

// A program was called wrongly. Programs exit with 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

// A solver ended without a usable solution; its best point and the reason have been written. Programs exit with 3.
class SolverError : public Error {
 public:
  using Error::Error;
};

// throw Fail("{}: no such marker '{}'", file, name);
template <typename... Args>
Error Fail(fmt::format_string<Args...> format, Args&&... args) {
  return Error(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace lake
