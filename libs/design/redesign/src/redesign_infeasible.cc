#include <cmath>
#include <limits>

#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/synthesis/infeasibility.h"

namespace lake::redesign {
namespace {

using Goal = RedesignProblem::Goal;
using Kind = linkage::StrokeProgram::Kind;

// Three significant digits, upwards: what a message proposes, with room for the solver.
double RoundedUp(double value) {
  constexpr double kRoom = 1.001;
  const double digit = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::ceil(kRoom * value / digit) * digit;
}

class Explainer {
 public:
  Explainer(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
            const synthesis::OptimizeOptions& options)
      : problem_(problem), links_(links), options_(options) {}

  MisalignmentInfeasibility Explain() {
    if (ExplainPace()) return std::move(report_);
    const std::optional<RedesignSolve> least = Least(problem_);
    if (!least) {
      if (!ExplainAngle() && !ExplainCuffs() && !ExplainBalance()) ExplainWithoutMisalignment();
      return std::move(report_);
    }
    report_.nearest = least->point;
    report_.least_percent = least->Misalignment_percent();
    constexpr double kHolds = 1 + 1e-5;
    if (!problem_.max_misalignment_percent || *report_.least_percent <= *problem_.max_misalignment_percent * kHolds) {
      report_.within_reach = true;
      report_.sentence = "the limits can be held, but the solver did not reach an optimum; ask for more --starts";
      return std::move(report_);
    }
    CollectBlocking(*least);
    report_.working_percent = Working(*report_.least_percent, problem_,
                                      [](RedesignProblem& p, double value) { p.max_misalignment_percent = value; });
    TryPlacement();
    TryDuration();
    TryReversing();
    TryWithoutBalance();
    TryCuffs();
    report_.sentence = Sentence();
    return std::move(report_);
  }

 private:
  std::optional<RedesignSolve> Least(RedesignProblem problem) const {
    problem.goal = Goal::kMisalignment;
    problem.max_misalignment_percent.reset();
    return FindOptimum(problem, links_, options_);
  }

  // The shortest sit-to-stand that holds the limit on misalignment, if the problem has one.
  std::optional<double> LeastDuration(RedesignProblem problem) const {
    problem.goal = Goal::kDuration;
    problem.program.duration_s.reset();
    const auto shortest = FindOptimum(problem, links_, options_);
    if (!shortest) return std::nullopt;
    return DurationOf(problem, shortest->point);
  }

