// Where the programs lie, and what they read at run time.
#pragma once

#include <filesystem>
#include <string>

namespace lake::cohort {

// The folder of the running program.
std::filesystem::path ProgramFolder();

// A file of ../share/lake/cohort beside that folder. Throws Error if it is not there.
std::filesystem::path SharedFile(const std::string& name);

}  // namespace lake::cohort
