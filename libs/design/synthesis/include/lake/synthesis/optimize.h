// Solves a synthesis problem from one or many starts.
//
// Requirements over the whole used range make it semi-infinite; they are met by collocation and exchange (Hettich &
// Kortanek, SIAM Review 35, 1993; Blankenship & Falk, JOTA 19, 1976): solve with a few poses, find the worst poses on a
// fine grid, add them, solve again until none is violated.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/problem/evaluate.h"
#include "lake/synthesis/multi_start.h"
#include "lake/synthesis/synthesis_program.h"

namespace lake::synthesis {

struct OptimizeOptions {
  int starts = 20;  // the problem's own start, then seeded random ones within the bounds
  std::uint64_t seed = 1;
  nlp::NlpOptions nlp;
  int max_exchanges = 25;
  double family_tolerance = 1e-7;  // a violation of a family, relative to its limit, that ends the exchange
  bool quiet = true;               // no progress

  void Check() const;  // throws Error
};

// One local solve, exchange included.
struct LocalSolve {
  linkage::Links start, end;
  nlp::NlpSolution solution;  // of the last program
  SynthesisProgram program;
  Collocation poses;  // collocated in the end
  int exchanges = 0;
  int iterations = 0;  // Ipopt's, over all exchanges
  std::vector<nlp::NlpIteration> history;
  problem::DesignEvaluation evaluation;  // of `end`, by the closed form
  double objective = 0;                  // what is maximised: the range, or the duration as a negative number

  // The multiplier of a limit, active or not: the change of the objective per unit by which the limit is raised, in
  // units of the cost. nullopt where the program has no such limit.
  std::optional<double> MultiplierOf(const LimitId& id) const;
  double MultiplierOf(const Limit& limit) const;
  // Solved, and feasible by the closed form within 1e-6.
  bool IsUsable() const { return solution.IsUsable() && evaluation.IsFeasible(); }
  std::optional<linkage::Links> UsableEnd() const { return IsUsable() ? std::optional(end) : std::nullopt; }
  // Drops program, poses and iterations, which are not needed of thousands of starts.
  void KeepOutcome();
};

// Builds the program of each exchange step.
class ProgramBuilder {
 public:
  virtual ~ProgramBuilder() = default;
  // With these poses besides the ends of the used range.
  virtual SynthesisProgram Build(const Collocation& poses) = 0;
  // The next program starts at x, where the last one ended.
  virtual void MoveTo(const std::vector<double>& x) = 0;
  virtual const linkage::Links& Links() const = 0;  // at which the next program starts
};

// The exchange step: which poses of the used range to add to the program.

// Poses to begin with: interior ones of the used range, as its ends are always there, and some samples of a load
// profile.
Collocation FirstPoses(const problem::SynthesisProblem& problem);

// Adds the local worst poses at which a family is violated by more than `tolerance` x its limit, or, if the linkage
// cannot go through its used range at all, poses half-way between those there are. False if there is nothing to add.
bool AddViolatedPoses(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                      const linkage::Links& links, double tolerance, Collocation& poses);

// Builds, solves and moves until no pose of the used range violates the problem.
LocalSolve SolveByExchange(const problem::SynthesisProblem& problem, ProgramBuilder& builder,
                           const OptimizeOptions& options);

LocalSolve SolveFrom(const problem::SynthesisProblem& problem, const linkage::Links& start,
                     const OptimizeOptions& options = {});

// Whether the multipliers of the solution are unique: iff the gradients of the active rows and bounds are linearly
// independent (LICQ).
struct ActiveSet {
  struct Entry {
    LimitId id;
    std::string name;   // "grashof ≥ 1 mm", "l3 ≥ 50 mm"
    double multiplier;  // LocalSolve::MultiplierOf
    std::string unit;   // of the limit
  };
  std::vector<Entry> entries;
  double smallest_singular_value = 0;  // of the active gradients, each scaled to length one
  bool multipliers_unique = false;

  const Entry* Find(const LimitId& id) const;  // nullptr where it is not active
};
ActiveSet FindActiveSet(const LocalSolve& solve);

struct SynthesisResult : MultiStart<LocalSolve> {
  std::vector<int> basin;  // of each start: the same number for the same range within 0.01 deg, or duration within 0.1
                           // %; -1 unusable
};

// Throws Error for a problem that fails its Check().
SynthesisResult Optimize(const problem::SynthesisProblem& problem, const OptimizeOptions& options = {});

// Uniform in the bounds; `count` of them, the same for the same seed.
std::vector<linkage::Links> RandomStarts(const problem::SynthesisProblem& problem, int count, std::uint64_t seed);

// Where a search starts: `given` links in turn, then random ones; `count` in all.
std::vector<linkage::Links> StartsOf(const problem::SynthesisProblem& problem, std::vector<linkage::Links> given,
                                     int count, std::uint64_t seed);

// A problem whose loads are those of its own optimum's rise. What the knee needs depends on the pace, the pace on the
// design (FindAssistance in problem/assistance.h), and the design on what the knee needs: a problem is solved again
// under the moments of the rise that was found, until they stay.
//
// Calls `solve`, which gives the links of a usable optimum or nothing, until the moments of `problem` are those of the
// rise that it found last, to 2e-6 of the duration, or 12 times; once where the profile does not say what pace adds
// to them. Where nothing is found at the pace given, the slowest rise is tried too. `problem` is left with the moments
// of the last call.
void SolveAtItsPace(problem::SynthesisProblem& problem,
                    const std::function<std::optional<linkage::Links>(const problem::SynthesisProblem&)>& solve);

}  // namespace lake::synthesis
