// The firmware with a potentiometer: how well it follows, and what it does when something breaks. The plant is the
// host's model: duty and supply to speed by the duty table, a force–speed line with the shank's gravity through the
// linkage, lag, play, noise and spikes on the readings.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <string_view>

#include "actuator/sample_program.h"
#include "host/host_fixture.h"
#include "lake/core/error.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

// 20 s, both ways, with rests: at most 2.4 mm/s, which the model still has at 70 % of its supply under 600 N.
const std::vector<linkage::StrokeProgram::Knot> kProgram = {{0, 300},  {5, 312},  {8, 317}, {10, 317},
                                                            {14, 308}, {15, 308}, {20, 320}};
constexpr double kFullLoad_n = 600;

// The force that a hanging leg's weight puts on the actuator, by virtual work: moment times dtheta/dd, scaled so that
// the largest of the program's strokes is `most_n`.
double GravityForce(double stroke_mm, double most_n) {
  const auto force = [](double stroke) {
    const double knee_deg = actuator::KneeDegAt(kPublishedLinks, stroke);
    const double rate = std::abs(actuator::KneeDegAt(kPublishedLinks, stroke + 0.1) -
                                 actuator::KneeDegAt(kPublishedLinks, stroke - 0.1));
    return std::cos(knee_deg * std::numbers::pi / 180) * rate;  // a shank that is level when the knee is straight
  };
  static const double most = [&] {
    double largest = 0;
    for (double stroke = 298; stroke < 322; stroke += 0.5) largest = std::max(largest, std::abs(force(stroke)));
    return largest;
  }();
  return most_n * force(std::clamp(stroke_mm, 250.0, 370.0)) / most;
}

class ClosedLoopTest : public HostFirmwareTest {
 protected:
  void SetUp() override {
    WirePotentiometer(firmware_options_);
    actuator_.noise_counts = 0.5, actuator_.spikes = 0.01;
    actuator_.play_mm = 0.2, actuator_.time_constant_s = 0.04;
    actuator_.mm_s_per_n = 0.003;
  }

  void HomeAndRun() {
    Home(60);
    rig_->Run(0.3);
    rig_->Send("run");
    ASSERT_TRUE(rig_->RunUntil("ok\n", 0.01)) << rig_->Serial();
    started_ = rig_->Samples().size();
  }

  // A plant at part of its supply, under a load, faster than the duty table by a factor. Each has noise of its own.
  void TakePlant(double supply, double load_n, double factor, double noise_counts) {
    ++actuator_.seed;
    actuator_.speed_factor = factor, actuator_.noise_counts = noise_counts;
    actuator_.supply = [supply](double) { return supply; };
    actuator_.load_n = [load_n](double, double) { return load_n; };
    plant_ = fmt::format("supply {}, load {} N, speed {}, noise {}", supply, load_n, factor, noise_counts);
  }

  // To its end, without a fault.
  void HomeAndRunToEnd(double most_s) {
    HomeAndRun();
    EXPECT_TRUE(rig_->RunUntil("[MSG:done]", most_s)) << plant_ << rig_->Serial();
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM"))) << plant_;
    EXPECT_FALSE(rig_->IsShorted());
  }

  // RMS and largest distance of the stroke since the program runs: from it, or from the firmware's own plan, which may
  // have waited.
  std::pair<double, double> Errors(bool from_own_plan = false) const {
    double sum = 0, worst = 0;
    std::size_t count = 0;
    for (std::size_t i = started_; i < rig_->Samples().size(); ++i, ++count) {
      const double time = 1e-3 * static_cast<double>(i - started_);
      if (!from_own_plan && time > schedule_.Duration()) break;
      const RigSample& sample = rig_->Samples()[i];
      const double error = sample.stroke_mm - (from_own_plan ? sample.planned_mm : schedule_.StrokeAt(time));
      sum += error * error, worst = std::max(worst, std::abs(error));
    }
    return {std::sqrt(sum / static_cast<double>(count)), worst};
  }

