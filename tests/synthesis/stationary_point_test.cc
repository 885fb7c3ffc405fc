#include "lake/certificate/stationary_point.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "lake/certificate/enclosure.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/problem/problem_file.h"
#include "lake/synthesis/optimize.h"
#include "paper.h"
#include "places.h"
#include "pose_slopes.h"
#include "range_bound.h"

namespace lake {
namespace {

using certificate::CertifyStationaryPoint;
using certificate::Enclosure;
using certificate::Interval;
using certificate::StationaryPoint;

struct Wave {
  template <typename T>
  T operator()(const T* v) const {
    using std::cos, std::sin, std::sqrt;
    return sin(v[0] * v[1]) / (2.0 + cos(v[2])) - sqrt(v[1] * v[1] + 1.0) * v[2] + 3.0 / v[0];
  }
};

// Value, gradient and Hessian by dual numbers at any point of a box are in what encloses them over the box.
TEST(Enclosure, ContainsWhatDualNumbersFind) {
  std::mt19937_64 random(20260808);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 500; ++trial) {
    const double size = std::pow(10.0, -8 * unit(random));
    const certificate::EnclosedTerm<3, Wave> term({0, 1, 2}, {});
    std::vector<Interval> box;
    std::vector<double> x;
    for (int i = 0; i < 3; ++i) {
      const double lower = 0.5 + 2 * unit(random), share = unit(random);
      box.emplace_back(lower, lower + size);
      x.push_back(std::min(lower + size * share, lower + size));
    }
    const Enclosure enclosure = term.Enclose(box);
    double gradient[3], hessian[6];
    term.Gradient(x.data(), gradient);
    term.Hessian(x.data(), hessian);
    constexpr double kRounding = 1e-12;  // of the dual numbers
    const auto contains = [&](const Interval& interval, double value) {
      return (interval + Interval(-kRounding, kRounding)).Contains(value);
    };
    EXPECT_TRUE(contains(enclosure.value, term.Value(x.data())));
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(contains(enclosure.first[i], gradient[i])) << i;
      for (int j = 0; j <= i; ++j)
        EXPECT_TRUE(contains(enclosure.Second(i, j), hessian[i * (i + 1) / 2 + j])) << i << j;
    }
    if (size < 1e-6) {
      EXPECT_LT(enclosure.Second(2, 0).Width(), 1e-3);
    }
  }
}

struct Away {
  double x, y;
  template <typename T>
  T operator()(const T* v) const {
    return (v[0] - x) * (v[0] - x) + (v[1] - y) * (v[1] - y);
  }
};
struct Total {
  template <typename T>
  T operator()(const T* v) const {
    return v[0] + v[1];
  }
};

// The point nearest to (x, y) with a + b <= 2, a <= 4 and b <= 4.
nlp::NonlinearProgram NearestTo(double x, double y) {
  nlp::NonlinearProgram program;
  const int a = program.AddVariable("a", 0.1, -4, 4), b = program.AddVariable("b", 0.2, -4, 4);
  program.AddTerm(nlp::NlpTerm::kCost,
                  std::make_unique<certificate::EnclosedTerm<2, Away>>(std::array{a, b}, Away{x, y}));
  program.AddTerm(program.AddRow("total", -nlp::kUnbounded, 2),
                  std::make_unique<certificate::EnclosedTerm<2, Total>>(std::array{a, b}, Total{}));
  return program;
}

TEST(StationaryPoint, OfAPlaneProblemIsCertified) {
  const nlp::NonlinearProgram program = NearestTo(2, 3);
  nlp::NlpSolution solution = nlp::SolveNlp(program);
  EXPECT_NEAR(solution.x[0], 0.5, 1e-6);  // (2, 3) less 1.5 along (1, 1)
  const StationaryPoint point = CertifyStationaryPoint(program, solution);
  EXPECT_TRUE(point.is_certified) << point.reason;
  EXPECT_EQ(point.unknowns, 3);
  const std::array all{0, 1};
  EXPECT_GT(point.SmallestRadius(all), 0);
  EXPECT_LE(point.SmallestRadius(all), certificate::kStationaryRadius);
  EXPECT_TRUE(point.box[0].Contains(0.5));
  EXPECT_TRUE(point.box[1].Contains(1.5));
  EXPECT_LE(point.Distance({0.5, 1.5}, all), 2.1 * point.SmallestRadius(all));  // the box's width and rounding
  EXPECT_NEAR(point.Distance({0.5, 1.0}, all), 0.5, 2.1 * point.SmallestRadius(all));
  solution.x = {0.51, 1.49};  // on the limit, but beside the point
  EXPECT_EQ(CertifyStationaryPoint(program, solution).reason, "the nearest stationary point is another");
}

