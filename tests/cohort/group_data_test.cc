// What a group takes of a trial's folder.
#include "lake/cohort/group_data.h"

#include <gtest/gtest.h>

#include "lake/cohort/group_statistics.h"
#include "lake/core/csv.h"
#include "lake/core/run.h"
#include "lake/motion/leg_motion.h"
#include "temporary_folder.h"

namespace lake::cohort {
namespace {

class TrialFolder : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_ / "human"); }

  // One rise from 90 to 10 degrees with segments of 400 mm.
  void WriteRise(motion::LengthUnit unit) {
    motion::LegMotion leg;
    leg.unit = unit;
    for (int i = 0; i <= 10; ++i) {
      motion::LegSample sample;
      sample.ak = sample.kh = {0, 400};
      sample.knee_deg = 90 - 8 * i;
      sample.knee_sigma_deg = 0.1;
      sample.repetition = 1;
      sample.percent = 10 * i;
      leg.frame.push_back(i);
      leg.time_s.push_back(0.1 * i);
      leg.samples.push_back(sample);
    }
    motion::WriteKinematicsCsv(folder_ / "human/kinematics.csv", leg);
  }

  void WriteMeasures(const std::string& five_times) {
    WriteTextFile(folder_ / "human/sit_to_stand.csv",
                  "repetition,onset_s,rise_s,transfer_s,power_w_kg,five_times_s,rise_s_sd\n"
                  "1,7.5,1,0.25,3.5,,0.02\n"
                  "five_times," +
                      five_times + "\n");
  }

  GroupData Read(const std::set<std::string>& steps = {"human"}) {
    return ReadGroup({{.participant = "sub-1", .session = "", .run = "", .folder = folder_.Path(), .steps = steps}});
  }

  TemporaryFolder folder_;
};

TEST_F(TrialFolder, GivesEachRiseAndTheFiveTimesTest) {
  WriteRise(motion::LengthUnit::kMm);
  WriteMeasures("7.5,1.25,,4.5,12,0.1");
  const GroupData group = Read();
  ASSERT_EQ(group.rows.size(), 2u);
  const auto& rise = group.rows[0].values;
  EXPECT_EQ(group.rows[0].repetition, 1);
  EXPECT_EQ(rise.at("rise_s"), 1);
  EXPECT_EQ(rise.at("transfer_s"), 0.25);
  EXPECT_EQ(rise.at("power_w_kg"), 3.5);
  EXPECT_NEAR(rise.at("knee_range_deg"), 80, 1e-9);
  EXPECT_FALSE(rise.contains("onset_s")) << "a time in the recording says nothing of the person";
  EXPECT_FALSE(rise.contains("rise_s_sd"));
  const auto& whole = group.rows[1].values;
  EXPECT_FALSE(group.rows[1].repetition.has_value());
  EXPECT_EQ(whole.at("five_times_s"), 12);
  EXPECT_EQ(whole.at("five_times_power_w_kg"), 4.5);
  EXPECT_NEAR(whole.at("shank_mm"), 400, 1e-9);
}

// The joint misalignment is the headline of a comparison; the offset that explains the paths is another quantity.
TEST_F(TrialFolder, GivesTheJointMisalignment) {
  std::filesystem::create_directories(folder_ / "comparison");
  WriteTextFile(folder_ / "comparison/misalignment.csv", "percent,distance_mm,relative_error\n0,20,0.05\n");
  const auto write = [&](const std::string& joint) {
    WriteTextFile(folder_ / "comparison/comparison.json",
                  R"({"metrics": {"rms_mm": 31}, "joint": )" + joint +
                      R"(, "decomposition": {"placement": {"fraction": 1}, "timing": {"fraction": 0},
                        "shape": {"fraction": 0}, "offset_mm": [13.9, -19.9]}})");
  };
  write(R"({"rms_mm": 26.9, "max_mm": 28, "relative_rms": 0.06, "angle_rms_deg": 2.5, "offset_mm": [18, -20]})");
  const GroupData group = Read({"comparison"});
  const auto& values = group.rows.at(0).values;
  EXPECT_EQ(values.at("joint_rms_mm"), 26.9);
  EXPECT_EQ(values.at("joint_max_mm"), 28);
  EXPECT_EQ(values.at("joint_offset_x_mm"), 18);
  EXPECT_EQ(values.at("joint_offset_y_mm"), -20);
  EXPECT_EQ(values.at("rms_mm"), 31);
  for (const MainQuantity& main : MainQuantities())
    if (main.label == std::string("joint in front of the knee")) {
      EXPECT_EQ(main.name, std::string("joint_offset_x_mm"));
    }
  write("null");
  EXPECT_FALSE(Read({"comparison"}).rows.at(0).values.contains("joint_rms_mm")) << "the trial shows no knee of its own";
}

TEST_F(TrialFolder, GivesTheCentreOfMassOfEachRiseWhereItsLoadsAreKnown) {
  WriteRise(motion::LengthUnit::kMm);
  WriteMeasures("7.5,1.25,,4.5,12,0.1");
  std::filesystem::create_directories(folder_ / "loads");
  WriteTextFile(folder_ / "loads/momentum.csv",
                "repetition,com_seat_off_mm,com_seat_off_mm_sd,com_upward_max_ns\n2,-90,9,80\n1,-120,8,\n");
  EXPECT_FALSE(Read().rows[0].values.contains("com_seat_off_mm")) << "of a study without loads";
  const auto rise = Read({"human", "loads"}).rows[0].values;
  EXPECT_EQ(rise.at("com_seat_off_mm"), -120);
  EXPECT_FALSE(rise.contains("com_seat_off_mm_sd"));
  EXPECT_FALSE(rise.contains("com_upward_max_ns"));
  std::filesystem::remove(folder_ / "loads/momentum.csv");
  const auto earlier = Read({"human", "loads"}).rows[0].values;
  EXPECT_FALSE(earlier.contains("com_seat_off_mm")) << "of loads by a version that did not write it";
  EXPECT_TRUE(earlier.contains("rise_s"));
}

TEST_F(TrialFolder, GivesTheCentreOfMassAsTheTrialItselfHasItWhereItDoes) {
  WriteRise(motion::LengthUnit::kMm);
  WriteTextFile(folder_ / "human/sit_to_stand.csv", "repetition,com_seat_off_mm,com_upward_max_mm_s\n1,-110,\n");
  EXPECT_EQ(Read().rows[0].values.at("com_seat_off_mm"), -110) << "of a study without loads";
  std::filesystem::create_directories(folder_ / "loads");
  WriteTextFile(folder_ / "loads/momentum.csv",
                "repetition,com_seat_off_mm,com_upward_max_mm_s,com_upward_max_ns\n1,-120,1000,70\n");
  const auto rise = Read({"human", "loads"}).rows[0].values;
  EXPECT_EQ(rise.at("com_seat_off_mm"), -110);
  EXPECT_FALSE(rise.contains("com_upward_max_mm_s")) << "of the trial's table, which leaves it empty";
  EXPECT_EQ(rise.at("com_upward_max_ns"), 70);
}

TEST_F(TrialFolder, HasNoRowForTheWholeTrialOfWhichNothingIsKnown) {
  WriteRise(motion::LengthUnit::kPx);
  WriteMeasures(",,,,,");
  const GroupData group = Read();
  ASSERT_EQ(group.rows.size(), 1u);
  EXPECT_EQ(group.rows[0].repetition, 1);
}

}  // namespace
}  // namespace lake::cohort