  // What the firmware said that the plan has waited, s.
  double Waited() const {
    constexpr std::string_view kSaid = "[MSG:waited ";
    const std::size_t said = rig_->Serial().rfind(kSaid);
    return said == std::string::npos ? 0 : std::atof(rig_->Serial().c_str() + said + kSaid.size());
  }

  std::size_t started_ = 0;
  std::string plant_;
};

TEST_F(ClosedLoopTest, FollowsUnderAnySupplyAndLoad) {
  double worst_rms = 0, worst_most = 0;
  actuator_.seed = 0;
  for (const double supply : {0.7, 1.0, 1.3})
    for (const double factor : {0.9, 1.0, 1.2})
      for (const double load_n : {0.0, kFullLoad_n, -kFullLoad_n}) {
        TakePlant(supply, load_n, factor, 0.5);
        actuator_.load_n = [load_n](double, double stroke) { return GravityForce(stroke, load_n); };
        Build(FreeDesign(kProgram));
        HomeAndRunToEnd(22);
        const auto [rms, most] = Errors();
        EXPECT_LT(rms, 0.3) << plant_;
        EXPECT_LT(most, 1) << plant_;
        worst_rms = std::max(worst_rms, rms), worst_most = std::max(worst_most, most);
      }
  std::printf("closed loop, 27 plants: RMS %.3f mm, %.3f mm at most\n", worst_rms, worst_most);
}

// From the upper soft limit and back, with an end stop 0.4 mm early, and near home: programs come to their end,
// whatever the plant within its tolerances. A motor that rests at an end stop where it belongs is no fault.
TEST_F(ClosedLoopTest, ProgramsAtTheLimitsOfTravelEnd) {
  firmware_options_.extend_stop_mm = 0.7, firmware_options_.current_sense = true, firmware_options_.supply_v = 12;
  // At 1.3 of its supply this motor takes 3.4 A as it starts against 400 N: only what is more is a short.
  firmware_options_.max_current_a = 4;
  firmware_options_.home_stroke_mm = 362;
  actuator_.spikes = 0, actuator_.seed = 0;
  for (const double supply : {0.7, 1.0, 1.3})
    for (const double load_n : {-400.0, 0.0, 400.0})
      for (const double noise : {0.5, 5.0}) {
        TakePlant(supply, load_n, actuator_.seed % 2 ? 1.02 : 0.98, noise);
        Build(FreeDesign({{0, 362.2}, {6, 373.7}, {7, 373.7}, {13, 362.2}}));
        rig_->Actuator().extend_stop_mm = 374.5205 - 0.7 - 0.4;
        rig_->Actuator().retract_stop_mm = 362.4;
        rig_->SetStroke(366);
        rig_->PowerUp();
        rig_->Run(0.1);
        HomeAndRunToEnd(15);
        EXPECT_LT(Errors(true).first, 0.3) << plant_;
      }
}

// Noise of 5 counts in each conversion is 0.1 mm after the filters, and a motor on 130 % of its supply whose load helps
// coasts on after a stop: neither is a motion the wrong way or one beyond what was driven.
TEST_F(ClosedLoopTest, NoiseAndCoastingAreNoFaults) {
  actuator_.spikes = 0, actuator_.seed = 0;
  for (int i = 1; i <= 40; ++i) {
    TakePlant(1.3, i % 2 ? 400 : -400, 1.02, 5);
    Build(FreeDesign({{0, 300}, {2, 304.8}, {3, 304.8}, {5, 300}}));
    HomeAndRunToEnd(6);
  }
}

