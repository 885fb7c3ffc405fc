#include "lake/actuator/serial_frame.h"

#include <fmt/format.h>

#include <boost/crc.hpp>

namespace lake::actuator {

std::string Framed(std::string_view text) {
  boost::crc_optimal<16, 0x1021, 0xFFFF, 0, true, true> crc;
  crc.process_bytes(text.data(), text.size());
  return fmt::format("{}*{:04X}", text, crc.checksum());
}

std::optional<std::string> Unframed(std::string_view line) {
  std::string text(line.substr(0, line.rfind('*')));
  if (Framed(text) != line) return std::nullopt;
  return text;
}

}  // namespace lake::actuator
