#include "lake/review/open_browser.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "lake/core/child_program.h"

namespace lake::review {

void OpenInBrowser(const std::string& program, const std::string& address) {
  std::signal(SIGCHLD, SIG_DFL);
  if (IsInPath("xdg-open"))
    StartChild({"xdg-open", address}, {});
  else
    fmt::print(stderr, "{}: xdg-open is not there; open the address yourself\n", program);
}

}  // namespace lake::review
