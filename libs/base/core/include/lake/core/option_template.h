// Options as the keys of a YAML file that a person fills in: each with its default and what it means.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lake/core/options.h"

namespace lake {

// A line for each option, `indent` spaces from the margin, with its value if there is one.
std::string OptionTemplate(const OptionList& options, int indent);

// One line of it: "key: value                # meaning".
std::string TemplateLine(std::string_view key, std::string_view value, std::string_view meaning, int indent = 0);

// Each line with a '#' before it, `indent` spaces from the margin, for what may be left out: without the '#' it is as
// it was.
std::string AsComment(std::string_view text, int indent = 0);

// Throws Error if a file is there already.
void WriteTemplateFile(const std::filesystem::path& path, std::string_view text);

}  // namespace lake
