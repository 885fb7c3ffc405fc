#include "lake/actuator/prototype_validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "model_program.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

actuator::StrokeSchedule PaperProgram() {
  actuator::ScheduleOptions options;
  options.speed_mm_s = 5;
  options.from_deg = 110;
  return actuator::MakeSchedule(PublishedDesign(), options);
}

// A video of a prototype: rest, the program from `start_s` at another speed, rest.
std::vector<actuator::AngleSample> Film(const actuator::StrokeSchedule& schedule, double start_s, double speed_factor,
                                        double offset_deg, double noise_deg, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<actuator::AngleSample> samples;
  for (double t = 0.3; t < start_s + schedule.Duration() + 3; t += 1 / 60.0)
    samples.push_back({t, actuator::KneeDegAt(schedule.links, schedule.StrokeAt((t - start_s) * speed_factor)) +
                              offset_deg + noise_deg * normal(random)});
  return samples;
}

TEST(PrototypeValidation, APerfectPrototypeIsFoundWhereItBegan) {
  const actuator::StrokeSchedule schedule = PaperProgram();
  for (const double start : {0.4, 2.71828, 9.0}) {
    const actuator::Validation v = actuator::ValidatePrototype(schedule, Film(schedule, start, 1, 0, 0, 1));
    EXPECT_NEAR(v.shift_s, start, 1e-4);
    EXPECT_LT(v.max_deg, 1e-3);
    EXPECT_NEAR(v.speed_mm_s, 5, 1e-3);
    EXPECT_NEAR(v.covered, 1, 1e-3);
  }
}

TEST(PrototypeValidation, NoiseOffsetAndSpeedAreTold) {
  const actuator::StrokeSchedule schedule = PaperProgram();
  for (unsigned seed = 0; seed < 5; ++seed) {
    const actuator::Validation noisy = actuator::ValidatePrototype(schedule, Film(schedule, 2, 1, 0, 0.2, seed));
    EXPECT_NEAR(noisy.rms_deg, 0.2, 0.02);  // about 1400 frames: 2 % of 0.2, times 5
    EXPECT_NEAR(noisy.shift_s, 2, 0.02);
    EXPECT_NEAR(noisy.offset_deg, 0, 0.05);
    EXPECT_NEAR(noisy.speed_mm_s, 5, 5 * noisy.speed_se_mm_s + 1e-3) << "seed " << seed;
    EXPECT_LT(noisy.speed_se_mm_s, 0.01);
  }
  // A marker off its place: the shift alone hides it, as it must; with the rests in the picture the offset is told.
  const actuator::Validation offset = actuator::ValidatePrototype(schedule, Film(schedule, 2, 1, 1.5, 0.1, 1));
  EXPECT_NEAR(offset.offset_deg, 1.5, 0.02);
  EXPECT_NEAR(offset.rms_with_offset_deg, 0.1, 0.01);
  EXPECT_LT(offset.rms_with_offset_deg, 0.5 * offset.rms_deg);
  // A prototype that is 4 % slow: the angle lags ever more, and its own speed says why.
  const actuator::Validation slow = actuator::ValidatePrototype(schedule, Film(schedule, 2, 0.96, 0, 0.05, 1));
  EXPECT_NEAR(slow.speed_mm_s, 4.8, 0.02);
  EXPECT_GT(slow.max_deg, 0.5);
}

// Driven open loop, a slow prototype runs for the planned time and stops short; free programs have no single speed, but
// a factor on their travel.
TEST(PrototypeValidation, AnOpenLoopPrototypesOwnTravelAndDriftAreTold) {
  for (const actuator::StrokeSchedule& schedule :
       {PaperProgram(), FreeSchedule({{0, 290}, {4, 308}, {5, 308}, {8, 300}, {16, 340}})})
    for (const double factor : {0.9, 0.97, 1.0, 1.05}) {
      std::mt19937 random(3);
      std::normal_distribution<double> normal(0, 0.05);
      std::vector<actuator::AngleSample> samples;
      const double start = schedule.knots.front().stroke_mm;
      for (double t = 0; t < schedule.Duration() + 4; t += 1 / 30.0) {
        const double stroke = start + factor * (schedule.StrokeAt(t - 1.5) - start);
        samples.push_back({t, actuator::KneeDegAt(schedule.links, std::min(stroke, 374.5205)) + normal(random)});
      }
      const actuator::Validation v = actuator::ValidatePrototype(schedule, samples);
      EXPECT_NEAR(v.travel_factor, factor, 1e-3);
      EXPECT_NEAR(v.drift_mm, (factor - 1) * (schedule.knots.back().stroke_mm - start), 0.1);
      EXPECT_NEAR(v.rms_with_factor_deg, 0.05, 0.01);
      EXPECT_EQ(actuator::Judge(v, 0.3), factor == 1 ? actuator::Verdict::kFollows : actuator::Verdict::kOtherSpeed);
    }
  const actuator::StrokeSchedule schedule = PaperProgram();
  EXPECT_EQ(actuator::Judge(actuator::ValidatePrototype(schedule, Film(schedule, 2, 1, 3, 0.1, 1)), 0.3),
            actuator::Verdict::kOtherAngles);
}

TEST(PrototypeValidation, AVideoOfAPartIsAlignedAndSaysHowMuchItShows) {
  const actuator::StrokeSchedule schedule = PaperProgram();
  std::vector<actuator::AngleSample> samples;
  for (const actuator::AngleSample& sample : Film(schedule, 0, 1, 0, 0.05, 3))
    if (sample.time_s > 0.3 * schedule.Duration() && sample.time_s < 0.8 * schedule.Duration())
      samples.push_back(sample);
  const actuator::Validation v = actuator::ValidatePrototype(schedule, samples);
  EXPECT_NEAR(v.shift_s, 0, 0.02);
  EXPECT_NEAR(v.covered, 0.5, 0.01);
}

TEST(PrototypeValidation, WhatCannotBeComparedIsAnError) {
  const actuator::StrokeSchedule schedule = PaperProgram();
  EXPECT_THAT([&] { actuator::ValidatePrototype(schedule, {}); }, ThrowsMessage<Error>(HasSubstr("0 frames")));
  std::vector<actuator::AngleSample> still;
  for (int i = 0; i < 100; ++i) still.push_back({0.1 * i, 70});
  EXPECT_THAT([&] { actuator::ValidatePrototype(schedule, still); }, ThrowsMessage<Error>(HasSubstr("changes by 0")));
  still[50].time_s = 0;
  EXPECT_THAT([&] { actuator::ValidatePrototype(schedule, still); }, ThrowsMessage<Error>(HasSubstr("ascend")));
}

// A prototype with a slow actuator, one with a wrong link, one with both: each error is found where it is.

using actuator::AngleSample;
using actuator::SeparatedErrors;
using actuator::StrokeSeries;

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
