// Quantiles against printed tables (NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7).
#include "lake/core/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lake {
namespace {

TEST(Distributions, HaveTheQuantilesOfTheTables) {
  EXPECT_NEAR(NormalQuantile(0.975), 1.960, 5e-4);
  EXPECT_NEAR(StudentQuantile(1, 0.975), 12.706, 5e-4);
  EXPECT_NEAR(StudentQuantile(9, 0.975), 2.262, 5e-4);
  EXPECT_NEAR(ChiSquaredQuantile(4, 0.025), 0.484, 5e-4);
  EXPECT_NEAR(ChiSquaredQuantile(4, 0.975), 11.143, 5e-4);
  EXPECT_NEAR(FisherQuantile(3, 7, 0.95), 4.347, 5e-4);
}

TEST(Distributions, StudentsBecomesTheNormalOne) {
  EXPECT_DOUBLE_EQ(StudentQuantile(std::numeric_limits<double>::infinity(), 0.975), NormalQuantile(0.975));
}

TEST(Distributions, AreNotFiniteWithoutDegreesOfFreedom) {
  EXPECT_FALSE(std::isfinite(FisherQuantile(0, 3, 0.975)));
}

}  // namespace
}  // namespace lake
