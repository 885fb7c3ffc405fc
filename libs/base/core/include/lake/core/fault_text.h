// What is said of an exception that was not expected.
#pragma once

#include <exception>
#include <string>

namespace lake {

// An Error's and the system's own words. Of a library's exception that something at this input was beyond it: its own
// words name files of its sources, and are of use to nobody but who mends the program; which function of OpenCV failed
// is said for that.
std::string FaultText(const std::exception& fault);

}  // namespace lake
