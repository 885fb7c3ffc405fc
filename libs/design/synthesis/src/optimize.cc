#include "lake/synthesis/optimize.h"

#include <lapacke.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/progress.h"
#include "lake/core/uncertain_text.h"
#include "lake/problem/assistance.h"

namespace lake::synthesis {
namespace {

bool IsActive(double value, double limit) {
  constexpr double kTouching = 1e-5;  // far above an interior point's distance to an active limit, mu / multiplier
  return std::isfinite(limit) && std::abs(value - limit) <= kTouching * std::max(1.0, std::abs(limit));
}

// Gradients of the rows and bounds that hold with equality, in columns scaled to length one.
class ActiveGradients {
 public:
  explicit ActiveGradients(const LocalSolve& solve) : program_(solve.program.program), x_(solve.solution.x) {
    for (const nlp::NlpTerm& term : program_.Terms()) {
      if (term.row == nlp::NlpTerm::kCost) continue;
      Eigen::VectorXd& gradient = rows_.try_emplace(term.row, Eigen::VectorXd::Zero(x_.size())).first->second;
      std::vector<double> local(term.term->Variables().size());
      term.term->Gradient(x_.data(), local.data());
      for (std::size_t k = 0; k < local.size(); ++k) gradient[term.term->Variables()[k]] += local[k];
    }
  }

  void AddRow(int row) { columns_.push_back(rows_.at(row)); }
  void AddBound(int variable) { columns_.push_back(Eigen::VectorXd::Unit(x_.size(), variable)); }

  double SmallestSingularValue() const {
    if (columns_.empty()) return 1;
    if (columns_.size() > x_.size()) return 0;
    const auto rows = static_cast<lapack_int>(x_.size()), columns = static_cast<lapack_int>(columns_.size());
    Eigen::MatrixXd matrix(rows, columns);
    for (lapack_int i = 0; i < columns; ++i) matrix.col(i) = columns_[i].normalized();
    Eigen::VectorXd singular(columns), unused(1);
    const lapack_int failed = LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'N', rows, columns, matrix.data(), rows, singular.data(),
                                             unused.data(), 1, unused.data(), 1);
    return failed ? 0 : singular.tail<1>()[0];
  }

 private:
  const nlp::NonlinearProgram& program_;
  const std::vector<double>& x_;
  std::map<int, Eigen::VectorXd> rows_;
  std::vector<Eigen::VectorXd> columns_;
};

std::vector<int> Basins(const problem::SynthesisProblem& problem, const std::vector<LocalSolve>& starts) {
  constexpr double kSameRange_deg = 0.01, kSameDuration = 1e-3;
  std::vector<int> basin(starts.size(), -1);
  std::vector<double> goals;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (!starts[i].IsUsable()) continue;
    const double goal = starts[i].objective;
    const double same =
        problem.goal == problem::SynthesisProblem::Goal::kRange ? kSameRange_deg : kSameDuration * std::abs(goal);
    const auto known =
        std::find_if(goals.begin(), goals.end(), [&](double other) { return std::abs(other - goal) < same; });
    basin[i] = static_cast<int>(known - goals.begin());
    if (known == goals.end()) goals.push_back(goal);
  }
  return basin;
}

}  // namespace

void OptimizeOptions::Check() const {
  if (starts < 1 || starts > 100000) throw UsageError("--starts {}: 1 to 100000", starts);
  if (max_exchanges < 1) throw Fail("at least one exchange is needed, not {}", max_exchanges);
  if (!(family_tolerance > 0)) throw Fail("family_tolerance must be above 0, not {}", family_tolerance);
  nlp.Check();
}

double LocalSolve::MultiplierOf(const Limit& limit) const {
  const double marginal_cost =
      limit.row >= 0 ? solution.row_marginal_costs[limit.row] : solution.variable_marginal_costs[limit.variable];
  return -marginal_cost * limit.scale;
}

void LocalSolve::KeepOutcome() {
  program = {};
  poses = {};
  history = {};
  solution.iterations = {};
}

std::optional<double> LocalSolve::MultiplierOf(const LimitId& id) const {
  const Limit* limit = program.Find(id);
  return limit ? std::optional(MultiplierOf(*limit)) : std::nullopt;
}