// At 70 % of the supply the model's motor extends at 5.7 mm/s: a program that needs more is said to take longer there,
// before anything runs, and does; one that needs more than half as much again is said to stop, and does; a slower one
// is as planned.
TEST_F(ClosedLoopTest, WhatALowSupplyCannotFollowIsSaidBefore) {
  actuator_.spikes = 0;
  actuator_.mm_s_per_n = 0;
  actuator_.supply = [](double) { return actuator::kLowSupply; };
  firmware_options_.supply_v = 12;
  constexpr std::string_view kTooSlow = "ALARM:11\n";
  const struct {
    double speed_mm_s;
    const char* said;
    std::string_view end;
    // By the speeds, but for the start and what it may be behind at the end.
    double least_waited_s, most_waited_s;
  } programs[] = {{5.3, "", "[MSG:done]", 0, 0.2},
                  {6.5, "needs 6.5: there it takes longer.\n", "[MSG:done]", 0.6, 0.9},
                  {9.5, "needs 9.5: there it may fall behind and stop (ALARM:11).\n", kTooSlow, 0, 0}};
  for (const auto& program : programs) {
    Build(FreeDesign({{0, 300}, {6, 300 + 6 * program.speed_mm_s}}));
    EXPECT_THAT(header_, HasSubstr(program.said));
    EXPECT_EQ(header_.find("CANNOT KNOW: At 70 % of its supply it extends at 5.7 mm/s") == std::string::npos,
              *program.said == 0);
    HomeAndRun();
    EXPECT_TRUE(rig_->RunUntil(std::string(program.end), 7.5)) << rig_->Serial();
    if (program.end == kTooSlow) {
      const double told_s = 1e-3 * static_cast<double>(rig_->Samples().size() - started_);
      std::printf("%.1f mm/s: told after %.1f s\n", program.speed_mm_s, told_s);
      EXPECT_LT(told_s, 6);  // as SAFETY.md says
    }
    EXPECT_GE(Waited(), program.least_waited_s);
    EXPECT_LE(Waited(), program.most_waited_s);
  }
}

// 35 s, slower than the duty table's slowest speed, then 5 mm/s, which at 70 % of its supply and under 400 N the motor
// has not: there the plan waits. All plants with LAKE_LONG_TESTS=1, else of the corners of supply and load one with
// each noise.
TEST_F(ClosedLoopTest, TheSampleStudysProgramEndsUnderAnySupplyAndLoad) {
  firmware_options_.extend_stop_mm = 0.7, firmware_options_.current_sense = true, firmware_options_.supply_v = 12;
  firmware_options_.home_stroke_mm = 242;
  firmware_options_.max_current_a = 4;  // as in ProgramsAtTheLimitsOfTravelEnd
  actuator_.spikes = 0;
  double worst_rms = 0, worst_most = 0, longest_s = 0;
  for (const double supply : {actuator::kLowSupply, 1.0, 1.3})
    for (const double load_n : {-400.0, 0.0, 400.0})
      for (const double factor : {0.98, 1.02})
        for (const double noise : {0.5, 5.0}) {
          const bool is_corner = supply != 1 && load_n != 0 && (factor < 1) == (noise > 1);
          if (!is_corner && !std::getenv("LAKE_LONG_TESTS")) continue;
          TakePlant(supply, load_n, factor, noise);
          Build(SampleDesign());
          rig_->Actuator().extend_stop_mm = *Sketch().ExtendStop() - 0.4;
          HomeAndRunToEnd(1.5 * schedule_.Duration() + 1);
          const auto [rms, most] = Errors(true);
          EXPECT_LT(rms, 0.3) << plant_;
          EXPECT_LT(most, 1) << plant_;
          worst_rms = std::max(worst_rms, rms), worst_most = std::max(worst_most, most);
          longest_s = std::max(longest_s, Waited());
        }
  std::printf("the sample study's program: RMS %.3f mm, %.3f mm at most; at most %.3f s later\n", worst_rms, worst_most,
              longest_s);
}

