// Text of unknown encoding, as files of other programs hold it.
#pragma once

#include <string>
#include <string_view>

namespace lake {

bool IsUtf8(std::string_view text);

// UTF-8 as it is; in anything else, as a file's name may be, each byte beyond ASCII becomes U+FFFD.
std::string ReadableUtf8(std::string_view text);

// UTF-8 as it is; anything else is taken for Latin-1 (ISO 8859-1) and becomes UTF-8. Throws Error, naming `where`, for
// bytes that are text in neither.
std::string Utf8FromText(std::string text, std::string_view where);

}  // namespace lake
