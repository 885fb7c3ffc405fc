// A file of the operating system, open as long as an object lives.
#pragma once

#include <unistd.h>

namespace lake {

// -1: none.
class FileDescriptor {
 public:
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (number_ >= 0) close(number_);
  }

  operator int() const { return number_; }

 private:
  int number_;
};

}  // namespace lake
