#include "problem_inputs.h"

namespace lake::commands {

void AddLoadFiles(const problem::SynthesisProblem& problem, std::vector<InputFile>& inputs) {
  if (problem.profile) inputs.push_back({problem.profile->file, "profile"});
  if (problem.actuator && !problem.actuator->file.empty()) inputs.push_back({problem.actuator->file, "actuator"});
}

}  // namespace lake::commands
