#include "html.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "page_files.h"

namespace lake::report {
namespace {

// Through the JSON library, which knows UTF-8.
std::string ValidUtf8(std::string_view text) {
  return Json::parse(Json(std::string(text)).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
}

bool IsDigit(char c) {
  return std::isdigit(static_cast<unsigned char>(c));
}

bool IsLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c));
}

constexpr std::string_view kPlusMinus = "±", kNoBreakSpace = "\u00A0", kDash = "–", kWordJoiner = "\u2060";

// Whether a unit stands at the beginning of the text, and no longer word that begins like it.
bool BeginsWithUnit(std::string_view text) {
  static const std::vector<std::string> units = Json::parse(PageUnits());
  return std::ranges::any_of(units, [&](const std::string& unit) {
    return text.starts_with(unit) &&
           (text.size() == unit.size() || (!IsLetter(text[unit.size()]) && !IsDigit(text[unit.size()])));
  });
}

// Whether a line must not end at this space.
bool IsWithinQuantity(std::string_view text, std::size_t space) {
  const std::string_view before = text.substr(0, space), after = text.substr(space + 1);
  if (after.starts_with(kPlusMinus) || before.ends_with(kPlusMinus)) return true;
  const bool is_moment = after.starts_with("m") && BeginsWithUnit(after) && before.size() > 1 &&
                         before.ends_with("N") && !IsLetter(before[before.size() - 2]);
  return is_moment || (!before.empty() && IsDigit(before.back()) && BeginsWithUnit(after));
}

// Whether the dash before `next` stands between two numbers.
bool IsWithinRange(std::string_view text, std::size_t next) {
  return next > kDash.size() && next < text.size() && IsDigit(text[next - kDash.size() - 1]) && IsDigit(text[next]);
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  constexpr std::pair<char, const char*> kEscapes[] = {
      {'<', "&lt;"}, {'>', "&gt;"}, {'&', "&amp;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
  std::string escaped;
  for (const char c : ValidUtf8(text)) {
    const auto escape = std::ranges::find(kEscapes, c, [](const auto& of) { return of.first; });
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    if (escape != std::end(kEscapes))
      escaped += escape->second;
    else
      escaped += control && c != '\n' && c != '\t' ? "\uFFFD" : std::string(1, c);
  }
  return escaped;
}

std::string TextHtml(std::string_view text) {
  const std::string escaped = EscapeHtml(text);
  std::string html;
  for (std::size_t i = 0; i < escaped.size(); ++i) {
    if (escaped[i] == ' ' && IsWithinQuantity(escaped, i))
      html += kNoBreakSpace;
    else
      html += escaped[i];
    if (html.ends_with(kDash) && IsWithinRange(escaped, i + 1)) html += kWordJoiner;
  }
  return html;
}

std::string ScriptJson(const Json& value) {
  std::string json;
  for (const char c : value.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    json += c == '<' ? "\\u003c" : std::string(1, c);
  }
  return json;
}

std::string Base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '\0');  // and the zero that OpenSSL writes after it
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  return text;
}

std::string EscapeHref(const std::filesystem::path& path) {
  constexpr std::string_view kPlain = "-._~/";
  // "./" keeps a colon in the first part of a name from being taken for a protocol.
  std::string href = path.is_absolute() ? "" : "./";
  for (const char c : path.generic_string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte < 0x80 && std::isalnum(byte)) || kPlain.find(c) != kPlain.npos;
    href += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return href;
}

}  // namespace lake::report