struct Pole {
  template <typename T>
  T operator()(const T* v) const {
    return 1.0 / v[0] + v[0] * v[0];
  }
};
struct Itself {
  template <typename T>
  T operator()(const T* v) const {
    return v[0] * 1.0;
  }
};

TEST(StationaryPoint, ATermWithAPoleInTheBoxIsNotCertified) {
  nlp::NonlinearProgram program;
  const int x = program.AddVariable("x", 0, -4, 4), y = program.AddVariable("y", 0, -4, 4);
  program.AddTerm(nlp::NlpTerm::kCost, std::make_unique<certificate::EnclosedTerm<1, Pole>>(std::array{x}, Pole{}));
  program.AddTerm(nlp::NlpTerm::kCost,
                  std::make_unique<certificate::EnclosedTerm<2, Away>>(std::array{x, y}, Away{0, 0}));
  nlp::NlpSolution solution;
  for (const double at : {0.0, 1e-9, -1e-7}) {
    solution.x = {at, 0};
    EXPECT_FALSE(CertifyStationaryPoint(program, solution).is_certified) << at;
  }
}

// One program may have two stationary points in the box, at one of which a limit is active: the proof is of that one.
struct Bent {
  template <typename T>
  T operator()(const T* v) const {
    return 1e-3 * v[0] - 5e5 * v[0] * v[0];
  }
};

TEST(StationaryPoint, IsTheOnlyOneOfTheSameActiveLimitsAlone) {
  nlp::NonlinearProgram program;
  const int x = program.AddVariable("x", 0, -1, 1);
  program.AddTerm(nlp::NlpTerm::kCost, std::make_unique<certificate::EnclosedTerm<1, Bent>>(std::array{x}, Bent{}));
  program.AddTerm(program.AddRow("x", 0, nlp::kUnbounded),
                  std::make_unique<certificate::EnclosedTerm<1, Itself>>(std::array{x}, Itself{}));
  nlp::NlpSolution solution;
  solution.x = {0};
  solution.row_marginal_costs = {1e-3};
  const StationaryPoint point = CertifyStationaryPoint(program, solution);
  ASSERT_TRUE(point.is_certified) << point.reason;
  EXPECT_TRUE(point.box[0].Contains(1e-9));  // where the cost's slope is zero
}

TEST(StationaryPoint, ALimitWithoutAPriceIsNamed) {
  const nlp::NonlinearProgram program = NearestTo(1, 1);  // on the limit by itself
  nlp::NlpSolution solution = nlp::SolveNlp(program);
  solution.x = {1, 1};
  const StationaryPoint point = CertifyStationaryPoint(program, solution);
  EXPECT_FALSE(point.is_certified);
  EXPECT_THAT(point.reason, ::testing::HasSubstr("'total' is at its limit without a price"));
}

TEST(StationaryPoint, AMaximumOnALimitIsNone) {
  const nlp::NonlinearProgram program = NearestTo(-1, 0);
  nlp::NlpSolution solution = nlp::SolveNlp(program);
  ASSERT_TRUE(CertifyStationaryPoint(program, solution).is_certified);
  solution.x = {0.5, 1.5};  // the point of the limit nearest to (-1, 0), which the limit does not hold back
  solution.row_marginal_costs = {3};
  EXPECT_EQ(CertifyStationaryPoint(program, solution).reason, "'total' is at its limit without a price");
}

TEST(StationaryPoint, OptimaWithMarginsAreCertified) {
  for (const double margin : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    const problem::SynthesisProblem problem = WithMargins(margin);
    const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
    const StationaryPoint point = CertifyStationaryPoint(best.program.program, best.solution);
    EXPECT_TRUE(point.is_certified) << margin << ": " << point.reason;
    ASSERT_TRUE(point.is_certified);
    EXPECT_LE(point.Distance(best.solution.x, best.program.links), 2e-6) << margin;  // the box's own width in it
  }
}