Collocation FirstPoses(const problem::SynthesisProblem& problem) {
  Collocation poses{0.25, 0.5, 0.75};
  if (!problem.HasLoadProfile()) return poses;
  constexpr std::size_t kSteps = 8;
  const std::vector<int> samples = problem::SamplesInUse(problem);
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const int sample = samples[i * (samples.size() - 1) / kSteps];
    if (poses.samples.empty() || poses.samples.back() != sample) poses.samples.push_back(sample);
  }
  return poses;
}

namespace {

// A pose between each two neighbours, both ends of the used range included.
void HalveGaps(std::vector<double>& fractions) {
  std::vector<double> all = fractions;
  all.push_back(0);
  all.push_back(1);
  std::sort(all.begin(), all.end());
  for (std::size_t i = 1; i < all.size(); ++i) fractions.push_back((all[i - 1] + all[i]) / 2);
}

constexpr std::size_t kMostPoses = 200;

bool IsKnown(const problem::WorstPoint& point, const Collocation& poses) {
  constexpr double kSamePose = 1e-6;
  if (point.sample >= 0) return std::ranges::find(poses.samples, point.sample) != poses.samples.end();
  return point.fraction < kSamePose || point.fraction > 1 - kSamePose ||
         std::ranges::any_of(poses.fractions,
                             [&](double known) { return std::abs(known - point.fraction) < kSamePose; });
}

// The poses at which one linkage violates the problem; false where it turns back or comes apart between two poses.
bool AddPosesOf(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                const linkage::Links& links, double tolerance, Collocation& poses) {
  problem::UsedPoses used(links, problem);
  for (const problem::Requirement& requirement : requirements) {
    if (!requirement.NeedsStanding()) continue;
    if (!used.Range()) return false;
    if (!requirement.IsFamily()) continue;
    const std::vector<problem::WorstPoint> worst = used.WorstPoints(requirement);
    if (worst.empty()) return false;
    if (requirement.Info().place == problem::Place::kSeated) continue;  // one pose, which the program has already
    for (const problem::WorstPoint& point : worst) {
      const double allowed = tolerance * std::max(requirement.limit, requirement.IsClearance() ? 1.0 : 0.0);
      if (requirement.Slack(point.value) >= -allowed || IsKnown(point, poses)) continue;
      if (point.sample >= 0)
        poses.samples.push_back(point.sample);
      else
        poses.fractions.push_back(point.fraction);
    }
  }
  return true;
}

// The corner of the tolerance that violates the problem most, or else the one whose goal is less than that of all
// builds known.
bool AddWorstBuild(const problem::SynthesisProblem& problem, const linkage::Links& links, double tolerance,
                   Collocation& poses) {
  constexpr double kWorse_deg = 1e-6;
  const problem::BuildError *worst = nullptr, *least = nullptr;
  double worst_violation = 10 * tolerance, known_deg = std::numeric_limits<double>::infinity(), least_deg = known_deg;
  const std::vector<problem::BuildError> corners = problem::Corners(problem.robust_mm);
  for (const problem::BuildError& corner : corners) {
    const problem::DesignEvaluation build =
        problem::Evaluate(problem::LinksOf(corner, links), problem::ProblemOf(corner, problem));
    const double range_deg = build.pose ? build.range_deg : -std::numeric_limits<double>::infinity();
    if (std::ranges::find(poses.builds, corner) != poses.builds.end()) {
      known_deg = std::min(known_deg, range_deg);
      continue;
    }
    if (build.violation > worst_violation) {
      worst_violation = build.violation;
      worst = &corner;
    }
    if (range_deg < least_deg) {
      least_deg = range_deg;
      least = &corner;
    }
  }
  if (!worst && least && least_deg < known_deg - kWorse_deg) worst = least;
  if (worst) poses.builds.push_back(*worst);
  return worst;
}

}  // namespace

bool AddViolatedPoses(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                      const linkage::Links& links, double tolerance, Collocation& poses) {
  const std::size_t before = poses.Size();
  bool stand = AddPosesOf(problem, requirements, links, tolerance, poses);
  for (std::size_t i = 0; i < poses.builds.size(); ++i)
    stand = AddPosesOf(problem::ProblemOf(poses.builds[i], problem), requirements,
                       problem::LinksOf(poses.builds[i], links), tolerance, poses) &&
            stand;
  if (!stand && before < kMostPoses) HalveGaps(poses.fractions);
  return poses.Size() > before || AddWorstBuild(problem, links, tolerance, poses);
}

