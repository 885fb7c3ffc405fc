// What design.yaml carries of the problem that a design was found for.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/linkage/design_file.h"
#include "lake/problem/evaluate.h"

namespace lake::problem {

// These links at the problem's shortest stroke and mount.
linkage::Design DesignOf(const SynthesisProblem& problem, const linkage::Links& links);

// Range and longest stroke, as evaluated.
void TakeRange(const DesignEvaluation& evaluation, linkage::Design& design);

// Parts, body and load, where they differ from the paper's. `folder` is that of the design's file.
void TakeProblem(const SynthesisProblem& problem, const std::filesystem::path& folder, linkage::Design& design);

// Sets options to the texts that a design's file has under their keys (its parts, body or load). None is set where a
// file that one names is not there: returns that file. Throws Error with the design's file.
std::filesystem::path TakeFromDesign(const Json& texts, const std::filesystem::path& file, OptionList options);

}  // namespace lake::problem
