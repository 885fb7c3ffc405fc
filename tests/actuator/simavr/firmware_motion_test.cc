// What the compiled firmware does to the actuator while a program runs: PWM, brake, stroke, knee angle, drift.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "firmware_fixture.h"
#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/prototype_validation.h"
#include "lake/core/error.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(FirmwareTest, PwmAndDirectionFollowTheProgram) {
  Build(FreeDesign(kKnots));
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  const double start = FirstDrive();
  const std::vector<actuator::ScheduleRow> rows = actuator::SampleSchedule(schedule_, 50, &table_);
  std::size_t compared = 0;
  for (const RigSample& sample : rig_->Samples()) {
    const double time = sample.time_s - start - 0.5e-3;
    if (time < 0 || time > schedule_.Duration()) continue;
    std::size_t row = 0;
    while (row + 1 < rows.size() && rows[row + 1].time_s <= time) ++row;
    // Within 2 ms of a knot either side may be seen: program and simulation have their own ms.
    bool near_knot = false;
    for (const auto& knot : schedule_.knots) near_knot |= std::abs(knot.time_s - time) < 2e-3;
    if (near_knot) continue;
    ASSERT_NEAR(sample.duty, rows[row].direction * rows[row].duty, 0.5 / actuator::kPwmPeriod + 1e-6)
        << "at " << time << " s";
    ++compared;
  }
  EXPECT_GT(compared, 3000u);
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:done]"));
}

// Before every reversal and stop the motor is off for the dead time: braked where the outputs are read back as low,
// else it coasts.
TEST_F(FirmwareTest, BrakesBeforeEveryReversalAndStopOnlyWhereTheOutputsAreReadBack) {
  for (const bool reads_back : {false, true}) {
    firmware_options_.bridge_sense = reads_back;
    Build(FreeDesign(kKnots));
    Start();
    rig_->Run(schedule_.Duration() + 0.3);
    // Inputs only ever change with the bridge off, or to brake.
    for (const DriveChange& change : rig_->Changes())
      EXPECT_EQ(change.enable, 0) << "inputs changed under drive at " << change.time_s << " s";
    int last_direction = 0, reversals = 0;
    double braked_ms = 0, off_ms = 0;
    for (const RigSample& sample : rig_->Samples()) {
      if (sample.brake) ++braked_ms;
      if (sample.duty == 0) {
        ++off_ms;
        continue;
      }
      const int direction = sample.duty > 0 ? 1 : -1;
      if (direction == -last_direction) {
        // The dead time, less 2 ms: the samples at both ends are shared. The second reversal comes after a rest.
        EXPECT_GE(off_ms, 98) << "at " << sample.time_s << " s";
        EXPECT_NEAR(braked_ms, reads_back ? 100 : 0, 2) << "at " << sample.time_s << " s";
        ++reversals;
      }
      braked_ms = off_ms = 0;
      last_direction = direction;
    }
    EXPECT_EQ(reversals, 2);
    EXPECT_EQ(schedule_.reversals, 2);
    EXPECT_NEAR(braked_ms, reads_back ? 100 : 0, 2) << "after the program's end";
    const RigSample& last = rig_->Samples().back();
    EXPECT_EQ(last.duty, 0);
    EXPECT_FALSE(last.brake);  // off at rest: the screw holds
  }
}

TEST_F(FirmwareTest, ClosedLoopStrokeFollowsTheProgram) {
  Build(FreeDesign(kKnots));
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  const double start = FirstDrive();
  // The motor lags by speed x 30 ms (6.5 mm/s: 0.2 mm) while it runs and runs on by speed x 10 ms when braked; what a
  // run-up loses a run-down gives back only by a third, so each of the five changes leaves up to 0.13 mm.
  const double tolerance = 0.2 + 5 * 0.13;
  double worst = 0;
  for (const RigSample& sample : rig_->Samples())
    worst = std::max(worst, std::abs(sample.stroke_mm - schedule_.StrokeAt(sample.time_s - start)));
  EXPECT_LT(worst, tolerance);
  RecordProperty("worst_um", static_cast<int>(1000 * worst));
  // An ideal actuator, without lag, ends where the plan ends but for the rounding of PWM and of ms.
  actuator_.time_constant_s = 1e-5;
  PowerUp();
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, PwmError() + 0.13);
}

// The whole sit-to-stand: constant speed between two knee angles of the published linkage.
class SitToStandTest : public FirmwareTest {
 protected:
  void RunProgram(std::optional<double> from_deg, double speed_factor, double margin_mm) {
    linkage::Design design;
    design.links = kPublishedLinks;
    design.program.emplace().speed_mm_s = 5;
    actuator::ScheduleOptions how;
    how.from_deg = from_deg, how.margin_mm = margin_mm;
    actuator_.speed_factor = speed_factor;
    Build(design, "-DLAKE_SIMULATOR", how);
    Start();
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", schedule_.Duration() + 1)) << rig_->Serial();
    rig_->Run(0.15);
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  }

