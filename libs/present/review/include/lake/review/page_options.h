// Where a page is served, and who is told.
#pragma once

#include <functional>
#include <string>

namespace lake::review {

struct PageOptions {
  int port = 0;  // 0: any that is free
  std::function<void(const std::string& address)> ready;
};

}  // namespace lake::review
