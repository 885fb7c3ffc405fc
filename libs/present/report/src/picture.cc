#include "picture.h"

#include <string_view>

#include "html.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake::report {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;

std::string MediaType(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\x89PNG\r\n\x1A\n"sv)) return "image/png";
  if (bytes.starts_with("\xFF\xD8\xFF"sv)) return "image/jpeg";
  if (bytes.starts_with("GIF87a"sv) || bytes.starts_with("GIF89a"sv)) return "image/gif";
  if (bytes.substr(0, 12).find("ftyp"sv) == 4) return "video/mp4";
  if (bytes.substr(0, 1024).find("<svg"sv) != bytes.npos) return "image/svg+xml";
  return {};
}

}  // namespace

EmbeddedFile EmbedFile(const std::filesystem::path& file) {
  const std::string bytes = ReadTextFile(file, kMaxBytes);
  const std::string type = MediaType(bytes);
  if (type.empty()) throw Fail("{}: a report takes PNG, JPEG, GIF, SVG and MP4 only", file.string());
  return {type, "data:" + type + ";base64," + Base64(bytes)};
}

}  // namespace lake::report