  // The farthest that the actuator went.
  double Farthest() const {
    double farthest = 0;
    for (const RigSample& sample : rig_->Samples()) farthest = std::max(farthest, sample.stroke_mm);
    return farthest;
  }

  // The knee as a camera would film it, from the power-up on.
  std::vector<actuator::AngleSample> Film(double rate_hz) const {
    std::vector<actuator::AngleSample> film;
    for (const RigSample& sample : rig_->Samples())
      if (film.empty() || sample.time_s >= film.back().time_s + 1 / rate_hz)
        film.push_back({sample.time_s, actuator::KneeDegAt(kPublishedLinks, sample.stroke_mm)});
    return film;
  }

  double WorstKneeError() const {
    const double start = FirstDrive();
    double worst = 0;
    for (const RigSample& sample : rig_->Samples()) {
      const double planned = actuator::KneeDegAt(kPublishedLinks, schedule_.StrokeAt(sample.time_s - start));
      worst = std::max(worst, std::abs(actuator::KneeDegAt(kPublishedLinks, sample.stroke_mm) - planned));
    }
    return worst;
  }

  // drift_mm of the last row with a known stroke.
  double SaidDrift() const {
    std::istringstream lines(rig_->Serial());
    double said = NAN, time = 0, planned = 0, drift = 0;
    for (std::string line; std::getline(lines, line);)
      if (std::sscanf(line.c_str(), "%lf,%lf,%lf,", &time, &planned, &drift) == 3) said = drift;
    return said;
  }
};

// From sitting (100 degrees) to standing the knee is where the program says within half a degree. What is left is the
// motor's lag, 5 mm/s x (30 - 10) ms = 0.10 mm at the end, where the linkage has 3.6 degrees per mm.
TEST_F(SitToStandTest, KneeAngleIsTheProgramsWithinHalfADegree) {
  firmware_options_.accept_drift = true;  // to standing but for 0.5 mm: a bench
  RunProgram(100, 1, 0.5);
  EXPECT_LT(WorstKneeError(), 0.5);
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, 0.10 + PwmError() + 0.02);
  EXPECT_LE(std::abs(rig_->Stroke() - schedule_.knots.back().stroke_mm), SaidDrift());
  std::printf("100 degrees to standing: knee within %.3f degrees, stroke ends %+.3f mm off, drift bound %.3f mm\n",
              WorstKneeError(), rig_->Stroke() - schedule_.knots.back().stroke_mm, SaidDrift());
  const actuator::Validation film = actuator::ValidatePrototype(schedule_, Film(60));
  EXPECT_EQ(actuator::Judge(film, 0.5), actuator::Verdict::kFollows);
  EXPECT_NEAR(film.speed_mm_s, 5, 0.01);
  EXPECT_NEAR(film.drift_mm, 0, 0.15);
}

constexpr double kRoomForATenth_mm = 10;  // a tenth of 90 mm, and 0.4 mm of homing and lag

// The actuator is 10 % slower or faster than its duty table: it ends a tenth of the travel short or beyond. The
// firmware's bound holds (its tolerance is those 10 %), the linkage's end is not reached, and its film tells speed and
// drift.
TEST_F(SitToStandTest, DriftOfASlowOrFastActuatorIsWithinTheBoundAndSeen) {
  for (const double factor : {0.9, 1.1}) {
    RunProgram(100, factor, kRoomForATenth_mm);
    const double travel = schedule_.knots.back().stroke_mm - schedule_.knots.front().stroke_mm;
    const double drift = rig_->Stroke() - schedule_.knots.back().stroke_mm;
    EXPECT_NEAR(drift, (factor - 1) * travel, 0.12 + PwmError());  // and the lag of 0.10 mm
    EXPECT_GE(SaidDrift(), std::abs(drift));
    EXPECT_LT(Farthest(), schedule_.limits.upper_end_mm);
    // A tenth of the way rounded up to 103/1024, 0.1 mm after homing, 50 ms of lag of one change of speed (at the
    // beginning it loses what it gains at the end).
    EXPECT_NEAR(SaidDrift(), travel * 103 / 1024 + 0.1 + PwmError() + 5 * 0.05, 0.01);
    const actuator::Validation film = actuator::ValidatePrototype(schedule_, Film(60));
    EXPECT_EQ(actuator::Judge(film, 0.5), actuator::Verdict::kOtherSpeed);
    EXPECT_NEAR(film.speed_mm_s, 5 * factor, 0.01);
    EXPECT_NEAR(film.travel_factor, factor, 0.002);
    EXPECT_NEAR(film.drift_mm, drift, 0.12);
    EXPECT_LT(film.rms_with_factor_deg, 0.1);
    EXPECT_GT(film.rms_deg, 1);
  }
}

// What the refusal prevents: without the room the same actuator passes the linkage's end.
TEST_F(SitToStandTest, AFastActuatorWithoutRoomPassesTheLinkagesEnd) {
  EXPECT_THROW(RunProgram(100, 1.1, 0.5), Error);
  firmware_options_.accept_drift = true;
  RunProgram(100, 1.1, 0.5);
  EXPECT_GT(Farthest(), schedule_.limits.upper_end_mm + 5);
}