namespace {

// With the placement that was found, and held against the duration, where that is what is sought.
problem::SynthesisProblem AsSolved(const problem::SynthesisProblem& problem, const LocalSolve& solve) {
  problem::SynthesisProblem solved = Placed(problem, solve.program, solve.solution.x);
  if (problem.goal != problem::SynthesisProblem::Goal::kDuration) return solved;
  for (const RequirementRow& entry : solve.program.requirements)
    if (entry.requirement.is_sought) solved.duration_s = solve.solution.x[entry.family_limit];
  return solved;
}

bool AddPosesOf(const problem::SynthesisProblem& solved, LocalSolve& result, const OptimizeOptions& options) {
  return AddViolatedPoses(solved, problem::RequirementsOf(solved), result.end, options.family_tolerance, result.poses);
}

}  // namespace

LocalSolve SolveByExchange(const problem::SynthesisProblem& problem, ProgramBuilder& builder,
                           const OptimizeOptions& options) {
  LocalSolve result;
  result.start = builder.Links();
  result.poses = FirstPoses(problem);
  nlp::NlpOptions nlp = options.nlp;
  while (true) {
    result.program = builder.Build(result.poses);
    ++result.exchanges;
    result.solution = nlp::SolveNlp(result.program.program, nlp);
    result.iterations += static_cast<int>(result.solution.iterations.size());
    result.history.insert(result.history.end(), result.solution.iterations.begin(), result.solution.iterations.end());
    builder.MoveTo(result.solution.x);
    result.end = builder.Links();
    if (!result.solution.IsUsable() || result.exchanges >= options.max_exchanges ||
        !AddPosesOf(AsSolved(problem, result), result, options))
      break;
    nlp.StartWarm();
  }
  result.evaluation = problem::Evaluate(result.end, Placed(problem, result.program, result.solution.x));
  result.objective = problem::GoalOf(problem, result.evaluation);
  return result;
}

namespace {

// The synthesis problem's own program, from links.
class LinkProgramBuilder : public ProgramBuilder {
 public:
  LinkProgramBuilder(const problem::SynthesisProblem& problem, const linkage::Links& start)
      : problem_(problem), links_(start) {}

  SynthesisProgram Build(const Collocation& poses) override {
    SynthesisProgram program = BuildProgram(problem_, links_, poses);
    variables_ = program.links;
    return program;
  }
  void MoveTo(const std::vector<double>& x) override { links_ = LinksAt(variables_, x); }
  const linkage::Links& Links() const override { return links_; }

 private:
  const problem::SynthesisProblem& problem_;
  linkage::Links links_;
  LinkVariables variables_{};
};

// Collects what is at its limit, with its multiplier.
class ActiveSetFinder {
 public:
  explicit ActiveSetFinder(const LocalSolve& solve)
      : solve_(solve), nlp_(solve.program.program), rows_(nlp_.RowValues(solve.solution.x)), gradients_(solve) {}

  ActiveSet Find() {
    for (const Limit& limit : solve_.program.limits)
      if (limit.row >= 0)
        limit_of_row_[limit.row] = &limit;
      else
        limit_of_variable_[limit.variable] = &limit;
    for (std::size_t i = 0; i < rows_.size(); ++i) AddRow(static_cast<int>(i));
    for (std::size_t j = 0; j < solve_.solution.x.size(); ++j) AddVariable(static_cast<int>(j));
    active_.smallest_singular_value = gradients_.SmallestSingularValue();
    constexpr double kIndependent = 1e-6;
    active_.multipliers_unique = active_.smallest_singular_value > kIndependent;
    return std::move(active_);
  }

 private:
  void AddRow(int index) {
    const nlp::NlpRow& row = nlp_.Rows()[index];
    const bool is_equality = row.lower == row.upper;
    if (!is_equality && !IsActive(rows_[index], row.lower) && !IsActive(rows_[index], row.upper)) return;
    gradients_.AddRow(index);
    const auto found = limit_of_row_.find(index);
    if (found == limit_of_row_.end()) return;
    // The limit of a family is an equality, which holds whether a pose is at it or not.
    constexpr double kNoMultiplier = 1e-7;
    const double multiplier = solve_.MultiplierOf(*found->second);
    if (is_equality && std::abs(multiplier) < kNoMultiplier) return;
    active_.entries.push_back({found->second->id, row.name, multiplier, found->second->unit});
  }

