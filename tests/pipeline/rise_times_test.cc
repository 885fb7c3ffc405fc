// Times of rises in rendered films: the phases against the closed form that was rendered, and the clocks of two films
// of one movement against their known offset.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "lake/core/csv.h"
#include "lake/sync/align.h"
#include "lake/synth/sts_motion.h"
#include "pipeline/rendered_trial.h"
#include "places.h"
#include "real_leg.h"
#include "true_rise_times.h"

namespace lake {
namespace {

TrueRiseTimes TrueTimesOf(const synth::StsMotion& motion) {
  constexpr double kFine_hz = 4000;
  TrueRises rises(kFine_hz);
  const auto frames = static_cast<int>(motion.DurationS() * kFine_hz);
  for (int i = 0; i < frames; ++i) {
    const std::vector<Eigen::Vector2d> at = motion.At(i / kFine_hz);  // ankle, knee, hip, waist
    rises.Add({at[0], at[1], at[2], at[3]}, motion.FacingInImage());
  }
  double rise_s = 0, lowering_s = 0, end_s = 0;
  for (const synth::StsPhase& phase : motion.Phases()) {
    if (phase.kind == synth::StsPhase::Kind::kRise) rise_s = phase.start_s;
    if (phase.kind == synth::StsPhase::Kind::kDescent) lowering_s = phase.start_s, end_s = phase.end_s;
  }
  return rises.Times(rise_s, lowering_s, end_s);
}

// How far the onset, and what is counted from it, may be from the truth: a frame, but at a rate of which a frame is
// shorter than what noise makes of the onset. It is where the trunk has 3 % of its peak speed, so that the markers'
// noise moves it by a time that does not shrink with the frame: by 2.2 ms (SD) at 240 Hz, whose frame is 4.2 ms. That
// time is what the table itself says, three of its standard deviations, and no more than the frame of a film at 120 Hz.
double OnsetTolerance_s(double frame_s, double sd_s) {
  constexpr double kFrameAt120Hz_s = 1 / 120.0;
  return std::max(frame_s, std::min(3 * sd_s, kFrameAt120Hz_s));
}

class RenderedRise : public testing::TestWithParam<double> {};

TEST_P(RenderedRise, HasItsPhasesWithinAFrame) {
  synth::SceneOptions scene = CleanLeg(36036);
  scene.frame_rate_hz = GetParam();
  scene.motion.repetitions = 1;
  scene.motion.min_rest_s = 1;
  scene.motion.max_rest_s = 1.2;
  const auto motion = std::make_shared<synth::StsMotion>(scene.motion);
  scene.duration_s = motion->DurationS();
  const TrueRiseTimes truth = TrueTimesOf(*motion);
  RenderedTrial trial(synth::Scene(scene, motion), {.crf = 17});
  trial.Track();
  const CsvTable table = CsvTable::Read(trial.folder / "trial/sit_to_stand.csv");
  ASSERT_EQ(table.Rows(), 2u);
  const double frame_s = 1 / scene.frame_rate_hz;
  const auto within = [&](const char* column, double is_s, double tolerance_s) {
    EXPECT_NEAR(table.RequiredNumber(0, table.Column(column)), is_s, tolerance_s) << column;
  };
  const double onset_s = OnsetTolerance_s(frame_s, table.RequiredNumber(0, table.Column("onset_s_sd")));
  within("onset_s", truth.onset_s, onset_s);
  within("flexion_s", truth.seat_off_s - truth.onset_s, onset_s);
  within("seat_off_s", truth.seat_off_s, frame_s);
  within("standing_s", truth.standing_s, frame_s);
  within("transfer_s", truth.leaned_s - truth.seat_off_s, frame_s);
  within("extension_s", truth.standing_s - truth.leaned_s, frame_s);
  within("stabilisation_s", truth.steady_s - truth.standing_s, frame_s);
  within("descent_s", truth.seated_s - truth.descent_s, frame_s);
}

INSTANTIATE_TEST_SUITE_P(, RenderedRise, testing::Values(30.0, 60.0, 120.0, 240.0),
                         [](const auto& info) { return fmt::format("{:.0f}Hz", info.param); });

// The same person, seen by a camera at 60 Hz and by another at 30 Hz that was started later and stands elsewhere.
TEST(RenderedClocks, AreAlignedWithinTwoMilliseconds) {
  auto leg = RealLeg("right");
  if (!leg) GTEST_SKIP() << "no recording in " << SharedData() / "opencap_sts";
  synth::SceneOptions scene = CleanLeg(36001);
  scene.duration_s = 0;
  RenderedTrial first(synth::Scene(scene, synth::MakeTableMotion(*leg)), kQuickly);
  constexpr std::size_t kLater = 83;  // frames of the recording
  const double later_s = leg->time_s[kLater] - leg->time_s.front();
  leg->time_s.erase(leg->time_s.begin(), leg->time_s.begin() + kLater);
  for (std::vector<Eigen::Vector2d>& marker : leg->positions) marker.erase(marker.begin(), marker.begin() + kLater);
  scene = CleanLeg(36002);
  scene.duration_s = 0;
  scene.frame_rate_hz = 30;
  scene.start_s = 0.2347;
  scene.yaw_deg = 8;
  RenderedTrial second(synth::Scene(scene, synth::MakeTableMotion(*leg)), kQuickly);
  first.Track();
  second.Track();
  const sync::Alignment found =
      sync::AlignByMotion(sync::ReadMovement(first.folder / "trial"), sync::ReadMovement(second.folder / "trial"));
  // Of times of the second film: its stamps begin at start_s, where the first film's clock has come to later_s.
  EXPECT_NEAR(found.clock.FromB(4) - 4, later_s - scene.start_s, 0.002);
  EXPECT_NEAR(found.clock.offset_s, later_s - scene.start_s, 0.002);
  EXPECT_LT(found.clock.sd_s, 0.002);
}

}  // namespace
}  // namespace lake
