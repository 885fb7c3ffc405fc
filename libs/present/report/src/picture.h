// A picture or film file as a part of the page itself.
#pragma once

#include <filesystem>
#include <string>

namespace lake::report {

struct EmbeddedFile {
  std::string media_type;  // "image/png", …
  std::string data_uri{};
  std::string drawing{};  // of an SVG that runs nothing: its element, which stands in the page as it is
  int width_px = 0;       // of the drawing
  bool IsVideo() const { return media_type == "video/mp4"; }
};

// The type is told by the content. Throws Error: unreadable, unknown, larger than 64 MB.
EmbeddedFile EmbedFile(const std::filesystem::path& file);

}  // namespace lake::report
