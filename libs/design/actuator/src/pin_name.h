// How pins are printed on the board. Not part of the interface.
#pragma once

#include <fmt/format.h>

#include <string>

namespace lake::actuator {

inline std::string PinName(int pin) {
  return pin < 14 ? fmt::format("D{}", pin) : fmt::format("A{}", pin - 14);
}

}  // namespace lake::actuator
