// A proof that no design is better: a rigorous upper bound on theta(X, d_min) over all X that satisfy the problem, by
// best-first branch and bound in interval arithmetic. What is not used of a problem is named by NotInBound(): the bound
// holds with it too, though it may then not be tight. The room's README has the mathematics.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/threads.h"
#include "lake/problem/problem.h"

namespace lake::certificate {

struct CertificateOptions {
  double gap_deg = 0.1;            // stop once bound - range is no larger
  std::int64_t max_boxes = 50000;  // examined at most; up to a minute on one core
  std::optional<double> time_s{};  // ends the search earlier; the outcome then depends on the machine
  int threads = Threads();         // the result is the same for any number
  bool quiet = true;               // no progress

  void Check() const;  // throws Error
};

struct Certificate {
  enum class End { kGap, kBoxes, kTime, kNothingToSplit };
  double upper_bound_deg = 0;         // rigorous, however the search ended
  std::optional<double> range_deg{};  // the known one
  double gap_deg = 0;                 // upper bound - range; NaN if no range is known
  bool reached = false;               // gap <= the one asked for
  End end = End::kGap;                // what ended the search
  std::int64_t boxes = 0;             // examined, the whole one included
  bool feasible_set_empty = false;    // proved: no X satisfies the constraints at all; the bound is then -infinity
};

// Whether the bound takes a requirement into account, at some poses at least.
bool IsInBound(const problem::Requirement& requirement, const problem::SynthesisProblem& problem);
// The names of the requirements that the bound does without, and of the tolerance.
std::vector<std::string> NotInBound(const problem::SynthesisProblem& problem);

// How far a known range may lie above a bound, deg: its design keeps the limits within what a solver leaves, 1e-6 mm,
// and a limit costs less than 1000 deg per mm.
inline constexpr double kKnownRangeTolerance_deg = 1e-3;

// `range_deg`: the best range known, of a design that satisfies the problem. It decides when to stop (without one, when
// the boxes are used up), and boxes are cleared of what has less. Throws Error if nothing is left that has as much: one
// of the two is wrong; Interrupted on a signal.
Certificate CertifyRange(const problem::SynthesisProblem& problem, std::optional<double> range_deg,
                         const CertificateOptions& options = {});

}  // namespace lake::certificate