// Each start at another supply than the duty table's would have to be learnt from the error.
TEST_F(ClosedLoopTest, AMeasuredSupplyNeedNotBeLearntAtEachStart) {
  firmware_options_.supply_v = 12;
  actuator_.spikes = 0;
  for (const double supply : {actuator::kLowSupply, 1.0, 1.3})
    for (const double load_n : {-400.0, 0.0, 400.0}) {
      TakePlant(supply, load_n, actuator_.seed % 2 ? 1.02 : 0.98, 5);
      Build(FreeDesign({{0, 300}, {2, 304.8}, {3, 304.8}, {5, 300}, {7, 304.8}}));
      HomeAndRunToEnd(8);
      EXPECT_LT(Errors().first, 0.15)
          << plant_;  // without the supply's sense 0.27 at the low supply, 0.08 at the nominal
    }
}

TEST_F(ClosedLoopTest, FollowsThroughSagsAndLoadSteps) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    actuator_.seed = seed;
    actuator_.supply = [](double t) { return std::fmod(t, 4) < 1 ? 0.72 : 1.05; };
    actuator_.load_n = [](double t, double) { return std::fmod(t, 3) < 1.5 ? kFullLoad_n : -100; };
    Build(FreeDesign(kProgram));
    HomeAndRunToEnd(22);
    const auto [rms, most] = Errors();
    EXPECT_LT(rms, 0.3) << seed;
    EXPECT_LT(most, 1) << seed;
  }
}

// What open loop is refused for fits: the room is the potentiometer's error and the loop's.
TEST_F(ClosedLoopTest, NeedsNoRoomForDrift) {
  schedule_ = FreeSchedule({{0, 260}, {40, 372.9}});
  EXPECT_TRUE(actuator::ForecastDrift(Sketch()).Fits());
  firmware_options_.feedback = actuator::Feedback::kNone;
  EXPECT_FALSE(actuator::ForecastDrift(Sketch()).Fits());
  WirePotentiometer(firmware_options_);
  EXPECT_THAT([&] { Build(FreeDesign({{0, 260}, {40, 373.5}})); }, ThrowsMessage<Error>(HasSubstr("--margin")));
}

TEST_F(ClosedLoopTest, TellsPlannedMeasuredAndError) {
  Build(FreeDesign(kProgram));
  EXPECT_THAT(header_, HasSubstr("#define LAKE_FEEDBACK 1\n"));
  HomeAndRun();
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 22)) << rig_->Serial();
  rig_->Send("header");
  EXPECT_TRUE(
      rig_->RunUntil("time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops,measured_mm,error_mm\n", 0.1));
  std::istringstream lines(rig_->Serial());
  int compared = 0;
  for (std::string line; std::getline(lines, line);) {
    double time = 0, planned = 0, drift = 0, duty = 0, measured = 0, error = 0;
    int direction = 0, adc = 0, stops = 0;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%d,running,%d,%d,%lf,%lf", &time, &planned, &drift, &duty,
                    &direction, &adc, &stops, &measured, &error) != 9)
      continue;
    EXPECT_NEAR(error, planned - measured, 0.0011) << line;
    ++compared;
  }
  EXPECT_GT(compared, 190);
}

// What breaks, when, what is told, how long after, and how far the actuator goes until it rests. The speeds are the
// program's 2.4 mm/s at most; a stop from there coasts for 0.1 mm.
struct Break {
  const char* name;
  Act act;
  std::vector<const char*> alarms;
  double most_s, most_mm;
};

using Wiper = RigBreaks::Wiper;
const Break kBreaks[] = {
    {"lost wiper", Breaks(&RigBreaks::wiper, Wiper::kLost), {"ALARM:7\n"}, 0.03, 0.3},
    {"shorted wiper", Breaks(&RigBreaks::wiper, Wiper::kShorted), {"ALARM:7\n"}, 0.03, 0.3},
    {"frozen wiper", Breaks(&RigBreaks::wiper, Wiper::kFrozen), {"ALARM:8\n", "ALARM:11\n"}, 1.5, 5.1},
    {"stall", Breaks(&RigBreaks::is_blocked, true), {"ALARM:8\n", "ALARM:11\n"}, 1.5, 0.1},
    {"reversed motor",
     Breaks(&RigBreaks::is_reversed, true),
     {"ALARM:9\n", "ALARM:8\n", "ALARM:10\n", "ALARM:11\n"},
     1,
     2},
    // In SAFETY.md 0.26 s: of a faster program, in simavr.
    {"runaway",
     Breaks(&RigBreaks::runs_away_mm_s, 12.0),
     {"ALARM:10\n", "ALARM:11\n", "ALARM:8\n", "ALARM:9\n"},
     0.18,
     1e9},
};

