// A group's statistics of rows that are known.
#include "lake/cohort/group_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "lake/synth/population.h"

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

TEST(Group, ACohortOfThreeIsToldThatItsIccMeansNothingYet) {
  EXPECT_THAT(IccCaution(3),
              testing::AllOf(HasSubstr("With 3 participants an ICC means nothing yet"), HasSubstr("about 18")));
  EXPECT_EQ(IccCaution(18), "");
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

// What a rendered cohort would measure without error: 20 people, two sessions.
GroupData DrawnGroup(const synth::PopulationOptions& population) {
  GroupData group;
  group.quantities = {"offset_x_mm", "offset_y_mm", "knee_max_deg", "rise_s"};
  for (const synth::Session& session : DrawPopulation(population, {}))
    group.rows.push_back({session.participant,
                          session.session,
                          "",
                          "comparison",
                          {},
                          {{"offset_x_mm", session.exo.exo_knee_mm->x()},
                           {"offset_y_mm", session.exo.exo_knee_mm->y()},
                           {"knee_max_deg", session.human.seated_knee_deg},
                           {"rise_s", session.human.rise_s}}});
  return group;
}

// The population's own variances say the ICC, its means the offsets: 95 % intervals hold them in 95 % of populations.
TEST(Group, RecoversThePopulationItWasDrawnFrom) {
  synth::PopulationOptions of;
  of.people = 20;
  of.sessions = 2;
  const auto icc = [](double between_sd, double session_sd) {
    return between_sd * between_sd / (between_sd * between_sd + session_sd * session_sd);
  };
  const std::map<std::string, double> truth = {
      {"offset_x_mm", icc(of.exo_knee_sd_mm, of.exo_knee_session_sd_mm)},
      {"offset_y_mm", icc(of.exo_knee_sd_mm, of.exo_knee_session_sd_mm)},
      {"knee_max_deg", icc(of.seated_knee_sd_deg, of.seated_knee_session_sd_deg)},
      {"rise_s", icc(of.rise_sd_s, of.rise_session_sd_s)}};
  constexpr int kPopulations = 200;
  int icc2_holds = 0, icc3_holds = 0, offset_holds = 0;
  for (of.seed = 1; of.seed <= kPopulations; ++of.seed) {
    const GroupData group = DrawnGroup(of);
    for (const ReliabilityRow& row : ReliabilityOf(group)) {
      icc2_holds += row.icc2.interval.low <= truth.at(row.quantity) && truth.at(row.quantity) <= row.icc2.interval.high;
      icc3_holds += row.icc3.interval.low <= truth.at(row.quantity) && truth.at(row.quantity) <= row.icc3.interval.high;
    }
    std::vector<double> offsets;
    for (const std::string& participant : ParticipantsOf(group))
      offsets.push_back(*ValueOf(group, participant, "comparison", "offset_x_mm"));
    const reliability::Interval mean = reliability::MeanOf(offsets).mean.interval;
    offset_holds += mean.low <= of.exo_knee_mm.x() && of.exo_knee_mm.x() <= mean.high;
  }
  // Three standard errors of a rate of 0.95 in 800 and in 200.
  EXPECT_NEAR(icc2_holds / (4.0 * kPopulations), 0.95, 0.023);
  EXPECT_NEAR(icc3_holds / (4.0 * kPopulations), 0.95, 0.023);
  EXPECT_NEAR(offset_holds / (1.0 * kPopulations), 0.95, 0.046);
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

TEST(Group, OrdersDifferencesByTheirCertainty) {
  const auto differing = [](double mean_mm, double sd_mm, std::size_t subjects) {
    DifferenceRow row;
    row.difference.subjects = subjects;
    row.difference.standard_deviation = sd_mm;
    row.difference.mean.value = mean_mm;
    return row;
  };
  EXPECT_NEAR(differing(-6, 3, 9).StandardErrors(), -6, 1e-12);
  EXPECT_TRUE(std::isnan(differing(-6, 0, 1).StandardErrors()));
  // With eight degrees of freedom 2.306 standard errors are 95 %, and 3.833 are with ten comparisons.
  EXPECT_TRUE(differing(2.4, 3, 9).IsClearAmong(1));
  EXPECT_FALSE(differing(2.2, 3, 9).IsClearAmong(1));
  EXPECT_FALSE(differing(3.7, 3, 9).IsClearAmong(10));
  EXPECT_TRUE(differing(3.9, 3, 9).IsClearAmong(10));
  EXPECT_FALSE(differing(6, 0, 1).IsClearAmong(1));

  GroupData group = Group(6);
  for (GroupRow& row : group.rows)  // with the same scatter, a difference of 15 rather than 5
    if (row.trial == "exo" || row.trial == "human")
      row.values["knee_min_deg"] = row.values.at("knee_range_deg") + (row.trial == "exo" ? 20 : 0);
  group.quantities.emplace_back("knee_min_deg");
  const std::vector<DifferenceRow> rows = DifferencesOf(group);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_GT(std::abs(rows[0].StandardErrors()), std::abs(rows[1].StandardErrors()));
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
  one.fill(10);
  two.fill(20);
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
