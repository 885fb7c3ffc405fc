#include "picture.h"

#include <charconv>
#include <optional>
#include <regex>
#include <string_view>

#include "html.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"

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

void ReplaceAll(std::string& text, std::string_view from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) text.replace(at, from.size(), to);
}

// What an SVG calls its parts, under names that no other drawing of the page has.
void NameParts(std::string& svg) {
  const std::string own = "d" + Sha256OfText(svg).substr(0, 8) + "-";
  for (const std::string_view before : {"id='", "id=\"", "href='#", "href=\"#", "url(#"})
    ReplaceAll(svg, before, std::string(before) + own);
}

// A page may run scripts, so what it takes in as text must have none; pictures never run any.
bool RunsSomething(const std::string& svg) {
  static const std::regex kRuns("<script|<foreignObject|\\son[a-z]+\\s*=|javascript:", std::regex::icase);
  return std::regex_search(svg, kRuns);
}

// Without what is no part of the element, and without its title, which a page would show over all of it.
std::optional<std::string> ElementOf(const std::string& svg) {
  const std::size_t from = svg.find("<svg"), to = svg.rfind("</svg>");
  if (from == svg.npos || to == svg.npos || to < from || RunsSomething(svg)) return std::nullopt;
  std::string element = svg.substr(from, to - from) + "</svg>";
  const std::size_t title = element.find("<title>"), title_end = element.find("</title>");
  if (title < title_end && title_end != element.npos)
    element.erase(title, title_end + std::string_view("</title>").size() - title);
  NameParts(element);
  return element;
}

// In the element's own tag; 0 if it does not say.
int WidthOf(std::string_view element) {
  constexpr std::string_view kWidth = " width=\"";
  const std::size_t at = element.substr(0, element.find('>')).find(kWidth);
  int width_px = 0;
  if (at != element.npos)
    std::from_chars(element.data() + at + kWidth.size(), element.data() + element.size(), width_px);
  return width_px;
}

}  // namespace

EmbeddedFile EmbedFile(const std::filesystem::path& file) {
  const std::string bytes = ReadTextFile(file, kMaxBytes);
  const std::string type = MediaType(bytes);
  if (type.empty()) throw Fail("{}: a report takes PNG, JPEG, GIF, SVG and MP4 only", file.string());
  EmbeddedFile embedded{.media_type = type};
  if (type == "image/svg+xml")
    if (auto element = ElementOf(bytes); element && WidthOf(*element) > 0) {
      embedded.width_px = WidthOf(*element);
      embedded.drawing = *std::move(element);
      return embedded;
    }
  embedded.data_uri = "data:" + type + ";base64," + Base64(bytes);
  return embedded;
}

}  // namespace lake::report