  void AddVariable(int index) {
    const nlp::NlpVariable& variable = nlp_.Variables()[index];
    const double value = solve_.solution.x[index];
    const bool lower = IsActive(value, variable.lower), upper = IsActive(value, variable.upper);
    if (!lower && !upper) return;
    gradients_.AddBound(index);
    const auto found = limit_of_variable_.find(index);
    if (found == limit_of_variable_.end()) return;
    const Limit& limit = *found->second;
    const char* sign = lower && upper ? "=" : lower ? "≥" : "≤";
    const std::string name = fmt::format("{} {} {} {}", variable.name, sign,
                                         SignificantText(lower ? variable.lower : variable.upper, 6), limit.unit);
    active_.entries.push_back({limit.id, name, solve_.MultiplierOf(limit), limit.unit});
  }

  const LocalSolve& solve_;
  const nlp::NonlinearProgram& nlp_;
  const std::vector<double> rows_;
  ActiveGradients gradients_;
  std::map<int, const Limit*> limit_of_row_, limit_of_variable_;
  ActiveSet active_;
};

}  // namespace

LocalSolve SolveFrom(const problem::SynthesisProblem& problem, const linkage::Links& start,
                     const OptimizeOptions& options) {
  LinkProgramBuilder builder(problem, start);
  return SolveByExchange(problem, builder, options);
}

const ActiveSet::Entry* ActiveSet::Find(const LimitId& id) const {
  const auto found = std::ranges::find(entries, id, &Entry::id);
  return found == entries.end() ? nullptr : &*found;
}

ActiveSet FindActiveSet(const LocalSolve& solve) {
  return ActiveSetFinder(solve).Find();
}

std::vector<linkage::Links> RandomStarts(const problem::SynthesisProblem& problem, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<linkage::Links> starts;
  for (int i = 0; i < count; ++i) {
    std::array<double, 6> values{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double unit = static_cast<double>(random() >> 11) * 0x1p-53;  // the same on every platform
      values[k] = std::lerp(problem.bounds[k].lower, problem.bounds[k].upper, unit);
    }
    starts.push_back(linkage::Links::FromValues(values));
  }
  return starts;
}

std::vector<linkage::Links> StartsOf(const problem::SynthesisProblem& problem, std::vector<linkage::Links> given,
                                     int count, std::uint64_t seed) {
  std::vector<linkage::Links> starts = std::move(given);
  const int random = std::max(0, count - static_cast<int>(starts.size()));
  for (const linkage::Links& start : RandomStarts(problem, random, seed)) starts.push_back(start);
  starts.resize(static_cast<std::size_t>(count));
  return starts;
}

SynthesisResult Optimize(const problem::SynthesisProblem& problem, const OptimizeOptions& options) {
  problem.Check();
  options.Check();
  Progress progress("optimise", "starts", options.starts, options.quiet);
  MultiStart<LocalSolve> search = SolveFromEach(
      StartsOf(problem, {problem.start}, options.starts, options.seed),
      [&](const linkage::Links& start) { return SolveFrom(problem, start, options); }, Until::kLastStart, &progress);
  SynthesisResult result{std::move(search), {}};
  result.basin = Basins(problem, result.starts);
  return result;
}

void SolveAtItsPace(problem::SynthesisProblem& problem,
                    const std::function<std::optional<linkage::Links>(const problem::SynthesisProblem&)>& solve) {
  constexpr int kMostRounds = 12;
  constexpr double kSame = 2e-6;
  const bool has_pace = problem.HasLoadProfile() && problem.profile->HasPace();
  const auto take = [&](double duration_s) { problem.profile = problem::AtPace(*problem.profile, duration_s); };
  if (has_pace && problem.duration_s) take(*problem.duration_s);
  std::optional<linkage::Links> links = solve(problem);
  if (!has_pace || problem.duration_s) return;
  if (!links) {
    const double given_s = problem.profile->moments_s;
    take(problem::SynthesisProblem::kLongestDuration_s);
    links = solve(problem);
    if (!links) {
      take(given_s);
      solve(problem);
      return;
    }
  }
  for (int round = 1; links && round < kMostRounds; ++round) {
    const double shortest_s = problem::DurationUnderMoments(*links, problem);
    const double duration_s = std::isfinite(shortest_s) && shortest_s > 0 ? shortest_s : problem.profile->duration_s;
    if (std::abs(duration_s / problem.profile->moments_s - 1) < kSame) return;
    take(duration_s);
    links = solve(problem);
  }
}

}  // namespace lake::synthesis
