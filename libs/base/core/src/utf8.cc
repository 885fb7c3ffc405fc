#include "lake/core/utf8.h"

#include <array>
#include <cstdint>

namespace lake {
namespace {

// The length of the character that begins with this byte; 0 if none does.
std::size_t LengthOf(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  return lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
}

}  // namespace

bool IsUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = LengthOf(static_cast<unsigned char>(text[i]));
    if (length == 0 || i + length > text.size()) return false;
    std::uint32_t code = static_cast<unsigned char>(text[i]) & (length == 1 ? 0x7Fu : 0xFFu >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      const auto byte = static_cast<unsigned char>(text[i + k]);
      if ((byte & 0xC0u) != 0x80) return false;
      code = code << 6 | (byte & 0x3Fu);
    }
    // Longer than need be, half of a surrogate pair, or beyond Unicode.
    constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
    if (code < kLeast[length] || (code >= 0xD800 && code < 0xE000) || code > 0x10FFFF) return false;
    i += length;
  }
  return true;
}

std::string ReadableUtf8(std::string_view text) {
  if (IsUtf8(text)) return std::string(text);
  std::string readable;
  for (const char c : text) readable += static_cast<unsigned char>(c) < 0x80 ? std::string(1, c) : "\uFFFD";
  return readable;
}

std::string Utf8FromText(std::string text) {
  // Windows-1252 has letters where Latin-1 has none, at 0x80 to 0x9F; five of them are not given.
  constexpr const char* kWindows[] = {"€", "\uFFFD", "‚",      "ƒ", "„",      "…",      "†", "‡",      "ˆ", "‰", "Š",
                                      "‹", "Œ",      "\uFFFD", "Ž", "\uFFFD", "\uFFFD", "‘", "’",      "“", "”", "•",
                                      "–", "—",      "˜",      "™", "š",      "›",      "œ", "\uFFFD", "ž", "Ÿ"};
  constexpr unsigned char kFirst = 0x80, kFirstOfLatin = 0xA0;
  if (IsUtf8(text)) return text;
  std::string utf8;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < kFirst) {
      utf8 += c;
    } else if (byte < kFirstOfLatin) {
      utf8 += kWindows[byte - kFirst];
    } else {
      utf8 += static_cast<char>(0xC0 | byte >> 6);
      utf8 += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return utf8;
}

}  // namespace lake
