// A page shown to the person at this machine.
#pragma once

#include <string>

namespace lake::review {

// With the desktop's own program for addresses; where there is none, a line of `program` on stderr says so.
void OpenInBrowser(const std::string& program, const std::string& address);

}  // namespace lake::review
