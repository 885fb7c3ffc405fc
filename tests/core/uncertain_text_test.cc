// Numbers rounded to what is known of them.
#include "lake/core/uncertain_text.h"

#include <gtest/gtest.h>

namespace lake {
namespace {

TEST(UncertainText, TheUncertaintysFirstDigitIsTheLastOne) {
  EXPECT_EQ(KnownText(17.9, 9, 1), "18");
  EXPECT_EQ(KnownText(4.7, 9, 1), "5");
  EXPECT_EQ(KnownText(36.72, 0.43, 1), "36.7");
  EXPECT_EQ(KnownText(-32.04, 9.2, 1), "−32");
  EXPECT_EQ(KnownText(142.2, 30, 1), "140");
  EXPECT_EQ(KnownText(0.02714, 0.0032, 1), "0.027");
}

// ± 1.4 rounded to one digit would be 40 % off.
TEST(UncertainText, AOneHasASecondDigit) {
  EXPECT_EQ(KnownText(2.6194, 0.14, 1), "2.62");
  EXPECT_EQ(KnownText(2.6194, 0.2, 1), "2.6");
  EXPECT_EQ(KnownText(2.6194, 0.199, 1), "2.6");
  EXPECT_EQ(KnownText(123.4, 12, 1), "123");
}

TEST(UncertainText, WithoutAnUncertaintyDecimalsAreGiven) {
  EXPECT_EQ(KnownText(2.6194, std::nan(""), 1), "2.6");
  EXPECT_EQ(KnownText(2.6194, 0, 2), "2.62");
  EXPECT_EQ(RoundedText(std::nan(""), 2), "–");
  EXPECT_EQ(RoundedText(-0.001, 2), "0.00");
}

TEST(UncertainText, TheUncertaintyIsRoundedAsTheValueIs) {
  EXPECT_EQ(PlusMinusText(374.0213, 1.3672, 2), "374.0 ± 1.4");
  EXPECT_EQ(PlusMinusText(1234, 87, 2), "1230 ± 90");
  EXPECT_EQ(PlusMinusText(2.6194, 0, 2), "2.62 ± 0.00");
}

TEST(UncertainText, DifferencesHaveASign) {
  EXPECT_EQ(WithSign(PlusMinusText(0.0213, 0.0041, 3)), "+0.021 ± 0.004");
  EXPECT_EQ(WithSign(SignificantText(-2.4e-6, 2)), "−0.0000024");
  EXPECT_EQ(WithSign(RoundedText(std::nan(""), 1)), "–");
}

TEST(UncertainText, SignificantDigitsAreWrittenOut) {
  EXPECT_EQ(SignificantText(35, 4), "35");
  EXPECT_EQ(SignificantText(2345, 3), "2350");
  EXPECT_EQ(SignificantText(99999.6, 5), "100000");
  EXPECT_EQ(SignificantText(0.02714, 2), "0.027");
  EXPECT_EQ(SignificantText(-7.30, 3), "−7.3");
  EXPECT_EQ(SignificantText(2.4e-6, 2), "0.0000024");
  EXPECT_EQ(SignificantText(0, 3), "0");
  EXPECT_EQ(SignificantText(std::nan(""), 3), "–");
}

}  // namespace
}  // namespace lake
