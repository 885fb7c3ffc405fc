// Reliability against published numbers, closed forms, and how often intervals hold the truth that values were drawn
// of.
#include "lake/reliability/reliability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/core/error.h"

namespace lake::reliability {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// Table 1 of Shrout & Fleiss (1979): six targets by four judges.
Eigen::MatrixXd ShroutFleiss() {
  Eigen::MatrixXd values(6, 4);
  values << 9, 2, 5, 8, 6, 1, 3, 2, 8, 4, 6, 8, 7, 1, 2, 6, 10, 5, 6, 9, 6, 2, 4, 7;
  return values;
}

TEST(Icc, IsThatOfShroutAndFleiss) {
  const MeanSquares ms = MeanSquaresOf(ShroutFleiss());
  constexpr double kPrinted = 0.005;  // two decimals
  EXPECT_NEAR(ms.between_targets, 11.24, kPrinted);
  EXPECT_NEAR(ms.between_judges, 32.49, kPrinted);
  EXPECT_NEAR(ms.residual, 1.02, kPrinted);
  EXPECT_NEAR(Icc2Single(ms).value, 0.29, kPrinted);
  EXPECT_NEAR(Icc3Single(ms).value, 0.71, kPrinted);
}

// As psych::ICC of R prints them for these values.
TEST(Icc, HasThePublishedIntervals) {
  const MeanSquares ms = MeanSquaresOf(ShroutFleiss());
  constexpr double kPrinted = 0.006;
  EXPECT_NEAR(Icc2Single(ms).interval.low, 0.02, kPrinted);
  EXPECT_NEAR(Icc2Single(ms).interval.high, 0.76, kPrinted);
  EXPECT_NEAR(Icc3Single(ms).interval.low, 0.34, kPrinted);
  EXPECT_NEAR(Icc3Single(ms).interval.high, 0.95, kPrinted);
}

// A difference between judges costs agreement, not consistency.
TEST(Icc, CountsSystematicDifferencesAsAgreementOnly) {
  Eigen::MatrixXd values = ShroutFleiss();
  const Estimate before = Icc3Single(MeanSquaresOf(values));
  values.col(2).array() += 20;
  const MeanSquares after = MeanSquaresOf(values);
  EXPECT_NEAR(Icc3Single(after).value, before.value, 1e-12);
  EXPECT_LT(Icc2Single(after).value, 0.1);
}

TEST(Icc, OfWhatDoesNotVaryIsUnknown) {
  const MeanSquares ms = MeanSquaresOf(Eigen::MatrixXd::Constant(4, 3, 7));
  EXPECT_TRUE(std::isnan(Icc2Single(ms).value));
  EXPECT_TRUE(std::isnan(Icc3Single(ms).value));
  Eigen::MatrixXd same(3, 2);
  same << 1, 1, 2, 2, 5, 5;
  EXPECT_EQ(Icc2Single(MeanSquaresOf(same)).value, 1);
  EXPECT_EQ(StandardErrorOfMeasurement(MeanSquaresOf(same)).value, 0);
}

// Repetitions counted in frames make such tables: then the approximate degrees of freedom vanish.
TEST(Icc, OfTargetsWithTheSameMeanHasNoInterval) {
  Eigen::MatrixXd values(2, 2);
  values << 1, 3, 1.5, 2.5;
  const Estimate icc = Icc2Single(MeanSquaresOf(values));
  EXPECT_NEAR(icc.value, -1.0 / 9, 1e-12);  // − residual / between judges
  EXPECT_TRUE(std::isnan(icc.interval.low) && std::isnan(icc.interval.high));
}

TEST(Icc, RefusesTablesWithGapsOrWithoutTwoOfEach) {
  EXPECT_THAT([] { MeanSquaresOf(Eigen::MatrixXd::Zero(5, 1)); }, ThrowsMessage<Error>(HasSubstr("5 targets by 1")));
  Eigen::MatrixXd gap = ShroutFleiss();
  gap(1, 1) = NAN;
  EXPECT_THAT([&] { MeanSquaresOf(gap); }, ThrowsMessage<Error>(HasSubstr("gap")));
}

TEST(LimitsOfAgreement, AreThoseOfTheDifferences) {
  const LimitsOfAgreement limits = LimitsOfAgreementOf({10, 12, 14, 16}, {11, 13, 17, 19});  // 1, 1, 3, 3
  const double sd = std::sqrt(4.0 / 3);
  EXPECT_NEAR(limits.bias.value, 2, 1e-12);
  EXPECT_NEAR(limits.bias.interval.high, 2 + 3.182446305284263 * sd / 2, 1e-9);  // t of 3 degrees of freedom
  EXPECT_NEAR(limits.lower.value, 2 - 1.96 * sd, 1e-12);
  EXPECT_NEAR(limits.upper.value, 2 + 1.96 * sd, 1e-12);
  EXPECT_GT(limits.upper.interval.high, limits.upper.value);
}

TEST(RobustScores, FindOneThatIsFarFromTheOthers) {
  const std::vector<double> scores = RobustScores({10, 11, 9, 10.5, 9.5, 30});
  for (std::size_t i = 0; i < 5; ++i) EXPECT_LT(std::abs(scores[i]), kOutlierScore);
  EXPECT_GT(scores[5], kOutlierScore);
  EXPECT_TRUE(std::isnan(RobustScores({1, 2, 3, 90})[3])) << "too few to tell";
  EXPECT_TRUE(std::isnan(RobustScores({1, 1, 1, 1, 9})[4])) << "no spread to measure by";
}

// subject + session + error, as a reliability study draws them.
struct Components {
  double subject_sd = 2, session_sd = 0.5, error_sd = 1, offset = 0.7;
};

// The part of tables whose intervals hold the truth: of ICC(2,1), ICC(3,1), SEM, and of the offset between two
// conditions of the same subjects.
Eigen::Array4d Coverage(const Components& of, int subjects, int sessions, int tables) {
  std::mt19937 random(20260714);
  std::normal_distribution<double> normal;
  const double s2 = of.subject_sd * of.subject_sd, j2 = of.session_sd * of.session_sd, e2 = of.error_sd * of.error_sd;
  const auto holds = [](const Estimate& e, double truth) {
    return e.interval.low <= truth && truth <= e.interval.high;
  };
  Eigen::Array4d held = Eigen::Array4d::Zero();
  for (int t = 0; t < tables; ++t) {
    Eigen::MatrixXd values(subjects, sessions);
    for (int j = 0; j < sessions; ++j) values.col(j).setConstant(of.session_sd * normal(random));
    std::vector<double> difference;
    for (int i = 0; i < subjects; ++i) {
      values.row(i).array() += of.subject_sd * normal(random);
      for (int j = 0; j < sessions; ++j) values(i, j) += of.error_sd * normal(random);
      difference.push_back(of.offset + of.error_sd * (normal(random) - normal(random)));
    }
    const MeanSquares ms = MeanSquaresOf(values);
    held +=
        Eigen::Array4d(holds(Icc2Single(ms), s2 / (s2 + j2 + e2)), holds(Icc3Single(ms), s2 / (s2 + e2)),
                       holds(StandardErrorOfMeasurement(ms), of.error_sd), holds(MeanOf(difference).mean, of.offset));
  }
  return held / tables;
}

// The exact intervals hold the truth in 95 of 100 tables: of 2000 within 3.3 standard deviations of the binomial
// (0.0049). That of ICC(2,1) rests on Satterthwaite's approximation, which with few judges errs on the wide side.
TEST(Intervals, HoldTheTruthAtTheNominalRate) {
  constexpr int kTables = 2000;
  constexpr double kNominal = 0.95, kSpread = 0.016;
  for (const int sessions : {2, 3}) {
    const Eigen::Array4d held = Coverage({}, 20, sessions, kTables);
    for (int i = 1; i < 4; ++i) EXPECT_NEAR(held[i], kNominal, kSpread) << i << " of " << sessions << " sessions";
    EXPECT_GT(held[0], kNominal - kSpread) << sessions << " sessions";
    EXPECT_LT(held[0], 0.99) << sessions << " sessions";
  }
}

}  // namespace
}  // namespace lake::reliability