TEST_F(ClosedLoopTest, WhateverBreaksWhileItRunsIsTold) {
  unsigned seed = 0;
  for (const Break& one : kBreaks)
    for (const double moment_s : {0.5, 3.0, 6.5, 11.0, 16.0}) {
      actuator_.seed = ++seed;
      Build(FreeDesign(kProgram));
      HomeAndRun();
      rig_->Run(moment_s);
      const double since = rig_->Time(), from = rig_->Stroke();
      one.act(*rig_);
      ASSERT_TRUE(rig_->RunUntil("ALARM:", 3)) << one.name << " after " << moment_s << " s\n" << rig_->Serial();
      rig_->Run(0.01);
      EXPECT_LE(rig_->Time() - since, one.most_s + 0.01) << one.name << " after " << moment_s << " s";
      bool is_one = false;
      for (const char* alarm : one.alarms) is_one |= rig_->Serial().find(alarm) != std::string::npos;
      EXPECT_TRUE(is_one) << one.name << " after " << moment_s << " s\n"
                          << rig_->Serial().substr(rig_->Serial().size() - 80);
      rig_->Run(0.3);
      EXPECT_EQ(rig_->Duty(), 0) << one.name;
      EXPECT_LE(std::abs(rig_->Stroke() - from), one.most_mm) << one.name << " after " << moment_s << " s";
      std::printf("%-14s %4.1f s: told after %.3f s\n", one.name, moment_s, rig_->Time() - 0.31 - since);
    }
}

// Before it moves at all.
TEST_F(ClosedLoopTest, WhatIsBrokenBeforeHomingIsTold) {
  for (const Break& one : kBreaks) {
    Build(FreeDesign(kProgram));
    rig_->SetStroke(310);
    rig_->Run(0.1);
    one.act(*rig_);
    rig_->Run(0.1);
    rig_->Send("home");
    EXPECT_TRUE(rig_->Serial().find("ALARM:") != std::string::npos || rig_->RunUntil("ALARM:", 3)) << one.name;
    rig_->Run(0.3);
    EXPECT_EQ(rig_->Duty(), 0) << one.name;
    EXPECT_GT(rig_->Stroke(), 298 + 2) << one.name << ": it is far from the end stop still";
  }
}

// The potentiometer is all that sees it, and must before the motor is driven: through the lag of motor and readings,
// and also where a low supply and a load make the motor slow.
TEST_F(ClosedLoopTest, ABridgeThatDrivesByItsInputsIsFoundBeforeAnythingIsDriven) {
  for (const double supply : {0.7, 1.0, 1.3})
    for (const double load_n : {-400.0, 0.0, 400.0}) {
      TakePlant(supply, load_n, 1, 0.5);
      SCOPED_TRACE(plant_);
      Build(FreeDesign(kProgram));
      rig_->SetStroke(310);
      rig_->PowerUp();
      rig_->Breaks().drives_by_inputs = true;
      rig_->Run(0.2);
      rig_->Send("jog 400 2000");
      EXPECT_TRUE(rig_->RunUntil("ALARM:15\n", 1)) << rig_->Serial();
      rig_->Run(0.3);
      EXPECT_TRUE(std::ranges::all_of(rig_->Samples(), [](const RigSample& at) { return at.duty == 0; }));
      EXPECT_NEAR(rig_->Stroke(), 310, 1.5);
    }
}

