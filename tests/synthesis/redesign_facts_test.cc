// The published design in a real sit-to-stand: figures worked out independently of this code, for the right leg of
// opencap_sts. Misalignments agree within 0.2 % of the shank's length, the bound; times within 2 %, as the
// steepest part of a motion depends on how it is filtered and sampled.
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "lake/core/angles.h"
#include "lake/exchange/trial.h"
#include "lake/gait/butterworth.h"
#include "lake/redesign/human_motion.h"
#include "lake/redesign/redesign.h"
#include "places.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Goal = redesign::RedesignProblem::Goal;
using Kind = linkage::StrokeProgram::Kind;
constexpr double kPercent = 0.2;

// The recorded sit-to-stand that the facts were worked out on.
// Right leg of opencap_sts in its x-y plane, 0.26-0.93 s, Butterworth 6 Hz; nullopt where the recordings are absent.
std::optional<redesign::HumanMotion> RealSitToStand() {
  const std::filesystem::path file = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  exchange::TrialOptions reading;
  reading.names = {{"ankle", "r_ankle"}, {"knee", "r_knee"}, {"hip", "R_HJC"}};
  reading.forward = "+x";
  const motion::MarkerRecording recording = exchange::ReadTrial(file, reading).recording;
  constexpr double kFrom_s = 0.26, kTo_s = 0.93, kCutoff_hz = 6;
  const auto path = [&](const char* name) {
    std::vector<double> x, y;
    for (const motion::MarkerSample& sample : recording.Find(name)->samples)
      x.push_back(sample.position.x()), y.push_back(sample.position.y());
    x = gait::ZeroPhaseButterworthAtTimes(x, recording.time_s, kCutoff_hz);
    y = gait::ZeroPhaseButterworthAtTimes(y, recording.time_s, kCutoff_hz);
    std::vector<Eigen::Vector2d> points;
    for (int percent = 0; percent < compare::kPercentSamples; ++percent) {
      const double frame = 100 * std::lerp(kFrom_s, kTo_s, percent / 100.0);  // 100 Hz from 0 s
      const auto before = static_cast<std::size_t>(frame);
      const double share = frame - static_cast<double>(before);
      points.emplace_back(std::lerp(x[before], x[before + 1], share), std::lerp(y[before], y[before + 1], share));
    }
    return points;
  };
  compare::StsCurve curve;
  curve.ankle = path("ankle");
  curve.knee = path("knee");
  curve.hip = path("hip");
  return redesign::MakeHumanMotion(curve);
}

class RealMotion : public testing::Test {
 protected:
  void SetUp() override {
    const auto human = RealSitToStand();
    if (!human) GTEST_SKIP() << "the recording opencap_sts is not in " << SharedData();
    problem_.human = *human;
    problem_.design.start = kPublishedLinks;
    problem_.goal = Goal::kMisalignment;
  }

  // Links held at the published ones.
  redesign::RedesignProblem Published() const {
    redesign::RedesignProblem problem = problem_;
    for (std::size_t i = 0; i < 6; ++i)
      problem.design.bounds[i] = {kPublishedLinks.Values()[i], kPublishedLinks.Values()[i]};
    return problem;
  }

  static double Least(const redesign::RedesignProblem& problem, int starts) {
    const redesign::RedesignResult result = redesign::Redesign(problem, {kPublishedLinks}, Starts(starts));
    return result.IsSolved() ? result.Best().Misalignment_percent() : NAN;
  }

  double TrackingTimeOf(const linkage::Links& links) const {
    return redesign::TrackingTime(*redesign::TrackingStrokes({links}, problem_.human), 5);
  }

  redesign::RedesignProblem problem_;
};

TEST_F(RealMotion, ConstantProgram) {
  const auto prediction = redesign::PredictPoint(problem_, redesign::StartPoint(problem_, kPublishedLinks));
  ASSERT_TRUE(prediction);
  EXPECT_NEAR(100 * prediction->path.relative, 8.61, kPercent);
  EXPECT_NEAR(prediction->path.mm, 42.3, 1.0);  // 0.2 % of the shank
  redesign::RedesignProblem placed = Published();
  placed.fit_placement = true;
  EXPECT_NEAR(Least(placed, 1), 7.40, kPercent);
  EXPECT_NEAR(Least(problem_, 6), 7.75, kPercent);
  problem_.fit_placement = true;
  EXPECT_NEAR(Least(problem_, 10), 7.02, kPercent);
}

TEST_F(RealMotion, ParetoFrontIsNearlyFlat) {
  problem_.fit_placement = true;
  const auto front = redesign::ParetoFront(problem_, 5, {kPublishedLinks}, Starts(10));
  ASSERT_EQ(front.size(), 5u);
  EXPECT_NEAR(front.front().range_deg, 93, 1.5);
  EXPECT_NEAR(front.front().misalignment_percent, 7.02, kPercent);
  EXPECT_NEAR(front.back().range_deg, 170.5377, 1e-3);
  EXPECT_NEAR(front.back().misalignment_percent, 7.73, kPercent);
}

TEST_F(RealMotion, FreeProgramOfThePublishedDesign) {
  redesign::RedesignProblem free = Published();
  free.program.kind = Kind::kFree;
  for (const auto& [duration_s, percent] : {std::pair(25.0, 2.77), {30.0, 0.83}, {45.0, 0.05}}) {
    free.program.duration_s = duration_s;
    EXPECT_NEAR(Least(free, 1), percent, kPercent) << duration_s;
  }
}

TEST_F(RealMotion, TrackingTimes) {
  EXPECT_NEAR(TrackingTimeOf(kPublishedLinks), 35.7, 0.02 * 35.7);
  problem_.goal = Goal::kRange;
  const redesign::RedesignSolve widest = SolveFrom(problem_, redesign::StartPoint(problem_, kPublishedLinks));
  ASSERT_TRUE(widest.IsUsable());
  EXPECT_NEAR(TrackingTimeOf(widest.Point().links), 28.3, 0.02 * 28.3);
  // The linkage that tracks fastest: none of a search found less than 23.4 s.
  problem_.goal = Goal::kDuration;
  problem_.program.kind = Kind::kFree;
  problem_.max_misalignment_percent = 0.1;
  const redesign::RedesignResult fastest = redesign::Redesign(problem_, {kPublishedLinks}, Starts(6));
  ASSERT_TRUE(fastest.IsSolved());
  EXPECT_NEAR(TrackingTimeOf(fastest.Best().Point().links), 23.4, 0.02 * 23.4);
}

}  // namespace
}  // namespace lake
