// Angles, distances and speeds of markers whose movement is known.
#include "lake/gait/marker_measures.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "lake/core/csv.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using gait::MarkerMeasure;
using testing::ElementsAre;
using testing::HasSubstr;

// An arm that bends between 20 and 140 degrees at 0.5 Hz, its shoulder moving to the right at 50 mm/s.
constexpr double kHz = 100, kUpper_mm = 300, kFore_mm = 250, kShift_mm_s = 50;

double ElbowDeg(double t) {
  return 80 + 60 * std::sin(kPi * t);
}
double ElbowDegS(double t) {
  return 60 * kPi * std::cos(kPi * t);
}

motion::MarkerRecording Arm(double sigma, unsigned seed, bool says_sigma, int frames = 600) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (const char* name : {"shoulder", "elbow", "wrist"}) recording.markers.push_back({name, {}});
  for (int i = 0; i < frames; ++i) {
    const double t = i / kHz, turn = (180 - ElbowDeg(t)) * kPi / 180;
    const Vector2d shoulder(kShift_mm_s * t, 0), elbow = shoulder - Vector2d(0, kUpper_mm),
                                                 wrist = elbow + kFore_mm * Vector2d(std::sin(turn), -std::cos(turn));
    recording.frame.push_back(i), recording.time_s.push_back(t);
    for (std::size_t m = 0; const Vector2d& place : {shoulder, elbow, wrist})
      recording.markers[m++].samples.push_back(
          {place + Vector2d(normal(random), normal(random)), says_sigma ? sigma : 0, motion::SampleStatus::kDetected});
  }
  return recording;
}

const std::vector<MarkerMeasure> kMeasures = {{MarkerMeasure::Kind::kAngle, "elbow", {"shoulder", "elbow", "wrist"}},
                                              {MarkerMeasure::Kind::kDistance, "reach", {"shoulder", "wrist"}},
                                              {MarkerMeasure::Kind::kSpeed, "glide", {"shoulder"}}};

TEST(MarkerMeasures, AreRightAndKnowHowWell) {
  for (const bool says_sigma : {true, false}) {
    std::vector<double> angle, angle_rate, reach, glide;  // errors in their SDs
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const auto courses = gait::MeasureMarkers(Arm(0.5, seed, says_sigma), kMeasures);
      for (std::size_t i = 50; i < 550; i += 25) {
        const double t = static_cast<double>(i) / kHz, deg = ElbowDeg(t);
        angle.push_back((courses[0].value[i] - deg) / courses[0].sd[i]);
        angle_rate.push_back((courses[0].rate[i] - ElbowDegS(t)) / courses[0].rate_sd[i]);
        const double length = std::sqrt(kUpper_mm * kUpper_mm + kFore_mm * kFore_mm -
                                        2 * kUpper_mm * kFore_mm * std::cos(deg * kPi / 180));
        reach.push_back((courses[1].value[i] - length) / courses[1].sd[i]);
        glide.push_back((courses[2].value[i] - kShift_mm_s) / courses[2].sd[i]);
        EXPECT_LT(courses[0].sd[i], 0.1) << "0.5 mm at 250 mm are 0.11 degrees in one frame";
      }
    }
    // 100 errors, neighbours of one smoothing: their RMS is known to a fifth, and the prior adds as much again.
    for (const std::vector<double>* errors : {&angle, &angle_rate, &reach, &glide}) {
      EXPECT_GT(RootMeanSquare(*errors), 0.6) << says_sigma << " " << errors - &angle;
      EXPECT_LT(RootMeanSquare(*errors), 1.4) << says_sigma;
    }
  }
}

TEST(MarkerMeasures, LeaveGapsOpen) {
  motion::MarkerRecording arm = Arm(0.2, 3, true);
  for (std::size_t i = 200; i < 230; ++i) arm.markers[2].samples[i].status = motion::SampleStatus::kMissing;
  for (std::size_t i = 300; i < 310; ++i) arm.markers[1].samples[i].status = motion::SampleStatus::kFilled;
  const auto courses = gait::MeasureMarkers(arm, kMeasures);
  EXPECT_TRUE(std::isnan(courses[0].value[215]) && std::isnan(courses[1].sd[215]));
  EXPECT_TRUE(std::isnan(courses[0].value[305])) << "what was filled in is no measurement";
  EXPECT_TRUE(std::isfinite(courses[1].value[305]) && std::isfinite(courses[2].value[215]));
  const TemporaryFolder folder;
  gait::WriteMeasuresCsv(folder / "measures.csv", arm, courses);
  const CsvTable table = CsvTable::Read(folder / "measures.csv");
  EXPECT_THAT(table.Header(),
              ElementsAre("frame", "time_s", "elbow_deg", "elbow_sd_deg", "elbow_deg_s", "elbow_sd_deg_s", "reach_mm",
                          "reach_sd_mm", "reach_mm_s", "reach_sd_mm_s", "glide_mm_s", "glide_sd_mm_s"));
  EXPECT_FALSE(table.Number(215, table.Column("elbow_deg")));
  const Json json = gait::MeasuresJson(arm, courses);
  EXPECT_NEAR(json["elbow"]["largest"]["value"], 140, 0.5);
  EXPECT_EQ(json["elbow"]["frames"], 560);
}

TEST(MarkerMeasures, AreGivenByName) {
  std::vector<MarkerMeasure> measures;
  OptionList options;
  gait::Describe(measures, options);
  const auto give = [&](std::size_t option, const OptionTexts& texts) {
    options.All()[option].SetFromCommandLine(texts);
  };
  give(0, {"elbow=shoulder,elbow,wrist"});
  give(1, {"reach=shoulder,wrist", "fore=elbow,wrist"});
  ASSERT_EQ(measures.size(), 3u);
  EXPECT_EQ(measures[0].name, "elbow");
  EXPECT_THAT(measures[2].markers, ElementsAre("elbow", "wrist"));
  EXPECT_EQ(options.All()[1].Text(), "reach=shoulder,wrist fore=elbow,wrist");
  const auto said = [&](std::size_t option, const OptionTexts& texts) -> std::string {
    return MessageOf<UsageError>([&] {
      give(option, texts);
      options.RunChecks();
    });
  };
  EXPECT_THAT(said(0, {"elbow=shoulder,elbow"}), HasSubstr("NAME=A,B,C"));
  EXPECT_THAT(said(2, {"fore=wrist"}), HasSubstr("two are called 'fore'"));
  const std::vector<MarkerMeasure> usual = gait::UsualMeasures({"a", "b", "c"});
  ASSERT_EQ(usual.size(), 6u) << "an angle, two distances, three speeds";
  EXPECT_EQ(usual[0].name, "angle_a_b_c");
  EXPECT_THROW(gait::CheckMarkers(usual, {"a", "b"}), UsageError);
}

}  // namespace
}  // namespace lake
