#include <cmath>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/synthesis/infeasibility.h"

namespace lake::redesign {
namespace {

using Kind = linkage::StrokeProgram::Kind;
using synthesis::RoundedUp;

// A limit a little on the safe side of the best value found; of a margin to tenths of a mm.
double SafeLimit(double best, const Quantity& quantity) {
  return quantity.is_lower ? std::floor(0.999 * 10 * best) / 10 : RoundedUp(best);
}

std::string WithUnit(double value, const Quantity& quantity) {
  return fmt::format("{} {}", SignificantText(value, 4), quantity.unit);
}

// "the free program of 20 s at 5 mm/s"
std::string ProgramText(const ProgramLimits& program) {
  std::string text = fmt::format("the {} program", ProgramName(program.kind));
  if (program.duration_s) text += fmt::format(" of {} s", SignificantText(*program.duration_s, 4));
  return text + fmt::format(" at {} mm/s", SignificantText(program.max_speed_mm_s, 4));
}

class Explainer {
 public:
  Explainer(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
            const synthesis::OptimizeOptions& options)
      : problem_(problem), links_(links), options_(options) {}

  Infeasibility Explain() {
    if (ExplainStride()) return std::move(report_);
    if (const auto least = Best(kMisalignment, problem_)) {
      if (Explain(kMisalignment, *least, problem_)) return std::move(report_);
      report_.nearest = least->Point();
      report_.within_reach = true;
      report_.sentence = "the limits can be held, but the solver did not reach an optimum; ask for more --starts";
      return std::move(report_);
    }
    // Each with those before it, however far the path is off.
    RedesignProblem within = problem_;
    for (const Quantity* quantity : {&kMisalignment, &kAngleMismatch, &kCuffForce, &kBalanceMargin})
      quantity->limit(within).reset();
    for (const Quantity* quantity : {&kAngleMismatch, &kCuffForce, &kBalanceMargin}) {
      quantity->limit(within) = quantity->limit(problem_);
      if (!quantity->limit(problem_)) continue;
      if (const auto best = Best(*quantity, within); best && Explain(*quantity, *best, within))
        return std::move(report_);
    }
    ExplainWithoutMotion();
    return std::move(report_);
  }

 private:
  // The design with the best value of a quantity, which then has no limit.
  std::optional<RedesignSolve> Best(const Quantity& quantity, RedesignProblem problem) const {
    problem.goal = quantity.goal;
    if (&quantity != &kBalanceMargin) quantity.limit(problem).reset();
    return FindOptimum(problem, links_, options_);
  }

  // Does a run of this problem find a design?
  bool CanBeSolved(const RedesignProblem& problem) const {
    if (HasSolution(problem, links_, options_)) return true;
    const auto least = Best(kMisalignment, problem);
    return least && SolveFrom(problem, least->Point(), options_, true).IsUsable();
  }

  // A rounded limit, from the best value on, with which the problem can be solved.
  std::optional<double> Working(const Quantity& quantity, double best, RedesignProblem problem) const {
    constexpr int kTries = 4;
    constexpr double kStep = 0.005;
    if (!(best > 0)) return std::nullopt;
    double limit = SafeLimit(best, quantity);
    for (int i = 0; i < kTries; ++i) {
      quantity.limit(problem) = limit;
      if (CanBeSolved(problem)) return limit;
      limit = SafeLimit(limit * (quantity.is_lower ? 1 - kStep : 1 + kStep), quantity);
    }
    return std::nullopt;
  }
  std::optional<double> Working(const Quantity& quantity, const RedesignProblem& problem) const {
    const auto best = Best(quantity, problem);
    return best ? Working(quantity, quantity.value(*best->Predicted()), problem) : std::nullopt;
  }

