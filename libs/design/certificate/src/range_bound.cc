#include "relaxation.h"

namespace lake::certificate {
namespace {

Interval Min(const Interval& a, const Interval& b) {
  return {std::min(a.lower, b.lower), std::min(a.upper, b.upper)};
}

// Where it is empty no design of these intervals closes, so anything encloses them.
Interval Kappa(const AxisBox& bars) {
  const Interval kappa = KappaOf(bars);
  return kappa.IsEmpty() ? Beta1Of(bars) + Interval(0, kPiInterval.upper) : kappa;
}

// A lower bound of kappa over the four-bars, phi sliced until dkappa/dphi has a proved sign on a slice or it is narrow.
double LeastKappa(const AxisBox& bars, int depth = 8) {
  const Interval kappa = Kappa(bars), phi = bars[kPhi];
  if (phi.Width() == 0) return kappa.lower;
  AxisBox low = bars;
  if ((bars[kL3] * Sin(phi) + bars[kL4] * Sin(kappa - phi)).lower >= 0) {
    low[kPhi] = phi.lower;
    return std::max(kappa.lower, Kappa(low).lower);
  }
  if (depth == 0) return kappa.lower;
  AxisBox high = bars;
  low[kPhi].upper = high[kPhi].lower = phi.Middle();
  const double least = LeastKappa(low, depth - 1);
  // What lies above cannot matter if it is enclosed above the low half.
  return Kappa(high).lower >= least ? least : std::min(least, LeastKappa(high, depth - 1));
}

}  // namespace

RangeBound::RangeBound(const problem::SynthesisProblem& problem)
    : d_min_(problem.d_min_mm), margins_{problem.grashof_margin_mm, problem.singularity_margin_mm} {
  for (std::size_t i = 0; i < root_.size(); ++i) root_[i] = {problem.bounds[i].lower, problem.bounds[i].upper};
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem))
    if (requirement.IsLinear()) linear_.push_back(requirement);
}

bool RangeBound::Contract(LinkBox& box) const {
  constexpr int kSweeps = 3;  // each constraint couples few links; more sweeps gain next to nothing
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const problem::Requirement& row : linear_)
      for (std::size_t i = 0; i < box.size(); ++i) {
        if (row.Info().coefficients[i] == 0) continue;
        Interval rest = row.limit;
        for (std::size_t j = 0; j < box.size(); ++j)
          if (j != i && row.Info().coefficients[j] != 0) rest = rest - row.Info().coefficients[j] * box[j];
        // coefficient x link >= rest for some point of the others.
        const Interval end = rest / Interval(row.Info().coefficients[i]);
        if (row.Info().coefficients[i] > 0)
          box[i].lower = std::max(box[i].lower, end.lower);
        else
          box[i].upper = std::min(box[i].upper, end.upper);
        if (box[i].IsEmpty()) return false;
      }
    // l7 <= l2 + d - m, and the triangle l7, l2, d closes.
    const Interval longest = box[kL2] + d_min_ - margins_.singularity_mm;
    const Interval l5_square = Square(box[kL5]), l6_square = Square(box[kL6]);
    box[kL6].upper = std::min(box[kL6].upper, Sqrt(Square(longest) - l5_square).upper);
    box[kL5].upper = std::min(box[kL5].upper, Sqrt(Square(longest) - l6_square).upper);
    const Interval l7 = Sqrt(Square(box[kL5]) + Square(box[kL6]));
    box[kL2].lower = std::max(box[kL2].lower, (l7 - d_min_ + margins_.singularity_mm).lower);
    for (const Axis i : {kL2, kL5, kL6})
      if (box[i].IsEmpty()) return false;
    if (l7.upper < (d_min_ - box[kL2]).lower || l7.upper < (box[kL2] - d_min_).lower) return false;
  }
  return true;
}

