// Text, data and files as parts of an HTML page.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lake/core/json.h"

namespace lake::report {

// Text for an element or a quoted attribute: invalid UTF-8 and control characters replaced, < > & " ' escaped.
std::string EscapeHtml(std::string_view text);

// Text for an element, escaped, with no-break spaces where a line must not end: between a number and its unit, in a
// unit of two words, before and after "±"; and no line's end at the dash between two numbers. Not for what is copied,
// such as command lines and names of files.
std::string TextHtml(std::string_view text);

// JSON for a <script> element: has no "<", so that neither "</script>" nor "<!--" can end or change it.
std::string ScriptJson(const Json& value);

std::string Base64(std::string_view bytes);

// A relative path as the value of a quoted href.
std::string EscapeHref(const std::filesystem::path& path);

}  // namespace lake::report
