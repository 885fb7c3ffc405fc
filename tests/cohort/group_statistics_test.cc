// A group's statistics of rows that are known.
#include "lake/cohort/group_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace lake::cohort {
namespace {

using testing::HasSubstr;

// Participant i's knee range in a session and repetition.
void Add(GroupData& group, int i, const std::string& session, const std::string& trial, int repetition, double value) {
  group.rows.push_back({"sub-" + std::to_string(i), session, "", trial, repetition, {{"knee_range_deg", value}}});
}

GroupData Group(int participants) {
  GroupData group;
  group.quantities = {"knee_range_deg"};
  for (int i = 0; i < participants; ++i)
    for (const int session : {0, 1})
      for (const int repetition : {1, 2}) {
        const double value = 80 + 2 * i + 0.3 * session + 0.1 * repetition * (i % 2 ? 1 : -1);
        Add(group, i, session ? "ses-2" : "ses-1", "human", repetition, value);
        Add(group, i, session ? "ses-2" : "ses-1", "exo", repetition, value - 5 - 0.5 * (i % 3));
      }
  return group;
}

TEST(Group, ComparesSessionsByTheirMeans) {
  const std::vector<ReliabilityRow> rows = ReliabilityOf(Group(6));
  ASSERT_EQ(rows.size(), 4u) << "two trials, across sessions and repetitions";
  EXPECT_EQ(rows[0].across, "session");
  EXPECT_EQ(rows[0].squares.targets, 6);
  EXPECT_EQ(rows[0].squares.judges, 2);
  EXPECT_NEAR(rows[0].agreement.bias.value, 0.3, 1e-12) << "second minus first";
  EXPECT_NEAR(rows[0].sem.value, 0, 1e-6) << "but for the bias sessions are the same";
  EXPECT_NEAR(rows[0].icc3.value, 1, 1e-9);
  EXPECT_LT(rows[0].icc2.value, 1 - 1e-4) << "the bias counts";
  EXPECT_EQ(rows[1].across, "repetition");
  EXPECT_NEAR(rows[1].agreement.bias.value, 0, 1e-12) << "up in odd, down in even ones";
  EXPECT_GT(rows[1].sem.value, 0.05);
}

TEST(Group, LeavesOutWhoMissesASession) {
  GroupData group = Group(6);
  std::erase_if(group.rows, [](const GroupRow& row) { return row.participant == "sub-2" && row.session == "ses-2"; });
  EXPECT_EQ(ReliabilityOf(group)[0].squares.targets, 5);
  std::erase_if(group.rows, [](const GroupRow& row) { return row.participant != "sub-0" && row.session == "ses-2"; });
  for (const ReliabilityRow& row : ReliabilityOf(group))
    EXPECT_EQ(row.across, "repetition") << "nobody has two sessions";
}

TEST(Group, PairsTrialsOfTheSamePerson) {
  GroupData group = Group(6);
  std::erase_if(group.rows, [](const GroupRow& row) { return row.participant == "sub-5" && row.trial == "exo"; });
  const std::vector<DifferenceRow> rows = DifferencesOf(group);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].difference.subjects, 5u);
  EXPECT_NEAR(rows[0].difference.mean.value, -5 - 0.5 * (0 + 1 + 2 + 0 + 1) / 5, 1e-12);
  EXPECT_LT(rows[0].difference.mean.interval.high, 0);
}

TEST(Group, SaysWhoStandsOutAndWhy) {
  GroupData group = Group(8);
  EXPECT_TRUE(OutliersOf(group).empty());
  for (GroupRow& row : group.rows)
    if (row.participant == "sub-3" && row.trial == "human") row.values["knee_range_deg"] = 30;
  const std::vector<OutlierRow> rows = OutliersOf(group);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].participant, "sub-3");
  EXPECT_THAT(rows[0].Why(), HasSubstr("knee range, human 30.0 °, median 8"));
}

TEST(Group, MeansCurvesByPersonFirst) {
  GroupData group;
  Curve one, two;
  one.fill(10), two.fill(20);
  for (int i = 0; i < 3; ++i) group.curves.push_back({"sub-1", "human", "knee_deg", one});
  two[7] = NAN;
  group.curves.push_back({"sub-2", "human", "knee_deg", two});
  const std::vector<CurveRow> rows = CurvesOf(group);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].percent[0].subjects, 2u);
  EXPECT_NEAR(rows[0].percent[0].mean.value, 15, 1e-12) << "a person who rose three times counts once";
  EXPECT_EQ(rows[0].percent[7].subjects, 1u);
  EXPECT_TRUE(std::isnan(rows[0].percent[7].mean.interval.low));
}

}  // namespace
}  // namespace lake::cohort
