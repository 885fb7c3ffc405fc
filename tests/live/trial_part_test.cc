// Which part of a session becomes its trial.
#include <gtest/gtest.h>

#include <vector>

#include "lake/live/joint_place.h"

namespace lake::test {
namespace {

using live::PartOfTrial;
using live::TrialPart;

TEST(TrialPart, IsAllThatWasAskedForWhereTheJointStayed) {
  const TrialPart all = PartOfTrial({}, {}, std::vector{3.0});
  EXPECT_EQ(all.begin_s, std::nullopt);
  EXPECT_EQ(all.end_s, std::nullopt);
  const TrialPart asked = PartOfTrial({.begin_s = 1, .end_s = 9}, {}, std::vector{3.0});
  EXPECT_EQ(asked.begin_s, 1);
  EXPECT_EQ(asked.end_s, 9);
}

TEST(TrialPart, BeginsWithTheLastMoveAfterWhichThereWasARise) {
  const TrialPart part = PartOfTrial({.begin_s = 1, .end_s = 30}, std::vector{8.0, 16.0}, std::vector{3.0, 10.0, 18.0});
  EXPECT_EQ(part.begin_s, 16);
  EXPECT_EQ(part.end_s, 30);
}

// Moved once more before the end: what follows is of another place.
TEST(TrialPart, EndsWithTheMoveAfterIt) {
  const TrialPart part = PartOfTrial({.begin_s = 1, .end_s = 30}, std::vector{8.0, 16.0}, std::vector{3.0, 10.0});
  EXPECT_EQ(part.begin_s, 8);
  EXPECT_EQ(part.end_s, 16);
  const TrialPart first = PartOfTrial({}, std::vector{8.0, 16.0}, std::vector{3.0});
  EXPECT_EQ(first.begin_s, std::nullopt);
  EXPECT_EQ(first.end_s, 8);
}

TEST(TrialPart, LooksAtTheRisesInIt) {
  const TrialPart part = PartOfTrial({.begin_s = 12, .end_s = 30}, std::vector{8.0, 16.0}, std::vector{3.0, 10.0});
  EXPECT_EQ(part.begin_s, 12);
  EXPECT_EQ(part.end_s, 30);
}

}  // namespace
}  // namespace lake::test
