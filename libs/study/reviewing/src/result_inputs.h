// What a folder of results was made of, as its summary names it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"

namespace lake::reviewing {

// A summary.json; the paths of its options and inputs are as they were given, with the home folder. Throws Error.
Json ReadSummary(const std::filesystem::path& file);

// Whether a summary is that of a study's step: the study says where it lies.
bool IsOfStudy(const Json& summary);

// The options of the summary in this folder that its run was given, the others being defaults or what a file said that
// one of these names. Throws Error for a summary of an older version, which does not say.
Json GivenOptions(const Json& summary, const std::filesystem::path& folder);

// A folder, given as an absolute path, and those above it, the nearest first.
std::vector<std::filesystem::path> WithAbove(const std::filesystem::path& folder);

// The file that an entry of a summary's `inputs` names. Inputs are named as from the folder in which the run was
// started: the present one, or one above the results or above what the results are of, as their list has it (a study's
// file). One that was moved is known by its content, if it lies in one of these. Throws Error: not to be found, or
// changed.
std::filesystem::path FindInput(const Json& input, const std::filesystem::path& results);

// The entry of a summary's `inputs` with this role, the first of several; nullptr if there is none.
const Json* InputOf(const Json& summary, const std::string& role);

// The file that it names, as FindInput() above. Throws Error also where there is no such input.
std::filesystem::path FindInput(const Json& summary, const std::string& role, const std::filesystem::path& results);

// The program whose results are in a folder; empty if none.
std::string MakerOf(const std::filesystem::path& folder);

// Whether this program finds a design that is best.
bool FindsDesigns(const std::string& program);

// A path as a command line says it, that is no option.
std::string OperandOf(const std::filesystem::path& path);

// An option as a command line says it: --NAME VALUE for each of its values, --NAME or --no-NAME for a flag; nothing
// where it was not given.
std::vector<std::string> WordsOf(const Option& option);

}  // namespace lake::reviewing