RangeBound::BarAngle RangeBound::BarAngleOf(const LinkBox& box) const {
  const auto angle = [&](const Interval& l6) {
    const Interval longest = box[kL2] + d_min_ - margins_.singularity_mm;
    const Interval l5 = box[kL5];
    const Interval mount = Min(Sqrt(Square(l5) + Square(l6)), longest);
    const Interval height = Min(l6, Sqrt(Square(longest) - Square(l5)));
    // cos alpha2 = 1 - slack (d + l7 - l2) / (2 l7 l2), slack = l2 + d - l7: keeps its digits near the singularity.
    const Interval slack = Max(margins_.singularity_mm, box[kL2] + d_min_ - mount);
    const Interval alpha2 = ArcCos(1.0 - slack * (d_min_ + mount - box[kL2]) / (2.0 * mount * box[kL2]));
    const Interval alpha1 = AngleFromY(l5, height);
    return alpha1 + alpha2;
  };
  const Interval phi = angle(box[kL6]);
  // dphi/dl6 < 0 if l7^2 + d^2 - l2^2 > 0.
  const bool falls = (Square(box[kL5]) + Square(box[kL6]) + Square(Interval(d_min_)) - Square(box[kL2])).lower > 0;
  return {phi, falls ? angle(box[kL6].upper).lower : phi.lower};
}

RangeBound::Coupler RangeBound::LeastCoupler(const LinkBox& box) const {
  const Interval bound = box[kL1].lower;
  // As l4 >= l2, Grashof's law asks for at least l3 + g.
  const Interval grashof = Max(box[kL3] + margins_.grashof_mm, box[kL3] + box[kL4] + margins_.grashof_mm - box[kL2]);
  // The first test is free of rounding; it decides the paper's problem, where the bounds of l1 and l3 are the same.
  const bool follows = box[kL3].lower >= bound.upper || grashof.lower >= bound.upper;
  const Interval slope = follows ? 1 : grashof.upper <= bound.lower ? 0 : Interval(0, 1);
  return {Max(bound, grashof), slope};
}

double RangeBound::UpperBound(const LinkBox& box) const {
  const BarAngle bar = BarAngleOf(box);
  // Past phi = pi the tip is behind the knee pivot (l2 >= l3), so beta1 >= pi and theta <= 0.
  if (bar.least > kPiInterval.upper) return 0;
  const Coupler coupler = LeastCoupler(box);
  AxisBox bars{coupler.l1, box[kL2], box[kL3], box[kL4]};
  bars[kPhi] = Interval(bar.least, std::min(bar.phi.upper, kPiInterval.upper));
  // dkappa/dl3 has the sign of slope - q.y, where l1 follows Grashof's law with that slope.
  const Interval q_y = (bars[kL3] + bars[kL2] * Cos(bars[kPhi]) - bars[kL4] * Cos(Kappa(bars))) / bars[kL1];
  if (coupler.slope.lower >= std::min(q_y.upper, 1.0)) {
    bars[kL3] = box[kL3].lower;
    bars[kL1] = Max(box[kL1].lower, Max(bars[kL3], bars[kL3] + bars[kL4] - bars[kL2]) + margins_.grashof_mm);
  }
  // dkappa/dl4 has the sign of slope + q.s; l4 falls until it meets its bound, l2 or l1.
  const Interval q_s =
      (SquaredTipDistance(bars) - Square(bars[kL4]) - Square(bars[kL1])) / (2.0 * bars[kL4] * bars[kL1]);
  if (coupler.slope.lower >= -std::max(q_s.lower, -1.0)) {
    const Interval least = std::max(box[kL4].lower, box[kL1].lower);
    // Where l1 follows Grashof's law, kappa falls with l2 as well: dkappa/dl2 has the sign of -(1 + q.u) while l4
    // stays, and with l4 = l2 and l1 - l3 = g that of -(g (l1 + l3) / (2 l2) + l2 (1 - cos(kappa - phi))).
    if (coupler.slope.lower == 1) bars[kL2] = box[kL2].upper;
    bars[kL4] = Max(least, bars[kL2]);
    bars[kL1] = Max(box[kL1].lower, bars[kL3] + Max(least - bars[kL2], 0) + margins_.grashof_mm);
  }
  // kappa >= phi: relaxation.cc.
  return std::max(0.0, (kPiInterval - Interval(std::max(LeastKappa(bars), bar.least))).upper);
}

}  // namespace lake::certificate
