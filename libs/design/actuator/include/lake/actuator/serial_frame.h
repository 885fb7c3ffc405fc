// A line of the firmware with its check sum: `text*HHHH`, where HHHH is the CRC-16/MCRF4XX of the text (polynomial
// 0x1021 from the lowest bit on, from 0xFFFF) in hexadecimal digits. The firmware's end is in firmware/protocol.c.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lake::actuator {

std::string Framed(std::string_view text);

// The text of a line without its end; nothing if the check sum is missing or wrong.
std::optional<std::string> Unframed(std::string_view line);

}  // namespace lake::actuator
