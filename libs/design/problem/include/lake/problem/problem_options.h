// The options of a synthesis problem: on a command line, and as the keys of its file (problem_file.h).
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// The options that change a problem that was read from a file, or the paper's.
void Describe(SynthesisProblem& o, OptionList& options);

// A map of a problem's file, whose keys are those of options; without a name the file itself.
struct ProblemSection {
  std::string name;
  OptionList options;
};
// In the order in which they are read: what clearances are to comes before them.
std::vector<ProblemSection> SectionsOf(SynthesisProblem& o);

// --mount; `Field` is linkage::Mount or an optional one.
template <typename Field>
Option& DescribeMount(Field& mount, OptionList& options) {
  OptionList::Choices<linkage::Mount> choices;
  for (const linkage::Mount choice : {linkage::Mount::kBeside, linkage::Mount::kBehind})
    choices.emplace_back(linkage::NameOf(choice), choice);
  return options.AddChoice(
      "mount", mount, choices,
      "Where the linkage is on the leg: beside it neither the limbs nor a narrow seat are in its way");
}

// The options of the parts, as lake-simulate has them.
void DescribeParts(SynthesisProblem& o, OptionList& options);

// The options of the body that clearances are to.
void DescribeBody(SynthesisProblem& o, OptionList& options);

// The options of the load profile and of the actuator.
void DescribeLoad(SynthesisProblem& o, OptionList& options);

// An option's text with the file that it names, if it names one, in another place: a path, or an actuator's table.
std::string WithFile(const Option& option, const std::string& text,
                     const std::function<std::filesystem::path(const std::filesystem::path&)>& place);

// Throws UsageError where a body is given, but no clearance is asked for.
void CheckBody(const SynthesisProblem& problem);

// Throws UsageError where a clearance to the limbs is asked for, but the linkage is beside the leg.
void CheckMount(const SynthesisProblem& problem);

}  // namespace lake::problem
