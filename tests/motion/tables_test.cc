#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(MarkerCsv, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  motion::MarkerRecording recording;
  recording.frame = {0, 1};
  recording.time_s = {0.25, 0.25 + 1.0 / 60};
  recording.markers = {
      {"knee", {{{1.0 / 3, -2}, 0.02, motion::SampleStatus::kDetected}, {}}},
      {"hip_2", {{{5, 6}, 1.5, motion::SampleStatus::kFilled}, {{7, 8}, 0, motion::SampleStatus::kDetected}}}};
  motion::WriteMarkerCsv(folder / "tracks.csv", recording);
  EXPECT_THAT(ReadTextFile(folder / "tracks.csv"),
              HasSubstr("frame,time_s,knee_x_px,knee_y_px,knee_sigma_px,knee_status,hip_2_x_px"));
  const motion::MarkerRecording read = motion::ReadMarkerCsv(folder / "tracks.csv");
  EXPECT_EQ(read.unit, motion::LengthUnit::kPx);
  EXPECT_EQ(read.time_s, recording.time_s);
  ASSERT_TRUE(read.Find("hip_2"));
  EXPECT_EQ(read.Find("knee")->samples[0].position, recording.markers[0].samples[0].position);
  EXPECT_EQ(read.Find("knee")->samples[1].status, motion::SampleStatus::kMissing);
  EXPECT_EQ(read.Find("hip_2")->samples[0].status, motion::SampleStatus::kFilled);
  EXPECT_EQ(read.Find("ankle"), nullptr);
}

// Times and positions alone, as another program writes them.
TEST(MarkerCsv, ReadsTablesWithoutFramesSigmasAndStatuses) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "t.csv", "time_s,knee_x_mm,knee_y_mm\n0.5,10,-20\n0.6,,\n");
  const motion::MarkerRecording read = motion::ReadMarkerCsv(folder / "t.csv");
  EXPECT_EQ(read.frame, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(read.time_s, (std::vector<double>{0.5, 0.6}));
  const std::vector<motion::MarkerSample>& knee = read.markers.at(0).samples;
  EXPECT_EQ(knee[0].status, motion::SampleStatus::kDetected);
  EXPECT_EQ(knee[0].position, Eigen::Vector2d(10, -20));
  EXPECT_EQ(knee[0].sigma, 0) << "not known";
  EXPECT_EQ(knee[1].status, motion::SampleStatus::kMissing);
}

TEST(MarkerCsv, RefusesBadTables) {
  const TemporaryFolder folder;
  const auto read = [&](const char* text) {
    WriteTextFile(folder / "t.csv", text);
    motion::ReadMarkerCsv(folder / "t.csv");
  };
  const std::string head = "frame,time_s,k_x_px,k_y_px,k_sigma_px,k_status\n";
  EXPECT_THAT([&] { read("frame,time_s\n0,0\n"); }, ThrowsMessage<Error>(HasSubstr("no column of a marker")));
  EXPECT_THAT([&] { read((head + "0,0,1,2,0.1,seen\n").c_str()); },
              ThrowsMessage<Error>(HasSubstr("'seen' is not detected")));
  EXPECT_THAT([&] { read((head + "0,0,,2,0.1,detected\n").c_str()); },
              ThrowsMessage<Error>(HasSubstr("'k_x_px' is empty")));
  EXPECT_THAT([&] { read((head + "0,1,1,2,0.1,detected\n1,1,1,2,0.1,detected\n").c_str()); },
              ThrowsMessage<Error>(HasSubstr("t.csv:3: time_s does not increase")));
  EXPECT_THAT([&] { read((head + "0,0,1,2,-1,detected\n").c_str()); }, ThrowsMessage<Error>(HasSubstr("negative")));
  EXPECT_THAT([&] { read("k_x_px,k_y_px\n1,2\n"); }, ThrowsMessage<Error>(HasSubstr("no column 'time_s'")));
  EXPECT_THAT([&] { read("time_s,k_x_px\n0,2\n"); }, ThrowsMessage<Error>(HasSubstr("no column 'k_y_px'")));
}

TEST(KinematicsCsv, HasTheHipsFlexionWhereTheTrunkIsKnown) {
  const TemporaryFolder folder;
  motion::LegMotion motion;
  motion.frame = {0, 1};
  motion.time_s = {0, 0.1};
  motion.samples.resize(2);
  motion.samples[0].thigh_deg = -85;
  const auto table = [&] {
    motion::WriteKinematicsCsv(folder / "kinematics.csv", motion);
    return CsvTable::Read(folder / "kinematics.csv");
  };
  EXPECT_FALSE(table().Has("hip_deg"));
  motion.samples[0].trunk_deg = 25;
  EXPECT_EQ(table().Number(0, table().Column("hip_deg")), 110) << "seated and leaning forward";
  EXPECT_EQ(table().Number(1, table().Column("hip_deg")), std::nullopt);
}