TEST(StationaryPoint, OptimaWithLimitsOverTheUsedRangeAreCertified) {
  for (const char* name : {"buildable.yaml", "wearable.yaml"}) {
    const problem::SynthesisProblem problem = problem::ReadProblem(SourceDir() / "calibration/problems" / name);
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(3));
    ASSERT_TRUE(result.IsSolved()) << name;
    const StationaryPoint point = CertifyStationaryPoint(result.Best().program.program, result.Best().solution);
    EXPECT_TRUE(point.is_certified) << name << ": " << point.reason;
  }
}

TEST(StationaryPoint, ThePublishedProblemHasDependentLimits) {
  const problem::SynthesisProblem problem;
  const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
  const StationaryPoint point = CertifyStationaryPoint(best.program.program, best.solution);
  EXPECT_FALSE(point.is_certified);
  EXPECT_THAT(point.reason, ::testing::HasSubstr("linearly dependent"));
}

// All stationary points of the paper's problem with margins in its reduced form, without any bound on the range: what
// README says of the signs leaves l3 at its bound, l4 = l2 and Grashof's law l1 = l3 + g, so l2, l5 and l6 are
// searched, the whole of them, for boxes that may hold one. A box holds none if some direction d raises theta
// everywhere in it and leads into the set at every limit that may be active there: grad theta + sum m grad c = 0 with m
// >= 0, times d, would be above 0.
class StationarySearch {
 public:
  using Box = std::array<Interval, 3>;  // l2, l5, l6

  explicit StationarySearch(const problem::SynthesisProblem& problem)
      : problem_(problem), margins_{problem.grashof_margin_mm, problem.singularity_margin_mm} {
    for (const std::size_t i : {1, 4, 5}) root_.push_back({problem.bounds[i].lower, problem.bounds[i].upper});
    root_[0].lower = L1();  // l1 <= l4
  }

  // What is left when boxes are smaller than this.
  std::vector<Box> Boxes(double size_mm) {
    std::vector<Box> open{{root_[0], root_[1], root_[2]}}, left;
    while (!open.empty() && ++examined_ < kMostBoxes) {
      const Box box = open.back();
      open.pop_back();
      if (Slack(box).upper < margins_.singularity_mm || HoldsNone(box)) continue;
      const auto widest = std::ranges::max_element(box, {}, &Interval::Width) - box.begin();
      if (box[widest].Width() < size_mm) {
        left.push_back(box);
        continue;
      }
      Box low = box, high = box;
      low[widest].upper = high[widest].lower = box[widest].Middle();
      open.push_back(low);
      open.push_back(high);
    }
    return left;
  }
  bool IsComplete() const { return examined_ < kMostBoxes; }

 private:
  static constexpr int kMostBoxes = 2'000'000;
  using Gradient = std::array<Interval, 3>;

  double L3() const { return problem_.bounds[2].lower; }
  double L1() const { return L3() + margins_.grashof_mm; }
  Interval Slack(const Box& box) const { return box[0] + problem_.d_min_mm - Sqrt(Square(box[1]) + Square(box[2])); }

  std::optional<Gradient> ThetaGradient(const Box& box) const {
    const auto& [l2, l5, l6] = box;
    certificate::Region region{{L1(), l2, L3(), l2, l5, l6, 0}, std::nullopt};
    const certificate::RangeBound::BarAngle angle =
        certificate::RangeBound(problem_).BarAngleOf({L1(), l2, L3(), l2, l5, l6});
    const Interval phi{angle.least, angle.phi.upper};
    region.box[certificate::kPhi] = phi;
    const auto pose = certificate::PoseAtShortestStroke(region, problem_.d_min_mm, margins_);
    if (!pose) return std::nullopt;
    const certificate::Slope bar = certificate::BarAngleAtShortestStroke(region.box, phi, problem_.d_min_mm, margins_);
    const auto by = [&](std::size_t link) { return -pose->kappa.by[certificate::kPhi] * bar.by[link]; };
    return Gradient{by(1) - pose->kappa.by[1] - pose->kappa.by[3], by(4), by(5)};
  }