  // Of walking: no linkage follows the knee in the time, however far the joint is off.
  bool ExplainStride() {
    if (!problem_.program.cyclic || !problem_.program.duration_s) return false;
    RedesignProblem within = problem_;
    for (const Quantity* quantity : {&kMisalignment, &kCuffForce}) quantity->limit(within).reset();
    const auto quickest = Best(kDuration, within);
    if (!quickest) return false;
    const double needed_s = kDuration.value(*quickest->Predicted()), stride_s = *problem_.program.duration_s,
                 speed_mm_s = problem_.program.max_speed_mm_s;
    if (needed_s <= stride_s) return false;
    report_.nearest = quickest->Point();
    report_.ways.push_back(
        {fmt::format("strides of {} s", SignificantText(RoundedUp(needed_s), 3)), true, {}, needed_s});
    report_.sentence = fmt::format(
        "no program follows this walk: within {}° of the knee's angle the quickest linkage takes {} s for a stride at "
        "{} mm/s, and it may take {} s; {} mm/s would follow it, or {} mm/s at {} % of the walking speed (--duration "
        "{})",
        SignificantText(*problem_.max_angle_mismatch_deg, 3), SignificantText(needed_s, 3),
        SignificantText(speed_mm_s, 4), SignificantText(stride_s, 3),
        SignificantText(RoundedUp(speed_mm_s * needed_s / stride_s), 3), SignificantText(speed_mm_s, 4),
        SignificantText(100 * stride_s / needed_s, 2), SignificantText(RoundedUp(needed_s), 3));
    return true;
  }

  // The synthesis problem itself, or the time of the motion, has no solution.
  void ExplainWithoutMotion() {
    const synthesis::InfeasibilityReport design = synthesis::AnalyseInfeasibility(problem_.design, options_);
    report_.nearest = StartPoint(problem_, design.links);
    report_.sentence = design.sentence;
    if (!design.solved || !design.relaxations.empty()) return;
    std::optional<double> needed_s = Working(kDuration, problem_);
    if (!needed_s) {  // the limit on misalignment needs more than time
      RedesignProblem unlimited = problem_;
      unlimited.max_misalignment_percent.reset();
      needed_s = Working(kDuration, unlimited);
    }
    if (needed_s && problem_.program.duration_s) {
      report_.ways.push_back({fmt::format("a duration of {} s", SignificantText(*needed_s, 4)), true, {}, needed_s});
      report_.sentence =
          fmt::format("no design stands up within {} s at {} mm/s: {} s are enough",
                      SignificantText(*problem_.program.duration_s, 4),
                      SignificantText(problem_.program.max_speed_mm_s, 4), SignificantText(*needed_s, 4));
    } else {
      report_.sentence = "no design was found that can make the human's motion; ask for more --starts or wider bounds";
    }
  }

  // Whether the best value of a quantity, under the limits of `within`, is beyond its limit: then it is what cannot be
  // held, with what holds it there and what would free it.
  bool Explain(const Quantity& quantity, const RedesignSolve& best, const RedesignProblem& within) {
    const std::optional<double> limit = quantity.limit(problem_);
    const double value = quantity.value(*best.Predicted());
    if (!limit || quantity.Holds(value, *limit)) return false;
    report_.quantity = &quantity;
    report_.best = value;
    report_.nearest = best.Point();
    CollectBlocking(best);
    report_.working = Working(quantity, value, within);
    TryPlacement(within);
    TryDuration(within);
    TryReversing(within);
    TryWithoutBalance(within);
    TryCuffs(within);
    report_.sentence = Sentence(*limit, *best.Predicted());
    return true;
  }

  bool Is(const Quantity& quantity) const { return report_.quantity == &quantity; }

  void CollectBlocking(const RedesignSolve& best) {
    constexpr double kNoMultiplier = 1e-4;  // per mm, deg or s
    // d RMS = d (mean square) / (2 RMS).
    const double scale = Is(kMisalignment) ? 1 / (2 * *report_.best) : 1;
    const synthesis::ActiveSet active = synthesis::FindActiveSet(best.local);
    for (synthesis::ActiveSet::Entry entry : active.entries) {
      entry.multiplier *= scale;
      if (std::abs(entry.multiplier) < kNoMultiplier) continue;
      if (!active.multipliers_unique) entry.multiplier = kNaN;
      report_.blocking.push_back(entry);
    }
  }

  // A change, and the best value that it allows.
  void Try(const std::string& text, RedesignProblem other) {
    const Quantity& quantity = *report_.quantity;
    const auto best = Best(quantity, other);
    if (!best) return;
    quantity.limit(other) = quantity.limit(problem_);
    const bool enough = SolveFrom(other, best->Point(), options_, true).IsUsable();
    report_.ways.push_back({text, enough, quantity.value(*best->Predicted()), {}});
  }