TEST(KinematicsCsv, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  motion::LegMotion motion;
  motion.unit = motion::LengthUnit::kMm;
  motion.frame = {3, 4};
  motion.time_s = {0.1, 0.2};
  motion.samples.resize(2);
  motion.samples[0].ak = {10, 400};
  motion.samples[0].knee_deg = 88.5;
  motion.samples[0].repetition = 2;
  motion.samples[0].percent = 12.5;
  motion::WriteKinematicsCsv(folder / "kinematics.csv", motion);
  const motion::LegMotion read = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  EXPECT_EQ(read.unit, motion::LengthUnit::kMm);
  EXPECT_EQ(read.samples[0].ak, motion.samples[0].ak);
  EXPECT_EQ(read.samples[0].knee_deg, 88.5);
  EXPECT_EQ(read.samples[0].repetition, 2);
  EXPECT_FALSE(read.samples[1].repetition);
  EXPECT_TRUE(std::isnan(read.samples[1].knee_deg));
}

TEST(KinematicsCsv, RefusesTimesThatDoNotIncrease) {
  const TemporaryFolder folder;
  for (const double second_s : {0.1, 0.05}) {
    motion::LegMotion motion;
    motion.frame = {3, 4};
    motion.time_s = {0.1, second_s};
    motion.samples.resize(2);
    motion::WriteKinematicsCsv(folder / "kinematics.csv", motion);
    EXPECT_THAT([&] { motion::ReadKinematicsCsv(folder / "kinematics.csv"); },
                ThrowsMessage<Error>(HasSubstr("kinematics.csv:3: time_s does not increase")));
  }
}

TEST(EventsCsv, RefusesAnotherOrder) {
  const TemporaryFolder folder;
  const auto read = [&](const std::vector<motion::StsEvent>& events) {
    motion::WriteEventsCsv(folder / "events.csv", events);
    return motion::ReadEventsCsv(folder / "events.csv").size();
  };
  const motion::StsEvent onset{1, motion::StsEventKind::kOnset, 30, 0.5},
      standing{1, motion::StsEventKind::kStanding, 90, 1.5}, early{1, motion::StsEventKind::kStanding, 6, 0.1},
      next{2, motion::StsEventKind::kOnset, 90, 1.5};
  EXPECT_EQ(read({onset, standing, next}), 3u);
  EXPECT_THAT([&] { read({onset, early}); }, ThrowsMessage<Error>(HasSubstr("events.csv:3: time_s decreases")));
  EXPECT_THAT([&] { read({next, onset}); }, ThrowsMessage<Error>(HasSubstr("repetition 1 after repetition 2")));
}

TEST(EventsCsv, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  motion::WriteEventsCsv(folder / "events.csv", {{1, motion::StsEventKind::kSeatOff, 42, 0.7}});
  EXPECT_EQ(ReadTextFile(folder / "events.csv"), "repetition,event,frame,time_s\n1,seat_off,42,0.7\n");
  EXPECT_EQ(motion::ReadEventsCsv(folder / "events.csv")[0].kind, motion::StsEventKind::kSeatOff);
}

TEST(Leg, IsNamedByItsMarkersOrByWhereTheSubjectLooks) {
  using motion::Side;
  for (const char* name : {"L_knee", "LKNE", "L.ASIS+L.PSIS", "l_ankle", "Left ankle", "left", "hip_l", "KneeLeft"})
    EXPECT_EQ(motion::SideOfName(name), Side::kLeft) << name;
  for (const char* name : {"r_ankle", "RAJC", "R_HJC", "r.ASIS", "rightknee", "lateral_ankle_r", "LATERAL_ANKLE_R",
                           "LatMal.R", "r_ankle+r_mankle", "ankle right", "RLatMal"})
    EXPECT_EQ(motion::SideOfName(name), Side::kRight) << name;
  for (const char* name : {"lateral malleolus", "LATERAL", "rotula", "knee", "", "L_hip+R_hip"})
    EXPECT_EQ(motion::SideOfName(name), std::nullopt) << name;
  EXPECT_EQ(motion::NearLeg(motion::Facing::kLeft), Side::kLeft);
  EXPECT_EQ(motion::NearLeg(motion::Facing::kRight), Side::kRight);
}

}  // namespace
}  // namespace lake