  // Gradients of the limits that may be active in the box.
  std::vector<Gradient> ActiveGradients(const Box& box) const {
    std::vector<Gradient> active;
    const Interval l7 = Sqrt(Square(box[1]) + Square(box[2]));
    if (Slack(box).lower <= margins_.singularity_mm) active.push_back({1, -box[1] / l7, -box[2] / l7});
    for (std::size_t i = 0; i < box.size(); ++i)
      for (const bool upper : {false, true}) {
        if (upper ? box[i].upper < root_[i].upper : box[i].lower > root_[i].lower) continue;
        Gradient gradient{};
        gradient[i] = upper ? -1 : 1;
        active.push_back(gradient);
      }
    return active;
  }

  // Directions to try: along the axes' planes in even steps, and the same a little inwards of the actuator's limit.
  static std::vector<std::array<double, 3>> Directions(const Box& box) {
    const double l5 = box[1].Middle(), l6 = box[2].Middle(), l7 = std::hypot(l5, l6);
    std::vector<std::array<double, 3>> directions;
    constexpr int kSteps = 4;
    for (int y = -kSteps; y <= kSteps; ++y)
      for (int z = -kSteps; z <= kSteps; ++z) {
        const double by5 = static_cast<double>(y) / kSteps, by6 = static_cast<double>(z) / kSteps;
        for (const double by2 : {-1.0, -0.1, 0.0, 0.1, 1.0}) directions.push_back({by2, by5, by6});
        for (const double inwards : {1e-3, 1e-2, 1e-1})
          directions.push_back({(l5 * by5 + l6 * by6) / l7 + inwards, by5, by6});
      }
    return directions;
  }

  bool HoldsNone(const Box& box) const {
    const std::optional<Gradient> theta = ThetaGradient(box);
    if (!theta) return true;
    if (!std::ranges::all_of(*theta, [](const Interval& by) { return std::isfinite(by.Width()); })) return false;
    const std::vector<Gradient> active = ActiveGradients(box);
    // The end of what a gradient may be along d; sums with zero are exact.
    const auto least_along = [](const Gradient& gradient, const std::array<double, 3>& d) {
      Interval sum = 0;
      for (std::size_t i = 0; i < 3; ++i)
        if (d[i] != 0 && (gradient[i].lower != 0 || gradient[i].upper != 0)) sum = sum + gradient[i] * d[i];
      return sum.lower;
    };
    return std::ranges::any_of(Directions(box), [&](const std::array<double, 3>& d) {
      constexpr double kExact = -1e-300;  // a bound's gradient times zero, widened by the least number
      return least_along(*theta, d) > 0 &&
             std::ranges::all_of(active, [&](const Gradient& each) { return least_along(each, d) >= kExact; });
    });
  }

  const problem::SynthesisProblem& problem_;
  const certificate::Margins margins_;
  std::vector<Interval> root_;
  int examined_ = 0;
};

TEST(StationaryPoint, TheOptimumIsTheOnlyOneOfThePublishedProblemWithMargins) {
  for (const double margin : {5.0, 10.0}) {
    const problem::SynthesisProblem problem = WithMargins(margin);
    const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
    ASSERT_TRUE(best.IsUsable());
    // The form that is searched.
    EXPECT_NEAR(best.end.l3, problem.bounds[2].lower, 1e-6);
    EXPECT_NEAR(best.end.l4, best.end.l2, 1e-6);
    EXPECT_NEAR(best.end.l1, best.end.l3 + margin, 1e-6);
    const std::array optimum{best.end.l2, best.end.l5, best.end.l6};

    StationarySearch search(problem);
    const std::vector<StationarySearch::Box> boxes = search.Boxes(0.1);
    ASSERT_TRUE(search.IsComplete());
    double farthest = 0;
    bool one_holds_it = false;
    for (const StationarySearch::Box& box : boxes) {
      bool holds_it = true;
      for (std::size_t i = 0; i < box.size(); ++i) {
        constexpr double kOfSolver_mm = 1e-6;
        holds_it = holds_it && (box[i] + Interval(-kOfSolver_mm, kOfSolver_mm)).Contains(optimum[i]);
        farthest = std::max({farthest, std::abs(box[i].lower - optimum[i]), std::abs(box[i].upper - optimum[i])});
      }
      one_holds_it = one_holds_it || holds_it;
    }
    EXPECT_TRUE(one_holds_it);
    EXPECT_LT(farthest, 1) << "there may be another";
  }
}

}  // namespace
}  // namespace lake
