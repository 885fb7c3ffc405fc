// SIGINT and SIGTERM end a program cleanly: long loops call ThrowIfInterrupted(), destructors remove what is half
// written.
#pragma once

#include <exception>

namespace lake {

class Interrupted : public std::exception {
 public:
  explicit Interrupted(int signal) : signal_(signal) {}
  int Signal() const { return signal_; }
  const char* what() const noexcept override { return "interrupted"; }

 private:
  int signal_;
};

// Makes the two signals set a flag instead of ending the process. A second signal ends it at once.
void CatchInterrupts();

// Throws Interrupted once a signal has arrived.
void ThrowIfInterrupted();

}  // namespace lake
