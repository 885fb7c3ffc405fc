// A misspelt name is followed by the one that was meant, and by nothing where none is near.
#include "lake/core/nearest_name.h"

#include <gtest/gtest.h>

namespace lake {
namespace {

const std::vector<std::string> kNames = {"ankle", "knee", "hip", "waist", "exo_knee"};

TEST(DidYouMean, FindsTheNameOfWhichALetterIsExchangedAddedMissingOrSwapped) {
  for (const char* misspelt : {"ankl", "anklee", "amkle", "akle", "anlke", "Ankle"})
    EXPECT_EQ(DidYouMean(misspelt, kNames), "; did you mean 'ankle'?") << misspelt;
  EXPECT_EQ(DidYouMean("exo-knee", kNames), "; did you mean 'exo_knee'?");
}

TEST(DidYouMean, SaysNothingWhereNoNameIsNear) {
  EXPECT_EQ(DidYouMean("shoulder", kNames), "");
  EXPECT_EQ(DidYouMean("", kNames), "");
  EXPECT_EQ(DidYouMean("knee", {}), "");
  EXPECT_EQ(DidYouMean(std::string(1 << 20, 'k'), kNames), "");
}

}  // namespace
}  // namespace lake
