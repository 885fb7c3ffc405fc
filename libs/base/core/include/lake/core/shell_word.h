// Command lines that can be run again.
#pragma once

#include <string>
#include <vector>

namespace lake {

// A word as sh takes it for one: in single quotes, unless no character of it means anything to a shell.
std::string ShellWord(const std::string& word);

// Words as a line that sh takes for the same words, the user's home folder written as ~ or "$HOME".
std::string CommandLine(const std::vector<std::string>& words);

}  // namespace lake
