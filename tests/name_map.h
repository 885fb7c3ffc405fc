// The marker names of a trial, as --map takes them.
#pragma once

#include <algorithm>
#include <map>
#include <string>

#include "lake/exchange/trial.h"

namespace lake {

// "ankle=RANK,knee=RKNE" through the option itself. Throws UsageError.
inline std::map<std::string, std::string> NameMap(const std::string& text) {
  exchange::TrialOptions options;
  OptionList list = OptionsOf(options);
  std::find_if(list.All().begin(), list.All().end(), [](const Option& option) {
    return option.Name() == "map";
  })->SetFromCommandLine({text});
  return options.names;
}

}  // namespace lake
