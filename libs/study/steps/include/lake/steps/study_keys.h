// Messages that name options, translated to keys of the study file.
#pragma once

#include <string>
#include <vector>

#include "lake/core/options.h"

namespace lake::steps {

// An option's key in a section of a study file.
struct StudyKey {
  std::string option;    // "seed"
  std::string key;       // "seeds"
  bool is_list = false;  // takes several values
};

std::vector<StudyKey> KeysOf(const OptionList& options);

// What a message's options are in a study file: ' (in the study file: seeds: ["knee=1,2"])' where it names --seed
// knee=1,2; the key alone where no value follows; empty where it names none of them.
std::string InStudyFile(const std::string& message, const std::vector<StudyKey>& keys);

}  // namespace lake::steps
