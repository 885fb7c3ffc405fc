// A prototype with a slow actuator, one with a wrong link, one with both: each error is found where it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/actuator/prototype_validation.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "model_program.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using actuator::AngleSample;
using actuator::SeparatedErrors;
using actuator::StrokeSeries;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kRestBefore_s = 2, kAngleNoise_deg = 0.05, kStrokeNoise_mm = 0.05, kMarkers_mm = 37.5;

// Filmed at 30 Hz from kRestBefore_s before the program on, with rests on both sides; the log at 10 Hz only while it
// runs, on a clock of its own.
struct Prototype {
  actuator::StrokeSchedule plan = FreeSchedule({{0, 300}, {5, 325}, {6, 325}, {10, 309}});
  StrokeSeries log{"log.csv", {}}, lengths{"trajectory.csv", {}};
  std::vector<AngleSample> angles;
  double linkage_rms_deg = 0;  // over the program, without noise

  Prototype(double travel_factor, double wrong_link_mm, unsigned seed) {
    linkage::Links links = kPublishedLinks;
    links.l5 += wrong_link_mm;
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 1);
    const auto stroke_at = [&](double t) { return 300 + travel_factor * (plan.StrokeAt(t) - 300); };
    int moving = 0;
    for (double t = -kRestBefore_s; t < plan.Duration() + 2; t += 1 / 30.0) {
      const double stroke = stroke_at(t), angle = actuator::KneeDegAt(links, stroke);
      angles.push_back({t + kRestBefore_s, angle + kAngleNoise_deg * noise(random)});
      lengths.knots.push_back({t + kRestBefore_s, stroke + kMarkers_mm + kStrokeNoise_mm * noise(random)});
      if (t < 0 || t > plan.Duration()) continue;
      linkage_rms_deg += std::pow(angle - actuator::KneeDegAt(kPublishedLinks, stroke), 2), ++moving;
    }
    linkage_rms_deg = std::sqrt(linkage_rms_deg / moving);
    for (double t = 0; t <= plan.Duration(); t += 0.1)
      log.knots.push_back({t + 51.3, stroke_at(t) + kStrokeNoise_mm * noise(random)});
  }
};

TEST(SeparatedErrors, ASlowActuatorIsNoErrorOfTheLinkage) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const double factor : {0.93, 1.0, 1.05}) {
      const Prototype prototype(factor, 0, seed);
      const double end_mm = (factor - 1) * (309 - 300);
      for (const SeparatedErrors& found :
           {SeparateErrorsByLog(prototype.plan, prototype.log, prototype.angles),
            SeparateErrorsByVideo(prototype.plan, prototype.lengths, prototype.angles)}) {
        // Noise of angles, and of strokes at up to 3 degrees per mm.
        EXPECT_LT(found.linkage_rms_deg, kAngleNoise_deg + 3 * kStrokeNoise_mm) << factor;
        EXPECT_NEAR(found.actuator_end_mm, end_mm, 0.25) << factor;
        if (factor == 1) {
          EXPECT_LT(found.actuator_rms_mm, 2 * kStrokeNoise_mm);
        } else {
          EXPECT_GT(found.actuator_rms_mm, 0.5 * std::abs(factor - 1) * 25);
        }
      }
    }
}

TEST(SeparatedErrors, AWrongLinkIsNoErrorOfTheActuator) {
  for (const unsigned seed : {4u, 5u, 6u}) {
    const Prototype prototype(1, 8, seed);
    ASSERT_GT(prototype.linkage_rms_deg, 1);
    const SeparatedErrors by_log = SeparateErrorsByLog(prototype.plan, prototype.log, prototype.angles);
    // A shift of the clocks takes the part that goes like the speed; it goes both ways here, so that is little.
    EXPECT_NEAR(by_log.linkage_rms_deg, prototype.linkage_rms_deg, 0.1 * prototype.linkage_rms_deg);
    EXPECT_LT(by_log.actuator_rms_mm, 2 * kStrokeNoise_mm);
    EXPECT_NEAR(by_log.program_start_s, 51.3, 0.02);
    const SeparatedErrors by_video = SeparateErrorsByVideo(prototype.plan, prototype.lengths, prototype.angles);
    EXPECT_LT(by_video.actuator_max_mm - by_video.actuator_rms_mm, 2);
    // The markers' place takes the constant part of it, 0.35 mm; at 5 mm/s that is 0.07 s.
    EXPECT_NEAR(by_video.program_start_s, kRestBefore_s, 0.1);
    // The constant part of it is hidden in the markers' place, as the header says.
    EXPECT_LT(by_video.linkage_rms_deg, prototype.linkage_rms_deg);
  }
}

TEST(SeparatedErrors, TheMarkersPlaceIsFound) {
  const Prototype prototype(0.95, 0, 7);
  EXPECT_NEAR(SeparateErrorsByVideo(prototype.plan, prototype.lengths, prototype.angles).stroke_offset_mm, kMarkers_mm,
              0.05);
}

TEST(SeparatedErrors, ALogWithoutMeasuredStrokesIsRefused) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "log.csv",
                "time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops\n0.1,,,0,0,idle,0,0\n");
  EXPECT_THAT([&] { actuator::ReadMeasuredStrokes(folder / "log.csv"); },
              ThrowsMessage<Error>(HasSubstr("no column measured_mm")));
  WriteTextFile(folder / "log.csv",
                "time_s,state,measured_mm\n0.1,idle,5\n0.2,running,300\n0.3,running,300.5\n0.4,idle,300.5\n");
  const StrokeSeries running = actuator::ReadMeasuredStrokes(folder / "log.csv");
  ASSERT_EQ(running.knots.size(), 2u);
  EXPECT_EQ(running.knots[0].stroke_mm, 300);
  EXPECT_EQ(running.knots[1].stroke_mm, 300.5);
}

}  // namespace
}  // namespace lake
