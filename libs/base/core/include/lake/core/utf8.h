// Text of unknown encoding, as files of other programs hold it.
#pragma once

#include <string>
#include <string_view>

namespace lake {

bool IsUtf8(std::string_view text);

// UTF-8 as it is; in anything else, as a file's name may be, each byte beyond ASCII becomes U+FFFD.
std::string ReadableUtf8(std::string_view text);

// UTF-8 as it is; anything else is taken for Windows-1252, of which Latin-1 (ISO 8859-1) is a part, and becomes UTF-8.
std::string Utf8FromText(std::string text);

}  // namespace lake
