#include "lake/core/standard_output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "lake/core/error.h"

namespace lake {

void FlushStdout() {
  errno = 0;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return;
  throw Fail("stdout: cannot be written{}{}", errno ? ": " : "", errno ? std::strerror(errno) : "");
}

}  // namespace lake