// A potentiometer that says another place than the end stop: slipped, or another actuator's scale.
TEST_F(ClosedLoopTest, AWrongScaleIsFoundAtHome) {
  for (const double off_mm : {3.0, -3.0}) {
    actuator_.potentiometer_mm[0] = 240 + off_mm, actuator_.potentiometer_mm[1] = 380 + off_mm;
    Build(FreeDesign(kProgram));
    ASSERT_TRUE(Asks("zero", "error:5"));
    ASSERT_TRUE(Asks("home", "ok"));
    // It has passed home before the end stop comes, or the stop comes before home.
    EXPECT_TRUE(rig_->RunUntil(off_mm > 0 ? "ALARM:4\n" : "ALARM:7\n", 10)) << rig_->Serial();
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("[MSG:done]")));
  }
}

TEST_F(ClosedLoopTest, ABrownOutInMidRunIsStillAndAsksToBeHomed) {
  Build(FreeDesign(kProgram));
  HomeAndRun();
  rig_->Run(3.5);
  ASSERT_NE(rig_->Duty(), 0);
  rig_->PowerUp();
  rig_->Run(1);
  const double stroke = rig_->Stroke();
  rig_->Run(1);
  EXPECT_NEAR(rig_->Stroke(), stroke, 1e-6);
  EXPECT_TRUE(Asks("run", "error:5"));
  HomeAndRun();
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 22)) << rig_->Serial();
}

// An emergency stop, the rod pushed to free somebody: that is told, and over with a reset.
TEST_F(ClosedLoopTest, WhatWasMovedAtRestCanBeReset) {
  Build(FreeDesign(kProgram));
  HomeAndRun();
  rig_->Run(30);
  rig_->Breaks().runs_away_mm_s = 12;
  ASSERT_TRUE(rig_->RunUntil("ALARM:10", 3)) << rig_->Serial();
  rig_->Run(0.5);
  rig_->Breaks().runs_away_mm_s = 0;
  rig_->Run(0.5);
  const std::size_t told = rig_->Serial().size();
  rig_->Send("reset");
  rig_->Run(1);
  EXPECT_EQ(rig_->Serial().find("ALARM", told), std::string::npos) << rig_->Serial().substr(told);
  EXPECT_TRUE(Asks("home", "ok"));
}

// A million ms of random requests, wires, breaks, loads and resets: never a shorted bridge, never far past a limit.
TEST_F(ClosedLoopTest, AMillionMillisecondsOfEverything) {
  actuator_.load_n = [](double t, double) { return kFullLoad_n * std::sin(t); };
  actuator_.supply = [](double t) { return 1 + 0.3 * std::sin(0.7 * t); };
  firmware_options_.supply_v = 12;
  Build(FreeDesign(kProgram));
  std::mt19937 random(11);
  const auto one_in = [&](int n) { return random() % static_cast<unsigned>(n) == 0; };
  double highest = 0;
  int runs = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    if (one_in(3000)) rig_->Send("reset"), rig_->Send("home");
    if (one_in(1500)) rig_->Send("run"), ++runs;
    if (one_in(5000)) {
      const int rate = static_cast<int>(random() % 2001) - 1000;
      rig_->Send(fmt::format("jog {} {}", rate, 1 + random() % 3000));
    }
    if (one_in(9000)) rig_->SendNow("!\x18"[random() % 2]);
    if (one_in(40000)) rig_->PullWire(one_in(2), true);
    if (one_in(2000)) rig_->PullWire(true, false), rig_->PullWire(false, false);
    if (one_in(60000)) rig_->Breaks().wiper = static_cast<RigBreaks::Wiper>(random() % 4);
    if (one_in(4000)) rig_->Breaks() = {};
    if (one_in(90000)) rig_->PowerUp();
    rig_->Run(1e-3);
    ASSERT_FALSE(rig_->IsShorted());
    highest = std::max(highest, rig_->Stroke());
    ASSERT_LT(rig_->Stroke(), schedule_.limits.upper_end_mm + 0.001) << i;
  }
  std::printf("highest stroke %.3f mm, the linkage ends at %.3f mm\n", highest, schedule_.limits.upper_end_mm);
}

}  // namespace
}  // namespace lake
