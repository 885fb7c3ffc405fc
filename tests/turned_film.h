// A film with a display rotation, for tests.
#pragma once

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "lake/core/error.h"

namespace lake {

// Since FFmpeg 6 the rotation is an option of the input, counterclockwise; before, it was metadata, clockwise.
inline void TurnFilm(const std::filesystem::path& film, int clockwise_deg, const std::filesystem::path& turned) {
  const std::string from = fmt::format("-i '{}' -c copy", film.string()), start = "ffmpeg -y -v error -nostdin";
  const std::string command =
      fmt::format("{0} -display_rotation {1} {2} '{3}' 2> /dev/null || {0} {2} -metadata:s:v rotate={4} '{3}'", start,
                  -clockwise_deg, from, turned.string(), clockwise_deg);
  if (std::system(command.c_str()) != 0) throw Fail("{}", command);
}

}  // namespace lake
