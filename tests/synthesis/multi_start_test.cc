#include "lake/synthesis/multi_start.h"

#include <gtest/gtest.h>

#include <vector>

namespace lake {
namespace {

struct PlannedEnd {
  double objective;
  bool is_usable = true;
  bool IsUsable() const { return is_usable; }
};

// Starts that lead to these ends in turn, until the best is confirmed.
synthesis::MultiStart<PlannedEnd> UntilConfirmed(const std::vector<PlannedEnd>& ends) {
  std::size_t next = 0;
  return synthesis::SolveFromEach(
      std::vector<linkage::Links>(ends.size()), [&](const linkage::Links&) { return ends[next++]; },
      synthesis::Until::kConfirmed);
}

TEST(MultiStart, EndsWhereASecondStartCameToTheBest) {
  EXPECT_EQ(UntilConfirmed({{150}, {150 + 1e-7}, {160}, {160}}).starts.size(), 2);
  const auto risen = UntilConfirmed({{140}, {150}, {150}, {160}});
  EXPECT_EQ(risen.starts.size(), 3);
  EXPECT_EQ(risen.Best().objective, 150);
}

TEST(MultiStart, GoesOnWhereTheBestStandsAlone) {
  EXPECT_EQ(UntilConfirmed({{150}, {140}, {140}, {140}}).starts.size(), 4);
  EXPECT_EQ(UntilConfirmed({{150, false}, {150}, {150, false}, {150}}).starts.size(), 4);
  const auto none = UntilConfirmed({{150, false}, {150, false}});
  EXPECT_EQ(none.starts.size(), 2);
  EXPECT_FALSE(none.IsSolved());
}

}  // namespace
}  // namespace lake