// With an extend end stop where lake-stroke says it ends before the linkage does, in a fault.
TEST_F(SitToStandTest, AFastActuatorIsHeldByTheExtendEndStop) {
  firmware_options_.extend_stop_mm = 0.6;
  firmware_options_.lag_s = 0.04;  // the model's is 30 ms
  linkage::Design design;
  design.links = kPublishedLinks;
  design.program.emplace().speed_mm_s = 5;
  actuator::ScheduleOptions how;
  how.from_deg = 100, how.to_deg = 5;
  actuator_.speed_factor = 1.1;
  actuator_.extend_stop_mm = actuator::SoftLimitsOf(design, 0.5).upper_end_mm - firmware_options_.extend_stop_mm;
  Build(design, "-DLAKE_SIMULATOR", how);
  ASSERT_NEAR(actuator_.extend_stop_mm, *Sketch().ExtendStop(), 1e-9);
  Start();
  EXPECT_TRUE(rig_->RunUntil("ALARM:1\n", schedule_.Duration() + 1)) << rig_->Serial();
  rig_->Run(0.3);
  EXPECT_GT(Farthest(), actuator_.extend_stop_mm);
  EXPECT_LT(Farthest(), schedule_.limits.upper_end_mm);
}

// Homed, positioned and run, the firmware's own bound is the one that was worked out before, and a fast or a slow
// actuator keeps it.
TEST_F(FirmwareTest, TheBoundIsTheForecastAndHoldsFromHomingOn) {
  for (const double factor : {0.9, 1.1}) {
    actuator_.speed_factor = factor;
    Build(FreeDesign(kKnots));
    rig_->SetStroke(301);
    rig_->Run(0.05);
    rig_->KeepTalking(true);
    Home(8);
    RunToEnd(5);
    rig_->Run(0.2);
    const std::size_t from = rig_->Serial().size();
    rig_->SendNow('?');
    ASSERT_TRUE(rig_->RunUntil(">\n", 0.1));
    double planned = 0, drift = 0;
    ASSERT_EQ(std::sscanf(rig_->Serial().substr(rig_->Serial().find('<', from)).c_str(), "<idle|stroke:%lf|drift:%lf",
                          &planned, &drift),
              2);
    const actuator::DriftForecast forecast = actuator::ForecastDrift(Sketch());
    EXPECT_NEAR(drift, forecast.last_drift_mm, 0.0011);  // it says whole um
    EXPECT_LE(std::abs(rig_->Stroke() - planned), drift);
  }
}

// The calibration firmware and the soft reset; ByHandTest and ControllerTest have what else a serial monitor meets.

// Grbl's soft reset: everything ends, the place is forgotten, the greeting says so.
TEST_F(FirmwareTest, ControlXResets) {
  Build(FreeDesign({{0, 300}, {2, 310}}));
  Start();
  rig_->Run(0.5);
  rig_->SendNow('\x18');
  EXPECT_TRUE(rig_->RunUntil("[MSG:lake-stroke]\n", 0.1)) << rig_->Serial();
  rig_->Run(0.1);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_TRUE(Asks("run", "error:5"));
}

// The whole way of a new actuator: the calibration firmware jogs it, its serial output with the potentiometer's
// readings becomes a duty table, and that table is the actuator's.
TEST_F(FirmwareTest, SerialOutputOfJogsBecomesTheActuatorsDutyTable) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  elf_ = BuildFirmware(actuator::Feedback::kNone, actuator::CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR");
  PowerUp();
  rig_->Run(0.05);
  EXPECT_TRUE(Asks("run", "error:6")) << rig_->Serial();
  for (const int duty : {200, 400, 700, 1000})
    for (const int sign : {1, -1}) {
      rig_->Send(fmt::format("jog {} 1200", sign * duty));
      ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 2)) << rig_->Serial();
      rig_->Run(0.15);
    }
  WriteTextFile(folder_ / "serial.csv", rig_->Serial());
  const actuator::DutyLog log =
      actuator::ReadDutyLog(folder_ / "serial.csv", actuator::ParsePotentiometerScale("0=240,1023=380"));
  const actuator::DutyTable measured = actuator::MakeDutyTable(actuator::CalibrateDuty({log}, {}).rows, "measured");
  for (const int direction : {1, -1}) {
    const actuator::DutyCurve &truth = table_.Curve(direction), &found = measured.Curve(direction);
    // Ten readings in steps of 0.14 mm (uniform: 0.04 mm SD) over 1 s: 0.04 / sqrt(10 x 0.29^2) = 0.045 mm/s, times 3.
    for (const double duty : {0.4, 0.7, 1.0}) EXPECT_NEAR(found.SpeedFor(duty), truth.SpeedFor(duty), 0.14) << duty;
    EXPECT_NEAR(found.DeadBandDuty(), truth.DeadBandDuty(),
                0.02);  // 0.14 mm/s of 13 mm/s per duty, extrapolated: twice that
  }
}

}  // namespace
}  // namespace lake
