// Trials as motion data in the order of BIDS.
#include "lake/cohort/motion_files.h"

#include <gtest/gtest.h>

#include "cohort/bids_rules.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

class MotionFiles : public testing::Test {
 protected:
  MotionFiles() {
    fs::create_directories(folder_ / "human");
    motion::LegMotion leg;
    motion::MarkerRecording markers;
    leg.unit = markers.unit = motion::LengthUnit::kMm;
    markers.markers = {{"ankle", {}}, {"knee", {}}};
    for (int i = 0; i < 5; ++i) {
      leg.frame.push_back(i);
      leg.time_s.push_back(2 + i / 50.0);
      leg.samples.emplace_back();
      leg.samples.back().knee_deg = i == 3 ? NAN : 90 - i;
      for (motion::MarkerTrack& marker : markers.markers)
        marker.samples.push_back({{1.5 * i, 400}, 0.1, motion::SampleStatus::kDetected});
    }
    markers.frame = leg.frame;
    markers.time_s = leg.time_s;
    markers.markers[1].samples[2].status = motion::SampleStatus::kMissing;
    motion::WriteKinematicsCsv(folder_ / "human/kinematics.csv", leg);
    motion::WriteEventsCsv(folder_ / "human/events.csv", {{1, motion::StsEventKind::kOnset, 1, 2.02}});
    motion::WriteMarkerCsv(folder_ / "human/trajectory.csv", markers);
  }

  TemporaryFolder folder_;
};

TEST_F(MotionFiles, KeepTheRulesAndHoldTheTrial) {
  const std::string stem = "sub-01_ses-2_task-sitstand_tracksys-lake_acq-human_run-3";
  cohort::WriteMotionFiles(folder_.Path(), {"sub-01_ses-2", "run-3", "sitstand"}, folder_ / "motion");
  ExpectMotionHolds(folder_ / ("motion/" + stem + "_motion.tsv"));
  const auto samples = TsvRows(folder_ / ("motion/" + stem + "_motion.tsv"));
  EXPECT_EQ(samples.size(), 5u);
  EXPECT_EQ(samples[3][1], "n/a") << "the knee angle is not known there";
  EXPECT_EQ(samples[2][4], "n/a") << "the knee was not seen";
  EXPECT_EQ(samples[4][2], "6");
  EXPECT_NEAR(ReadJsonFile(folder_ / ("motion/" + stem + "_motion.json"))["SamplingFrequency"].get<double>(), 50, 1e-9);
  const auto events = TsvRows(folder_ / ("motion/" + stem + "_events.tsv"));
  EXPECT_NEAR(*ParseNumber(events[1][0]), 0.02, 1e-12) << "from the first sample";
  EXPECT_EQ(events[1][2], "onset");
}

TEST_F(MotionFiles, OfTheLastTimeGo) {
  cohort::WriteMotionFiles(folder_.Path(), {"sub-01", "", "sitstand"}, folder_ / "motion");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "motion"), {}), 5);
  fs::remove_all(folder_ / "human");
  cohort::WriteMotionFiles(folder_.Path(), {"sub-01", "", "sitstand"}, folder_ / "motion");
  EXPECT_TRUE(fs::is_empty(folder_ / "motion"));
}

}  // namespace
}  // namespace lake
