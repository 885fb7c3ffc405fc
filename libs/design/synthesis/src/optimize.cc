#include "lake/synthesis/optimize.h"

#include <Eigen/SVD>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <random>

#include "exchange.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"

namespace lake::synthesis {
namespace {

using Clock = std::chrono::steady_clock;

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
    Eigen::MatrixXd matrix(x_.size(), columns_.size());
    for (std::size_t i = 0; i < columns_.size(); ++i) matrix.col(i) = columns_[i].normalized();
    return Eigen::BDCSVD<Eigen::MatrixXd>(matrix).singularValues().tail(1)[0];
  }

 private:
  const nlp::NonlinearProgram& program_;
  const std::vector<double>& x_;
  std::map<int, Eigen::VectorXd> rows_;
  std::vector<Eigen::VectorXd> columns_;
};

bool IsActive(double value, double limit) {
  constexpr double kTouching = 1e-5;  // far above the interior point's distance to an active limit, mu / price
  return std::isfinite(limit) && std::abs(value - limit) <= kTouching * std::max(1.0, std::abs(limit));
}

std::vector<int> Basins(const std::vector<LocalSolve>& starts) {
  constexpr double kSameRange_deg = 0.01;
  std::vector<int> basin(starts.size(), -1);
  std::vector<double> ranges;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (!starts[i].IsUsable()) continue;
    const double range = starts[i].evaluation.range_deg;
    const auto known = std::find_if(ranges.begin(), ranges.end(),
                                    [&](double other) { return std::abs(other - range) < kSameRange_deg; });
    basin[i] = static_cast<int>(known - ranges.begin());
    if (known == ranges.end()) ranges.push_back(range);
  }
  return basin;
}

}  // namespace

void OptimizeOptions::Check() const {
  if (starts < 1 || starts > 100000) throw UsageError(fmt::format("--starts {}: 1 to 100000", starts));
  if (max_exchanges < 1) throw Fail("at least one exchange is needed, not {}", max_exchanges);
  if (!(family_tolerance > 0)) throw Fail("family_tolerance must be above 0, not {}", family_tolerance);
  nlp.Check();
}

LocalSolve SolveFrom(const problem::SynthesisProblem& problem, const linkage::Links& start,
                     const OptimizeOptions& options, const ProgramExtension& extension) {
  const auto begin = Clock::now();
  LocalSolve result;
  result.start = start;
  result.fractions = FirstFractions();
  nlp::NlpOptions nlp = options.nlp;
  linkage::Links from = start;
  while (true) {
    SynthesisProgram program = BuildProgram(problem, from, result.fractions, Elasticity::kNone, extension.range_weight);
    if (extension.extend) extension.extend(program, result.exchanges > 0 ? &result.solution : nullptr);
    ++result.exchanges;
    result.program = std::move(program);
    result.solution = nlp::SolveNlp(result.program.program, nlp);
    result.iterations += static_cast<int>(result.solution.iterations.size());
    result.history.insert(result.history.end(), result.solution.iterations.begin(), result.solution.iterations.end());
    result.end = result.program.LinksAt(result.solution.x);
    if (!result.solution.IsUsable() || result.exchanges >= options.max_exchanges ||
        !AddViolatedPoses(problem, result.end, options.family_tolerance, result.fractions))
      break;
    from = result.end;
    nlp.start_push = 1e-6, nlp.start_barrier = 1e-4;  // warm
  }
  result.evaluation = problem::Evaluate(result.end, problem);
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

namespace {

// Collects what is at its limit, with its price.
class ActiveSetFinder {
 public:
  explicit ActiveSetFinder(const LocalSolve& solve)
      : solve_(solve), nlp_(solve.program.program), rows_(nlp_.RowValues(solve.solution.x)), gradients_(solve) {}

  ActiveSet Find() {
    for (const LimitRow& limit : solve_.program.limits)
      if (limit.row >= 0) requirement_of_row_[limit.row] = &limit.requirement;
    for (std::size_t i = 0; i < rows_.size(); ++i) AddRow(static_cast<int>(i));
    for (std::size_t j = 0; j < solve_.solution.x.size(); ++j) AddVariable(static_cast<int>(j));
    active_.smallest_singular_value = gradients_.SmallestSingularValue();
    constexpr double kIndependent = 1e-6;
    active_.multipliers_unique = active_.smallest_singular_value > kIndependent;
    return std::move(active_);
  }

 private:
  // The cost is minus what is maximised.
  void AddRow(int index) {
    const nlp::NlpRow& row = nlp_.Rows()[index];
    const bool touches =
        row.lower == row.upper || IsActive(rows_[index], row.lower) || IsActive(rows_[index], row.upper);
    if (!touches) return;
    gradients_.AddRow(index);
    const double price = -solve_.solution.row_prices[index];
    for (const PublishedRow& published : solve_.program.published_rows)
      if (published.row == index)
        active_.entries.push_back({row.name, price * published.rows_per_unit, published.unit});
    const auto found = requirement_of_row_.find(index);
    if (found == requirement_of_row_.end()) return;
    constexpr double kNoPrice = 1e-7;
    const problem::Requirement& requirement = *found->second;
    if (requirement.IsFamily() && std::abs(price) < kNoPrice) return;
    active_.entries.push_back({requirement.Text(), price, requirement.unit});
  }

  void AddVariable(int index) {
    const nlp::NlpVariable& variable = nlp_.Variables()[index];
    const double value = solve_.solution.x[index];
    const bool lower = IsActive(value, variable.lower), upper = IsActive(value, variable.upper);
    if (!lower && !upper) return;
    gradients_.AddBound(index);
    const std::string unit = UnitOf(index);
    if (unit.empty()) return;
    active_.entries.push_back({fmt::format("{} {} {:.6g} {}", variable.name,
                                           lower && upper ? "="
                                           : lower        ? ">="
                                                          : "<=",
                                           lower ? variable.lower : variable.upper, unit),
                               -solve_.solution.variable_prices[index], unit});
  }

  // Of a variable whose bound is reported; empty for others.
  std::string UnitOf(int index) const {
    const LinkVariables& links = solve_.program.links;
    if (std::ranges::find(links, index) != links.end() || index == solve_.program.poses.front().stroke) return "mm";
    const auto published = std::ranges::find(solve_.program.published, index, &PublishedVariable::variable);
    return published == solve_.program.published.end() ? "" : published->unit;
  }

  const LocalSolve& solve_;
  const nlp::NonlinearProgram& nlp_;
  const std::vector<double> rows_;
  ActiveGradients gradients_;
  std::map<int, const problem::Requirement*> requirement_of_row_;
  ActiveSet active_;
};

}  // namespace

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

SynthesisResult Optimize(const problem::SynthesisProblem& problem, const OptimizeOptions& options) {
  problem.Check();
  options.Check();
  std::vector<linkage::Links> starts = RandomStarts(problem, options.starts - 1, options.seed);
  starts.insert(starts.begin(), problem.start);
  SynthesisResult result;
  Progress progress("optimise", "starts", options.starts, options.quiet);
  for (const linkage::Links& start : starts) {
    ThrowIfInterrupted();
    result.starts.push_back(SolveFrom(problem, start, options));
    const LocalSolve& solve = result.starts.back();
    constexpr double kBetter_deg = 1e-5;  // of equals the first is kept
    if (solve.IsUsable() &&
        (result.best < 0 || solve.evaluation.range_deg > result.Best().evaluation.range_deg + kBetter_deg))
      result.best = static_cast<int>(result.starts.size()) - 1;
    progress.Advance();
  }
  result.basin = Basins(result.starts);
  return result;
}

}  // namespace lake::synthesis
