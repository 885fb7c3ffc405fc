// A design to be explored: from a design.yaml, or from a folder of lake-optimize or lake-simulate with its limits.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/review/design_page.h"

namespace lake::reviewing {

struct DesignSubject {
  review::ExploredDesign explored;
  std::filesystem::path folder;          // where other designs are saved
  std::vector<std::string> limit_words;  // arguments of lake-optimize for the same limits
  std::string no_command;                // why there is none; empty: there is one
};

// `problem_file` overrules the limits of a folder; empty: the folder's, else the paper's. A design.yaml that lies in a
// folder of lake-optimize has the folder's limits. Throws Error.
DesignSubject ReadDesignSubject(const std::filesystem::path& subject, const std::filesystem::path& problem_file);

// Saves as explored.yaml, explored-2.yaml, … in the folder; optimises by `programs`/lake-optimize into a folder below
// lake-out that is not there yet.
review::DesignWork DesignWorkOf(const DesignSubject& subject, const std::filesystem::path& programs);

}  // namespace lake::reviewing