  void TryPlacement(RedesignProblem other) {
    if (!Is(kMisalignment) && !Is(kCuffForce)) return;
    if (!other.fit_placement) {
      other.fit_placement = true;
      Try(fmt::format("fitting the placement within {} mm (--fit-placement)",
                      SignificantText(other.placement_reach_mm, 4)),
          other);
    } else if (Is(kCuffForce)) {
      other.placement_reach_mm *= 2;
      Try("a joint that may be moved twice as far (--placement-reach)", other);
    }
  }

  void TryDuration(RedesignProblem other) {
    if (!Is(kMisalignment) && !Is(kAngleMismatch)) return;
    other.program.kind = Kind::kFree;
    report_.quantity->limit(other) = report_.quantity->limit(problem_);
    const auto needed_s = Working(kDuration, other);
    if (!needed_s) return;
    const double speed = problem_.program.max_speed_mm_s;
    std::string text =
        fmt::format("{} of at least {} s at {} mm/s",
                    problem_.program.kind == Kind::kFree ? "a duration" : "a free program (--program free)",
                    SignificantText(*needed_s, 4), SignificantText(speed, 4));
    if (problem_.program.duration_s)
      text += fmt::format(", or {} mm/s in {} s",
                          SignificantText(RoundedUp(speed * *needed_s / *problem_.program.duration_s), 4),
                          SignificantText(*problem_.program.duration_s, 4));
    report_.ways.push_back({text, true, {}, needed_s});
  }

  void TryReversing(RedesignProblem other) {
    if (Is(kBalanceMargin) || !other.program.monotone || other.program.kind != Kind::kFree) return;
    other.program.monotone = false;
    Try("a program that may turn back (without --monotone)", other);
  }

  void TryWithoutBalance(RedesignProblem other) {
    if (Is(kBalanceMargin) || !other.balance_mm) return;
    other.balance_mm.reset();
    Try("a person out of balance, whom something holds (without --balance)", other);
  }

  void TryCuffs(const RedesignProblem& within) {
    if (!Is(kMisalignment) || !within.max_cuff_force_n) return;
    if (const auto working_n = Working(kCuffForce, within))
      report_.ways.push_back(
          {fmt::format("a limit of {} N at the cuffs (--max-cuff-force)", SignificantText(*working_n, 4)), true});
  }

  // Where the best that was found is, and what no limit says.
  std::string WhereText(const Prediction& best) const {
    if (!Is(kBalanceMargin)) return "";
    return fmt::format(
        "{}, at {:.0f} % of the rise, leaning the trunk by up to {:.0f}° and the leg by up to {:.0f}° more than the "
        "person did; a seat that is higher or feet drawn back bring the body over the foot, or something must hold the "
        "person",
        best.balance->margin_mm < 0 ? ", outside it" : "", best.balance->at_percent, problem_.lean_limits.trunk_deg,
        problem_.lean_limits.leg_deg);
  }

  std::string Sentence(double limit, const Prediction& best) const {
    const Quantity& quantity = *report_.quantity;
    std::string text =
        fmt::format(fmt::runtime(quantity.none), SignificantText(limit, 4)) +
        fmt::format(" (--{}): the {} found with {} is {}{}", quantity.option, quantity.is_lower ? "most" : "least",
                    ProgramText(problem_.program), WithUnit(*report_.best, quantity), WhereText(best));
    if (report_.working) text += fmt::format(" (a limit of {} can be held)", WithUnit(*report_.working, quantity));
    std::vector<std::string> names, enough, too_little;
    if (problem_.program.kind != Kind::kFree) names.emplace_back("the constant program");
    for (const synthesis::ActiveSet::Entry& entry : report_.blocking) names.push_back(entry.name);
    if (!names.empty()) text += fmt::format(", held there by {}", fmt::join(names, ", "));
    for (const WayOut& way : report_.ways)
      if (way.enough)
        enough.push_back(way.text);
      else
        too_little.push_back(fmt::format("{} reaches {}", way.text, WithUnit(*way.best, quantity)));
    if (!enough.empty()) text += fmt::format("; what would free it: {}", fmt::join(enough, "; or "));
    if (!too_little.empty()) text += fmt::format("; not enough: {}", fmt::join(too_little, ", "));
    return text;
  }

  const RedesignProblem& problem_;
  const std::vector<linkage::Links>& links_;
  const synthesis::OptimizeOptions& options_;
  Infeasibility report_;
};

}  // namespace

Infeasibility ExplainInfeasible(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                                const synthesis::OptimizeOptions& options) {
  return Explainer(problem, links, options).Explain();
}

}  // namespace lake::redesign
