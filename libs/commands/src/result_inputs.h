// What a folder of results was made of, as its summary names it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"

namespace lake::commands {

// A summary.json; the paths of its options and inputs are as they were given, with the home folder. Throws Error.
Json ReadSummary(const std::filesystem::path& file);

// The file that an entry of a summary's `inputs` names. Inputs are named as from the folder in which the run was
// started: the present one, or one above the results. One that was moved is known by its content, if it lies in one of
// these. Throws Error: not to be found, or changed.
std::filesystem::path FindInput(const Json& input, const std::filesystem::path& results);

// The program whose results are in a folder; empty if none.
std::string MakerOf(const std::filesystem::path& folder);

// An option as a command line says it: --NAME VALUE for each of its values, --NAME or --no-NAME for a flag; nothing
// where it was not given.
std::vector<std::string> WordsOf(const Option& option);

}  // namespace lake::commands
