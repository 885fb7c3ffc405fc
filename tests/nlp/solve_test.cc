#include "lake/nlp/solve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "central_differences.h"
#include "lake/core/error.h"

namespace {

bool is_slow = false;

}  // namespace

// The clock that Ipopt looks at; this one is found before the C library's. On the slow machine an hour of processor
// time goes by from one look to the next.
extern "C" int getrusage(__rusage_who_t who, rusage* usage) noexcept {
  static long hours = 0;
  const auto result = static_cast<int>(syscall(SYS_getrusage, who, usage));
  if (is_slow) usage->ru_utime.tv_sec += 3600 * ++hours;
  return result;
}

namespace lake {
namespace {

// Problem 71 of Hock & Schittkowski (1981): min x1 x4 (x1 + x2 + x3) + x3, x1 x2 x3 x4 >= 25, |x|^2 = 40, 1 <= x <= 5.
nlp::NonlinearProgram HockSchittkowski71(double least_product = 25) {
  nlp::NonlinearProgram program;
  const double start[] = {1, 5, 5, 1};
  for (int i = 0; i < 4; ++i) program.AddVariable("x" + std::to_string(i + 1), start[i], 1, 5);
  // The cost in two terms, to see that terms are summed.
  program.AddCost(std::array{0, 1, 2, 3}, [](const auto* x) { return x[0] * x[3] * (x[0] + x[1] + x[2]); });
  program.AddCost(std::array{2}, [](const auto* x) { return 1.0 * x[0]; });
  program.AddConstraint("product", least_product, nlp::kUnbounded, std::array{0, 1, 2, 3},
                        [](const auto* x) { return x[0] * x[1] * x[2] * x[3]; });
  const int sphere = program.AddRow("sphere", 40, 40);
  for (int i = 0; i < 4; ++i) program.AddTerm(sphere, std::array{i}, [](const auto* x) { return x[0] * x[0]; });
  return program;
}

TEST(SolveNlp, ReachesThePublishedOptimum) {
  const nlp::NlpSolution solution = nlp::SolveNlp(HockSchittkowski71());
  ASSERT_TRUE(solution.IsUsable()) << solution.message;
  // As printed in Ipopt's documentation, eight decimals (the book's seventh decimals of x2 and x3 are off).
  EXPECT_NEAR(solution.cost, 17.01401728, 2e-8);
  const double published[] = {1.0, 4.74299963, 3.82114998, 1.37940829};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(solution.x[i], published[i], 2e-8);
  EXPECT_LT(solution.violation, 1e-8);
  EXPECT_LT(solution.kkt_error, 1e-7);
  EXPECT_EQ(solution.iterations.size(), solution.iterations.back().iteration + 1u);
}

TEST(SolveNlp, PricesAreDerivativesOfTheOptimumByTheBounds) {
  const double step = 1e-3;
  const double above = nlp::SolveNlp(HockSchittkowski71(25 + step)).cost,
               below = nlp::SolveNlp(HockSchittkowski71(25 - step)).cost;
  const nlp::NlpSolution solution = nlp::SolveNlp(HockSchittkowski71());
  EXPECT_NEAR(solution.row_marginal_costs[0], (above - below) / (2 * step), 1e-6);
  EXPECT_GT(solution.row_marginal_costs[0], 0);
  EXPECT_GT(solution.variable_marginal_costs[0], 0);          // x1 is held at its lower bound
  EXPECT_NEAR(solution.variable_marginal_costs[2], 0, 1e-7);  // x3 is free
}

TEST(SolveNlp, FixedVariableHasThePriceOfMovingIt) {
  const auto solve = [](double value) {
    nlp::NonlinearProgram program;
    program.AddVariable("fixed", value, value, value);
    program.AddVariable("free", 0, -nlp::kUnbounded, nlp::kUnbounded);
    program.AddCost(std::array{0, 1},
                    [](const auto* x) { return (x[1] - 2.0 * x[0]) * (x[1] - 2.0 * x[0]) + x[0] * x[0]; });
    return nlp::SolveNlp(program);
  };
  const nlp::NlpSolution solution = solve(3);
  ASSERT_TRUE(solution.IsUsable()) << solution.message;
  EXPECT_NEAR(solution.x[1], 6, 1e-8);
  EXPECT_NEAR(solution.variable_marginal_costs[0], 6, 1e-7);
}

// A point in a circle and beyond a line that does not meet it.
nlp::NonlinearProgram BeyondACircle() {
  nlp::NonlinearProgram program;
  program.AddVariable("x", 0.5, 0, 10);
  program.AddVariable("y", 0.5, 0, 10);
  program.AddConstraint("circle", -nlp::kUnbounded, 1, std::array{0, 1},
                        [](const auto* v) { return v[0] * v[0] + v[1] * v[1]; });
  program.AddConstraint("line", 4, nlp::kUnbounded, std::array{0, 1}, [](const auto* v) { return v[0] + v[1]; });
  program.AddCost(std::array{0}, [](const auto* v) { return v[0]; });
  return program;
}

TEST(SolveNlp, InfeasibleProgramIsAStatusWithItsBestPoint) {
  const nlp::NlpSolution solution = nlp::SolveNlp(BeyondACircle());
  EXPECT_EQ(solution.status, nlp::NlpStatus::kLocallyInfeasible) << solution.message;
  EXPECT_FALSE(solution.IsUsable());
  EXPECT_EQ(solution.x.size(), 2u);
  EXPECT_GT(solution.violation, 0.1);
}

TEST(SolveNlp, IterationLimitIsNotASolution) {
  nlp::NlpOptions options;
  options.max_iterations = 2;
  const nlp::NlpSolution solution = nlp::SolveNlp(HockSchittkowski71(), options);
  EXPECT_EQ(solution.status, nlp::NlpStatus::kIterationLimit);
  EXPECT_FALSE(solution.IsUsable());
}

// Far from the optimum the error is that of the one condition which each of these programs has: of one variable v, its
// cost, bounds and row; by the point and the multipliers at which Ipopt is stopped.
TEST(SolveNlp, OptimalityErrorBeforeTheEndIsTheWorstCondition) {
  using nlp::kUnbounded;
  struct Case {
    const char* name;
    double slope, lower, upper, row_lower, row_upper;  // cost slope·v + v⁴/100; row 2·v
  };
  nlp::NlpOptions options;
  for (const Case& one : {Case{"stationary", -50, -kUnbounded, kUnbounded, -kUnbounded, kUnbounded},
                          {"lower bound", 1, 0.5, kUnbounded, -kUnbounded, kUnbounded},
                          {"upper bound", -1, -kUnbounded, 3, -kUnbounded, kUnbounded},
                          {"row's lower bound", 1, -kUnbounded, kUnbounded, 1, kUnbounded},
                          {"row's upper bound", -1, -kUnbounded, kUnbounded, -kUnbounded, 5}})
    for (options.max_iterations = 1; options.max_iterations <= 5; ++options.max_iterations) {
      nlp::NonlinearProgram program;
      program.AddVariable("v", 2, one.lower, one.upper);
      program.AddCost(std::array{0},
                      [&](const auto* v) { return one.slope * v[0] + v[0] * v[0] * v[0] * v[0] / 100.0; });
      const bool has_row = std::isfinite(one.row_lower) || std::isfinite(one.row_upper);
      if (has_row)
        program.AddConstraint("row", one.row_lower, one.row_upper, std::array{0},
                              [](const auto* v) { return 2.0 * v[0]; });
      const nlp::NlpSolution solution = nlp::SolveNlp(program, options);
      const double v = solution.x[0], variable = solution.variable_marginal_costs[0],
                   row = has_row ? solution.row_marginal_costs[0] : 0;
      const auto complementarity = [](double marginal, double value, double lower, double upper) {
        const double distance = marginal > 0 ? value - lower : upper - value;
        return marginal == 0 || !std::isfinite(distance) ? 0 : std::abs(marginal * distance);
      };
      const double expected = std::max({std::abs(one.slope + v * v * v / 25 - 2 * row - variable),
                                        complementarity(variable, v, one.lower, one.upper),
                                        complementarity(row, 2 * v, one.row_lower, one.row_upper), solution.violation});
      EXPECT_NEAR(solution.kkt_error, expected, 1e-9 * (1 + expected))
          << one.name << ", " << options.max_iterations << " iterations";
      if (options.max_iterations < 3) {
        EXPECT_GT(solution.kkt_error, 1e-4) << one.name;
      }
    }
}

TEST(SolveNlp, OnASlowMachineComesToTheSameEnd) {
  const nlp::NlpSolution quick = nlp::SolveNlp(HockSchittkowski71());
  is_slow = true;
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const nlp::NlpSolution slow = nlp::SolveNlp(HockSchittkowski71());
  getrusage(RUSAGE_SELF, &after);
  is_slow = false;
  EXPECT_GT(after.ru_utime.tv_sec - before.ru_utime.tv_sec, 2 * 3600) << "Ipopt did not look at this clock";
  EXPECT_EQ(slow.message, quick.message);
  EXPECT_EQ(slow.x, quick.x);
}

TEST(SolveNlp, ALongRestorationIsGivenUp) {
  nlp::NlpOptions options;
  options.max_restoration_iterations = 1;
  const nlp::NlpSolution solution = nlp::SolveNlp(BeyondACircle(), options);
  EXPECT_EQ(solution.status, nlp::NlpStatus::kIterationLimit) << solution.message;
  EXPECT_LT(solution.iterations.size(), nlp::SolveNlp(BeyondACircle()).iterations.size());
  EXPECT_EQ(nlp::SolveNlp(HockSchittkowski71(), options).message, nlp::SolveNlp(HockSchittkowski71()).message);
  options.max_restoration_iterations = -1;
  EXPECT_THROW(nlp::SolveNlp(BeyondACircle(), options), Error);
}

TEST(SolveNlp, IgnoresAnOptionFileInTheWorkingDirectory) {
  const auto folder = std::filesystem::temp_directory_path() / "lake_nlp_stray_options";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "ipopt.opt") << "max_iter 1\n";
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  const nlp::NlpSolution solution = nlp::SolveNlp(HockSchittkowski71());
  std::filesystem::current_path(before);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(solution.IsUsable()) << solution.message;
}

TEST(SolveNlp, ExceptionOfATermReachesTheCaller) {
  nlp::NonlinearProgram program;
  program.AddVariable("x", 1, 0, 10);
  program.AddCost(std::array{0}, [](const auto* x) {
    if (x[0] < 100.0) throw Fail("term says no");
    return x[0] * 1.0;
  });
  EXPECT_THROW(nlp::SolveNlp(program), Error);
}

TEST(SolveNlp, RefusesOverdeterminedAndContradictoryPrograms) {
  nlp::NonlinearProgram program;
  program.AddVariable("x", 1, 0, 10);
  EXPECT_THROW(program.AddVariable("y", 1, 2, 1), Error);
  EXPECT_THROW(program.AddVariable("y", NAN, 0, 1), Error);
  EXPECT_THROW(program.AddRow("r", NAN, 1), Error);
  for (int i = 0; i < 2; ++i) program.AddConstraint("r", 1, 1, std::array{0}, [](const auto* x) { return x[0] * 1.0; });
  EXPECT_THROW(nlp::SolveNlp(program), Error);
  nlp::NlpOptions options;
  options.tolerance = 0;
  EXPECT_THROW(nlp::SolveNlp(HockSchittkowski71(), options), Error);
}

// Derivatives that are wrong on purpose: of 1.5 x instead of x^2.
struct Wrong {
  double operator()(const double* x) const { return x[0] * x[0]; }
  template <typename T>
  T operator()(const T* x) const {
    return x[0] * 1.5;
  }
};

TEST(WrongDerivatives, AreThoseThatAreWrong) {
  EXPECT_EQ(WrongDerivatives(HockSchittkowski71()), "");
  nlp::NonlinearProgram program;
  program.AddVariable("x", 1.5, 0, 10);
  program.AddCost(std::array{0}, Wrong());
  EXPECT_THAT(WrongDerivatives(program), testing::StartsWith("cost: d/d0 of 2.25: 1.5 ~ 3"));
}

// All mixed operators at once: each must agree with central differences in value, gradient and Hessian.
struct Mixed {
  template <typename T>
  T operator()(const T* v) const {
    using std::sin, std::sqrt;
    return (1.0 + v[0]) * (v[1] - 2.0) / (3.0 - v[2]) + 2.0 / v[1] + (v[2] + 0.5) / 4.0 - 1.5 * sin(v[0] * v[2]) +
           sqrt(v[1] * 2.0);
  }
};

TEST(SecondOrder, AgreesWithCentralDifferences) {
  std::mt19937 random(20240701);
  std::uniform_real_distribution<double> uniform(0.5, 2.5);
  const nlp::FunctorTerm<3, Mixed> term({0, 1, 2}, Mixed());
  for (int trial = 0; trial < 50; ++trial)
    EXPECT_EQ(WrongDerivatives(term, {uniform(random), uniform(random), uniform(random)}), "");
}

}  // namespace
}  // namespace lake
