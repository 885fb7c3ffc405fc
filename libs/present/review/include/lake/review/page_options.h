// Where a page is served, and who is notified.
#pragma once

#include <functional>
#include <string>

#include "lake/core/options.h"

namespace lake::review {

inline constexpr const char* kThisMachine = "127.0.0.1";

struct PageOptions {
  std::string listen = kThisMachine;  // an IPv4 address of this machine; 0.0.0.0: all of them
  int port = 0;                       // 0: any that is free
  bool open = false;                  // in the person's browser
  std::function<void(const std::string& address)> ready = {};
};

void Describe(PageOptions& o, OptionList& options);

// What to warn of where others than this machine can reach the page; else empty.
std::string WhoCanReach(const PageOptions& page);

}  // namespace lake::review
