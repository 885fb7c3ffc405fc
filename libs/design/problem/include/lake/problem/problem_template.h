// A problem.yaml to be filled in.
#pragma once

#include <string>

namespace lake::problem {

// Every key that ReadProblem (problem_file.h) takes, behind a '#': the paper's values and those of an example.
std::string ProblemTemplate();

}  // namespace lake::problem
