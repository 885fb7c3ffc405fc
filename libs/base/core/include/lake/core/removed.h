// What earlier versions had and this one has not: each gives one sentence with what to use instead.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace lake {

struct Removed {
  std::string_view program;  // "lake-stroke"
  std::string_view name;     // an option, "--board"; a command, "validate-bench"; or a choice, "sdf"
  std::string_view key;      // of the program's section in a study file; empty: it had none
  std::string_view instead;  // a clause
};
std::span<const Removed> AllRemoved();

// "--board is removed: …" of a word of that program's command line, an option also as --NAME=VALUE; empty if the
// program never had it.
std::string WhyRemoved(std::string_view program, std::string_view word);

}  // namespace lake