  // Of walking: no linkage follows the knee in the time, however far the joint is off.
  bool ExplainPace() {
    if (!problem_.program.cyclic || !problem_.program.duration_s) return false;
    RedesignProblem problem = WithGoal(problem_, Goal::kDuration);
    problem.max_cuff_force_n.reset();
    problem.program.duration_s.reset();
    const auto quickest = FindOptimum(problem, links_, options_);
    if (!quickest) return false;
    const double needed_s = DurationOf(problem, quickest->point), stride_s = *problem_.program.duration_s,
                 speed_mm_s = problem_.program.max_speed_mm_s;
    if (needed_s <= stride_s) return false;
    report_.nearest = quickest->point;
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

  // The knee angle's limit cannot be held, however far the joint is off.
  bool ExplainAngle() {
    if (!problem_.max_angle_mismatch_deg) return false;
    RedesignProblem problem = WithGoal(problem_, Goal::kAngle);
    problem.balance.reset();
    problem.max_cuff_force_n.reset();
    const auto least = FindOptimum(problem, links_, options_);
    if (!least) return false;
    const double least_deg = least->prediction->angle_mismatch_deg;
    if (least_deg <= *problem_.max_angle_mismatch_deg) return false;
    report_.nearest = least->point;
    report_.least_angle_mismatch_deg = least_deg;
    report_.sentence = fmt::format(
        "no design keeps its knee angle within {}° of the human's at every instant: the least found with the {} "
        "program is {}° (--max-angle-mismatch){}",
        SignificantText(*problem_.max_angle_mismatch_deg, 4), ProgramName(problem_.program.kind),
        SignificantText(least_deg, 4),
        problem_.program.kind == Kind::kFree ? "; a longer --duration lets it follow" : "; try --program free");
    return true;
  }

  // With all other limits.
  std::optional<RedesignSolve> LeastCuffForce(RedesignProblem problem) const {
    problem.goal = Goal::kCuffForce;
    problem.penalty_deg_per_mm = problem.cuff_penalty_deg_per_n = 0;
    problem.max_cuff_force_n.reset();
    return FindOptimum(problem, links_, options_);
  }

  std::optional<double> WorkingCuffForce(double least_n, const RedesignProblem& problem) const {
    return Working(least_n, problem, [](RedesignProblem& p, double value) { p.max_cuff_force_n = value; });
  }

  // Nor the force at the cuffs, however far the path is off.
  bool ExplainCuffs() {
    if (!problem_.max_cuff_force_n) return false;
    RedesignProblem unlimited = problem_;
    unlimited.max_misalignment_percent.reset();
    unlimited.balance.reset();
    const auto least = LeastCuffForce(unlimited);
    if (!least) return false;
    const double least_n = least->prediction->cuff_force_n;
    if (least_n <= *problem_.max_cuff_force_n) return false;
    report_.nearest = least->point;
    report_.least_cuff_force_n = least_n;
    const auto working_n = WorkingCuffForce(least_n, unlimited);
    report_.sentence = fmt::format(
        "no design keeps the force at each cuff within {} N (--max-cuff-force): the least found is {} N where "
        "cuffs and flesh are stiffest ({} N/mm)",
        SignificantText(*problem_.max_cuff_force_n, 4), SignificantText(least_n, 3),
        SignificantText(problem_.cuffs.stiffest_n_mm, 3));
    if (working_n)
      report_.sentence += fmt::format("; a limit of {} N at the cuffs can be held", SignificantText(*working_n, 4));
    RedesignProblem other = unlimited;
    other.fit_placement = true;
    const char* change = "fitting the placement (--fit-placement)";
    if (problem_.fit_placement) {
      other.placement_reach_mm *= 2;
      change = "a joint that may be moved twice as far (--placement-reach)";
    }
    if (const auto moved = LeastCuffForce(other)) {
      const double moved_n = moved->prediction->cuff_force_n;
      report_.ways.push_back({change, moved_n <= *problem_.max_cuff_force_n, {}, {}});
      report_.sentence += fmt::format("; {} reaches {} N", change, SignificantText(moved_n, 3));
    }
    return true;
  }

  // Nor the balance.
  bool ExplainBalance() {
    if (!problem_.balance) return false;
    const auto most = FindOptimum(WithGoal(problem_, Goal::kBalance), links_, options_);
    if (!most) return false;
    const double most_mm = most->prediction->balance->margin_mm;
    if (most_mm >= problem_.balance->margin_mm) return false;
    report_.nearest = most->point;
    report_.largest_margin_mm = most_mm;
    report_.sentence = fmt::format(
        "no program keeps the centre of pressure {} mm inside the foot (--balance): the most found is {} mm "
        "{}, "
        "at {:.0f} % of the rise, leaning the trunk by up to {:.0f}° and the leg by up to {:.0f}° more than the person "
        "did; a seat that is higher or feet drawn back bring the body over the foot, or something must hold the person",
        SignificantText(problem_.balance->margin_mm, 4), SignificantText(std::abs(most_mm), 3),
        most_mm < 0 ? "outside" : "inside", most->prediction->balance->at_percent, problem_.balance->trunk_deg,
        problem_.balance->leg_deg);
    return true;
  }

  // Does a run of this problem find a design?
  bool CanBeSolved(const RedesignProblem& problem) const {
    if (HasSolution(problem, links_, options_)) return true;
    const auto least = Least(problem);
    return least && SolveFrom(problem, least->point, options_, true).IsUsable();
  }

  // A rounded value from the least one upwards at which `set` makes a problem that can be solved.
  template <typename Set>
  std::optional<double> Working(double least, RedesignProblem problem, Set set) const {
    constexpr int kTries = 4;
    double value = RoundedUp(least);
    for (int i = 0; i < kTries; ++i, value = RoundedUp(1.005 * value)) {
      set(problem, value);
      if (CanBeSolved(problem)) return value;
    }
    return std::nullopt;
  }

  std::optional<double> WorkingDuration(const RedesignProblem& problem) const {
    const auto least_s = LeastDuration(problem);
    if (!least_s) return std::nullopt;
    return Working(*least_s, problem, [](RedesignProblem& p, double value) { p.program.duration_s = value; });
  }

  // The synthesis problem itself, or the time of the motion, has no solution.
  void ExplainWithoutMisalignment() {
    const synthesis::InfeasibilityReport design = synthesis::AnalyseInfeasibility(problem_.design, options_);
    report_.nearest = StartPoint(problem_, design.links);
    report_.sentence = design.sentence;
    if (!design.solved || !design.relaxations.empty()) return;
    std::optional<double> needed_s = WorkingDuration(problem_);
    if (!needed_s) {  // the limit on misalignment needs more than time
      RedesignProblem unlimited = problem_;
      unlimited.max_misalignment_percent.reset();
      needed_s = WorkingDuration(unlimited);
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

  // d RMS = d (mean square) / (2 RMS).
  void CollectBlocking(const RedesignSolve& least) {
    constexpr double kNoPrice = 1e-4;  // % per mm, deg or s
    const synthesis::ActiveSet active = synthesis::FindActiveSet(least.local);
    for (synthesis::ActiveSet::Entry entry : active.entries) {
      entry.price *= 1 / (2 * *report_.least_percent);
      if (std::abs(entry.price) < kNoPrice) continue;
      if (!active.multipliers_unique) entry.price = std::numeric_limits<double>::quiet_NaN();
      report_.blocking.push_back(entry);
    }
  }

  void AddLeast(const std::string& text, const RedesignProblem& problem) {
    const auto least = Least(problem);
    if (!least) return;
    const double percent = least->Misalignment_percent();
    RedesignProblem limited = problem;
    limited.max_misalignment_percent = problem_.max_misalignment_percent;
    const bool enough = SolveFrom(limited, least->point, options_, true).IsUsable();
    report_.ways.push_back({text, enough, percent, {}});
  }

  void TryPlacement() {
    if (problem_.fit_placement) return;
    RedesignProblem other = problem_;
    other.fit_placement = true;
    AddLeast(fmt::format("fitting the placement within {} mm (--fit-placement)",
                         SignificantText(other.placement_reach_mm, 4)),
             other);
  }

  void TryDuration() {
    RedesignProblem other = problem_;
    other.program.kind = Kind::kFree;
    const auto needed_s = WorkingDuration(other);
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

  void TryReversing() {
    if (!problem_.program.monotone || problem_.program.kind != Kind::kFree) return;
    RedesignProblem other = problem_;
    other.program.monotone = false;
    AddLeast("a program that may turn back (without --monotone)", other);
  }

  void TryWithoutBalance() {
    if (!problem_.balance) return;
    RedesignProblem other = problem_;
    other.balance.reset();
    AddLeast("a person out of balance, whom something holds (without --balance)", other);
  }

  void TryCuffs() {
    if (!problem_.max_cuff_force_n) return;
    const auto least = LeastCuffForce(problem_);
    if (!least) return;
    if (const auto working_n = WorkingCuffForce(least->prediction->cuff_force_n, problem_))
      report_.ways.push_back(
          {fmt::format("a limit of {} N at the cuffs (--max-cuff-force)", SignificantText(*working_n, 4)),
           true,
           {},
           {}});
  }

  std::string Sentence() const {
    const bool free = problem_.program.kind == Kind::kFree;
    std::string program = fmt::format("{} program", ProgramName(problem_.program.kind));
    if (problem_.program.duration_s)
      program += fmt::format(" of {} s", SignificantText(*problem_.program.duration_s, 4));
    std::string text =
        fmt::format("no design has a misalignment of at most {} %: the smallest found with the {} at {} mm/s is {} %",
                    SignificantText(*problem_.max_misalignment_percent, 4), program,
                    SignificantText(problem_.program.max_speed_mm_s, 4), SignificantText(*report_.least_percent, 4));
    if (report_.working_percent)
      text += fmt::format(" (a limit of {} % can be held)", SignificantText(*report_.working_percent, 4));
    std::vector<std::string> names;
    for (const synthesis::ActiveSet::Entry& entry : report_.blocking) names.push_back(entry.name);
    if (!free) names.insert(names.begin(), "the constant program");
    if (!names.empty()) text += fmt::format(", held there by {}", fmt::join(names, ", "));
    std::vector<std::string> enough, too_little;
    for (const WayOut& way : report_.ways)
      if (way.enough)
        enough.push_back(way.text);
      else
        too_little.push_back(fmt::format("{} reaches {} %", way.text, SignificantText(*way.misalignment_percent, 4)));
    if (!enough.empty()) text += fmt::format("; what would free it: {}", fmt::join(enough, "; or "));
    if (!too_little.empty()) text += fmt::format("; not enough: {}", fmt::join(too_little, ", "));
    return text;
  }

  const RedesignProblem& problem_;
  const std::vector<linkage::Links>& links_;
  const synthesis::OptimizeOptions& options_;
  MisalignmentInfeasibility report_;
};

}  // namespace

MisalignmentInfeasibility ExplainInfeasible(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                                            const synthesis::OptimizeOptions& options) {
  return Explainer(problem, links, options).Explain();
}

}  // namespace lake::redesign
