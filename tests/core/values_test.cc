// Small texts and values at the boundary: NAME=VALUE, numbers that may be undefined.
#include <gmock/gmock.h>

#include <cmath>

#include "lake/core/deviation_text.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/name_value.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Pair;
using testing::ThrowsMessage;

TEST(SplitNameValue, SplitsAtTheFirstEqualsSign) {
  EXPECT_THAT(SplitNameValue("--seed", "knee=3,4@5"), Pair("knee", "3,4@5"));
  EXPECT_THAT(SplitNameValue("--map", "a=b=c"), Pair("a", "b=c"));
  EXPECT_THAT(SplitNameValue("--map", "a="), Pair("a", ""));
}

TEST(SplitNameValue, SaysWhichOptionHasNoName) {
  for (const char* text : {"", "knee", "=3"})
    EXPECT_THAT([&] { SplitNameValue("--seed", text); }, ThrowsMessage<UsageError>(HasSubstr("--seed '"))) << text;
}

TEST(DeviationText, IsNeverZero) {
  EXPECT_EQ(DeviationText(0.0123, 3, "°"), "0.012°");
  EXPECT_EQ(DeviationText(0.0005, 3, "°"), "0.001°");
  EXPECT_EQ(DeviationText(0.00049, 3, "°"), "< 0.001°");
  EXPECT_EQ(DeviationText(0, 2, " mm"), "< 0.01 mm");
  EXPECT_EQ(DeviationText(std::nan(""), 2, " mm"), "unknown");
}

TEST(NumberOrNaN, IsNaNForNullAndAnErrorForText) {
  const std::vector<double> numbers = NumbersOrNaN(Json::parse("[1.5, null, -2]"));
  EXPECT_EQ(numbers[0], 1.5);
  EXPECT_TRUE(std::isnan(numbers[1]));
  EXPECT_EQ(numbers[2], -2);
  EXPECT_THROW(NumberOrNaN(Json("1.5")), Json::type_error);
}

}  // namespace
}  // namespace lake
