#include "lake/certificate/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace lake {
namespace {

// Draws intervals and points in them; what long double (64 bits of mantissa) finds at the points must be enclosed.
class IntervalTest : public ::testing::Test {
 protected:
  certificate::Interval Draw(double low, double high) {
    std::uniform_real_distribution<double> uniform(low, high);
    const double a = uniform(random_), b = uniform(random_);
    const double narrow = std::uniform_real_distribution<double>(0, 1)(random_) < 0.3 ? 1e-12 : 1;
    return {std::min(a, a + (b - a) * narrow), std::max(a, a + (b - a) * narrow)};
  }
  double PointIn(const certificate::Interval& a) {
    return std::clamp(std::uniform_real_distribution<double>(a.lower, a.upper)(random_), a.lower, a.upper);
  }
  static void ExpectEncloses(const certificate::Interval& a, long double exact) {
    EXPECT_LE(static_cast<long double>(a.lower), exact);
    EXPECT_GE(static_cast<long double>(a.upper), exact);
  }
  std::mt19937_64 random_{4711};
};

TEST_F(IntervalTest, ArithmeticEncloses) {
  for (int i = 0; i < 20000; ++i) {
    const certificate::Interval a = Draw(-300, 300), b = Draw(-300, 300);
    const long double x = PointIn(a), y = PointIn(b);
    ExpectEncloses(a + b, x + y);
    ExpectEncloses(a - b, x - y);
    ExpectEncloses(a * b, x * y);
    if (!b.Contains(0)) ExpectEncloses(a / b, x / y);
    ExpectEncloses(certificate::Square(a), x * x);
    ExpectEncloses(certificate::Max(a, b), std::max(x, y));
    if (a.lower > 0) ExpectEncloses(certificate::Sqrt(a), std::sqrt(x));
  }
}

TEST_F(IntervalTest, UnboundedOperandsGiveNumbers) {
  using certificate::Interval;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  // But for the least number, by which a product is widened.
  constexpr double kLeast = std::numeric_limits<double>::denorm_min();
  const Interval all{-kInf, kInf};
  for (const Interval& nothing : {all * Interval(0, 0), Interval(0, 0) * all}) {
    EXPECT_GE(nothing.lower, -kLeast);
    EXPECT_LE(nothing.upper, kLeast);
    EXPECT_TRUE(nothing.Contains(0));
  }
  const Interval half = all * Interval(0, 2);
  EXPECT_EQ(half.lower, -kInf);
  EXPECT_EQ(half.upper, kInf);
  const Interval quotient = Interval(1, kInf) / Interval(2, kInf);
  EXPECT_LE(quotient.lower, 0);
  EXPECT_EQ(quotient.upper, kInf);
}

TEST_F(IntervalTest, FunctionsEnclose) {
  for (int i = 0; i < 20000; ++i) {
    const certificate::Interval angle = Draw(-7, 7), cosine = Draw(-1, 1);
    ExpectEncloses(certificate::Sin(angle), std::sin(static_cast<long double>(PointIn(angle))));
    ExpectEncloses(certificate::Cos(angle), std::cos(static_cast<long double>(PointIn(angle))));
    ExpectEncloses(certificate::ArcCos(cosine), std::acos(static_cast<long double>(PointIn(cosine))));
    const certificate::Interval x = Draw(0, 100), y = Draw(-100, 100);
    ExpectEncloses(certificate::AngleFromY(x, y),
                   std::atan2(static_cast<long double>(PointIn(x)), static_cast<long double>(PointIn(y))));
  }
}

TEST_F(IntervalTest, EnclosesAreTight) {
  for (int i = 0; i < 2000; ++i) {
    const double x = PointIn({0.1, 3});
    // A few ulps of the result: 4 of the library's, 1 of arithmetic, and those of the shift by pi / 2.
    EXPECT_LT(certificate::Sin(x).Width(), 1e-14);
    EXPECT_LT(certificate::Cos(x).Width(), 1e-14);
    EXPECT_LT(certificate::Sqrt(x).Width(), 1e-15);
    EXPECT_LT((certificate::Interval(x) * 3.0).Width(), 4e-15);
  }
}

TEST_F(IntervalTest, ExtremaInsideAreSeen) {
  EXPECT_EQ(certificate::Cos({-0.5, 0.5}).upper, 1);
  EXPECT_EQ(certificate::Cos({3, 3.3}).lower, -1);
  EXPECT_EQ(certificate::Sin({1, 2}).upper, 1);
  EXPECT_EQ(certificate::Square({-2, 1}).lower, 0);
}

TEST_F(IntervalTest, UndefinedOperandsAreEmptyOrTheWholeLine) {
  EXPECT_TRUE(certificate::Sqrt({-2, -1}).IsEmpty());
  EXPECT_TRUE(certificate::ArcCos({1.5, 2}).IsEmpty());
  EXPECT_EQ(certificate::ArcCos({0.5, 2}).lower, 0);
  EXPECT_TRUE(std::isinf((certificate::Interval(1) / certificate::Interval(-1, 1)).upper));
  EXPECT_LT(certificate::kPiInterval.lower, 3.14159265358979323846L);
  EXPECT_GT(certificate::kPiInterval.upper, 3.14159265358979323846L);
}

}  // namespace
}  // namespace lake
