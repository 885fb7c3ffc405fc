// The firmware in a simulator of the ATmega328P: pins, PWM, brake, end stops, soft limits, watchdog, serial line, and
// the whole loop with a model of the actuator against program.csv.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifndef LAKE_AVR_GCC

TEST(Firmware, RunsInSimulator) {
  GTEST_SKIP() << "avr-gcc, libsimavr-dev or libelf-dev is not installed";
}

#else

#include <cmath>
#include <memory>
#include <sstream>

#include "avr_rig.h"
#include "firmware_build.h"
#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/stroke_schedule.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

DutyTable ModelTable() {
  return ReadDutyTable(LAKE_SOURCE_DIR "/calibration/duty_table_model.csv");
}

// The published linkage between two strokes and back: knots (s, mm).
Design DesignOf(std::vector<StrokeProgram::Knot> knots) {
  Design design;
  design.links = kPublishedLinks;
  StrokeProgram program;
  program.kind = StrokeProgram::Kind::kFree;
  program.knots = std::move(knots);
  design.program = program;
  return design;
}

// Up, slower, a reversal without a pause, a rest.
const std::vector<StrokeProgram::Knot> kKnots = {{0, 300},   {0.8, 304.8}, {1.6, 307.2},
                                                 {2.4, 302}, {2.7, 302},   {3.5, 305}};

class FirmwareTest : public testing::Test {
 protected:
  void Build(const Design& design, const std::string& flags = "-DLAKE_SIMULATOR", const ScheduleOptions& how = {}) {
    schedule_ = MakeSchedule(design, how);
    FirmwareOptions options;
    options.home_stroke_mm = schedule_.knots.front().stroke_mm - 2;
    options.home_speed_mm_s = home_speed_mm_s_;
    stroke_table_ = MakeStrokeTable(schedule_, table_, options);
    elf_ = BuildFirmware(folder_ / "build", StrokeTableHeader(stroke_table_, schedule_, table_, 242, options, "test"),
                         flags);
    actuator_.table = &table_;
    actuator_.stroke_mm = schedule_.knots.front().stroke_mm;
    actuator_.retract_stop_mm = options.home_stroke_mm;
    rig_ = std::make_unique<AvrRig>(elf_, actuator_);
  }

  // Runs until the program runs, the actuator standing at its start.
  void Start() {
    rig_->Run(0.05);
    rig_->Send("zero");
    ASSERT_TRUE(rig_->RunUntil("# ok", 0.2)) << rig_->Serial();
    rig_->Send("start");
    ASSERT_TRUE(rig_->RunUntil("# ok", 0.2)) << rig_->Serial();
  }

  // The first ms in which the bridge drives.
  double FirstDrive() const {
    for (const RigSample& sample : rig_->Samples())
      if (sample.duty != 0) return sample.time_s - 1e-3;
    return NAN;
  }

  // The time from `since` on until the bridge no longer drives.
  double DriveTimeAfter(double since_s) const {
    double last = since_s;
    for (const RigSample& sample : rig_->Samples())
      if (sample.time_s > since_s && sample.duty != 0) last = sample.time_s;
    return last - since_s;
  }

  TemporaryFolder folder_;
  double home_speed_mm_s_ = 5;
  DutyTable table_ = ModelTable();
  StrokeSchedule schedule_;
  StrokeTable stroke_table_;
  std::filesystem::path elf_;
  ActuatorModel actuator_;
  std::unique_ptr<AvrRig> rig_;
};

TEST_F(FirmwareTest, IsSafeAfterResetUntilToldToStart) {
  Build(DesignOf(kKnots));
  rig_->Run(0.5);
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0) << sample.time_s;
  EXPECT_TRUE(rig_->Changes().empty());
  EXPECT_THAT(rig_->Serial(), HasSubstr("time_s,planned_mm,duty,direction,state,adc,end_stops\n"));
  EXPECT_THAT(rig_->Serial(), HasSubstr(",,0.0000,0,idle,"));  // stroke unknown, bridge off
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# refused: not at the start", 0.2)) << rig_->Serial();
  rig_->Run(0.1);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, PwmAndDirectionFollowTheProgram) {
  Build(DesignOf(kKnots));
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  const double start = FirstDrive();
  const std::vector<ScheduleRow> rows = SampleSchedule(schedule_, 50, &table_);
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
    ASSERT_NEAR(sample.duty, rows[row].direction * rows[row].duty, 0.5 / kPwmPeriod + 1e-6) << "at " << time << " s";
    ++compared;
  }
  EXPECT_GT(compared, 3000u);
  EXPECT_THAT(rig_->Serial(), HasSubstr("# done"));
}

TEST_F(FirmwareTest, BrakesBeforeEveryReversalAndStop) {
  Build(DesignOf(kKnots));
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  // Inputs only ever change with the bridge off, or to brake.
  for (const DriveChange& change : rig_->Changes())
    EXPECT_EQ(change.enable, 0) << "inputs changed under drive at " << change.time_s << " s";
  // Between opposite duties lies the brake, for the dead time.
  int last_direction = 0, reversals = 0;
  double braked_ms = 0;
  for (const RigSample& sample : rig_->Samples()) {
    if (sample.brake) ++braked_ms;
    if (sample.duty == 0) continue;
    const int direction = sample.duty > 0 ? 1 : -1;
    if (direction == -last_direction) {
      EXPECT_NEAR(braked_ms, 100, 2) << "at " << sample.time_s << " s";  // 2 ms: the samples at both ends are shared
      ++reversals;
    }
    if (direction != last_direction || sample.duty != 0) braked_ms = 0;
    last_direction = direction;
  }
  EXPECT_EQ(reversals, 2);
  EXPECT_EQ(schedule_.reversals, 2);
  const RigSample& last = rig_->Samples().back();
  EXPECT_EQ(last.duty, 0);
  EXPECT_FALSE(last.brake);  // off at rest: the screw holds
}

TEST_F(FirmwareTest, ClosedLoopStrokeFollowsTheProgram) {
  Build(DesignOf(kKnots));
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
  rig_ = std::make_unique<AvrRig>(elf_, actuator_);
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, stroke_table_.pwm_error_mm + 0.13);
}

TEST_F(FirmwareTest, PlannedStrokeOnTheSerialLineIsTheProgram) {
  Build(DesignOf(kKnots));
  Start();
  rig_->Run(schedule_.Duration() + 0.3);
  const double start = FirstDrive();
  std::istringstream lines(rig_->Serial());
  int compared = 0;
  for (std::string line; std::getline(lines, line);) {
    double time = 0, planned = 0, duty = 0;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,", &time, &planned, &duty) != 3 ||
        line.find("running") == std::string::npos)
      continue;
    // Half a micrometre of the print, the table's rounding, and a tick of 1 ms at up to 6.5 mm/s either way.
    EXPECT_NEAR(planned, schedule_.StrokeAt(time - start), 0.0005 + stroke_table_.rounding_error_mm + 2 * 0.0065)
        << line;
    ++compared;
  }
  EXPECT_GE(compared, 30);
}

TEST_F(FirmwareTest, EndStopAheadStopsWithinTenMilliseconds) {
  for (const bool retract : {false, true}) {
    Build(DesignOf(retract ? std::vector<StrokeProgram::Knot>{{0, 310}, {3, 300}}
                           : std::vector<StrokeProgram::Knot>{{0, 300}, {3, 310}}));
    actuator_.retract_stop_mm = 0;  // only the wires act here
    rig_ = std::make_unique<AvrRig>(elf_, actuator_);
    Start();
    rig_->Run(0.7);
    ASSERT_NE(rig_->Samples().back().duty, 0);
    const double pressed = rig_->Time();
    rig_->PullWire(retract, true);
    EXPECT_TRUE(rig_->RunUntil("# fault: end stop", 0.2)) << rig_->Serial();
    // 3 ms of debouncing, one tick of 1 ms, and the simulation's own ms.
    EXPECT_LE(DriveTimeAfter(pressed), 0.010);
    RecordProperty(retract ? "retract_stop_ms" : "extend_stop_ms",
                   static_cast<int>(std::lround(1000 * DriveTimeAfter(pressed))));
    rig_->PullWire(retract, false);
    rig_->Send("start");
    EXPECT_TRUE(rig_->RunUntil("# refused: not in this state", 0.2)) << "a fault stays until reset";
    EXPECT_EQ(rig_->Samples().back().duty, 0);
    rig_->Send("reset");
    EXPECT_TRUE(rig_->RunUntil("# ok", 0.2));
    rig_->Send("start");
    EXPECT_TRUE(rig_->RunUntil("# refused: not at the start", 0.2)) << "the stroke is unknown after a fault";
  }
}

TEST_F(FirmwareTest, EndStopBehindDoesNotStop) {
  Build(DesignOf({{0, 300}, {2, 306}}));
  rig_->PullWire(true, true);
  Start();
  rig_->Run(1);
  EXPECT_GT(rig_->Samples().back().duty, 0);
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("fault")));
}

TEST_F(FirmwareTest, AGlitchOnAnEndStopDoesNotStopBothWiresOffDo) {
  Build(DesignOf({{0, 300}, {2, 306}}));
  Start();
  rig_->Run(0.3);
  rig_->PullWire(false, true);
  rig_->Run(0.0015);  // shorter than the debouncing
  rig_->PullWire(false, false);
  rig_->Run(0.2);
  EXPECT_GT(rig_->Samples().back().duty, 0);
  rig_->PullWire(true, true);
  rig_->PullWire(false, true);
  EXPECT_TRUE(rig_->RunUntil("# fault: both end stops", 0.2)) << rig_->Serial();
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, WatchdogStopsAHangingMainLoop) {
  Build(DesignOf({{0, 300}, {4, 312}}));
  Start();
  rig_->Run(0.3);
  ASSERT_GT(rig_->Samples().back().duty, 0);
  const double hung = rig_->Time();
  rig_->Send("hang");
  EXPECT_TRUE(rig_->RunUntil("# lake-stroke: the watchdog reset it", 1)) << rig_->Serial();
  EXPECT_LE(DriveTimeAfter(hung),
            0.16);  // 120 ms of the watchdog after 5 ms of sending, and its oscillator's tolerance
  RecordProperty("drove_on_ms", static_cast<int>(1000 * DriveTimeAfter(hung)));
  rig_->Run(0.5);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# refused: not at the start", 0.3)) << rig_->Serial();
}

TEST_F(FirmwareTest, EndStopsActWhileTheMainLoopHangs) {
  Build(DesignOf({{0, 300}, {4, 312}}));
  Start();
  rig_->Run(0.3);
  rig_->Send("hang");
  rig_->Run(0.02);
  ASSERT_GT(rig_->Samples().back().duty, 0);
  const double pressed = rig_->Time();
  rig_->PullWire(false, true);
  rig_->Run(0.05);
  EXPECT_LE(DriveTimeAfter(pressed), 0.010);
}

TEST_F(FirmwareTest, PauseStopAndGoOn) {
  Build(DesignOf({{0, 300}, {2, 310}}));
  Start();
  rig_->Run(0.5);
  rig_->Send("pause");
  EXPECT_TRUE(rig_->RunUntil("# ok", 0.2));
  rig_->Run(0.4);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# done", 3)) << rig_->Serial();
  rig_->Run(0.1);
  // The pause costs a run-up and a run-down: 5 mm/s x (30 + 30 - 10 - 10) ms, and rounding of the PWM.
  EXPECT_NEAR(rig_->Stroke(), 310, 5 * 0.04 + stroke_table_.pwm_error_mm + 0.02);

  rig_ = std::make_unique<AvrRig>(elf_, actuator_);
  Start();
  rig_->Run(0.5);
  rig_->Send("stop");
  EXPECT_TRUE(rig_->RunUntil("# ok", 0.2));
  rig_->Run(0.3);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# refused: not at the start", 0.2)) << "half way is not the start";
}

TEST_F(FirmwareTest, HomesToTheEndStopThenToTheStart) {
  actuator_.stroke_mm = 0;
  Build(DesignOf({{0, 300}, {2, 306}}));
  rig_->SetStroke(303.7);
  rig_->Run(0.05);
  rig_->Send("home");
  ASSERT_TRUE(rig_->RunUntil("# done", 8)) << rig_->Serial();
  rig_->Run(0.2);
  // Run-on past the switch: 5 mm/s x (4 ms + 10 ms brake); the way out loses 5 mm/s x (30 - 10) ms; PWM rounding below
  // 0.02.
  EXPECT_NEAR(rig_->Stroke(), 300, 0.07 + 0.10 + 0.03);
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# done", 4)) << rig_->Serial();
  EXPECT_NEAR(rig_->Stroke(), 306, 0.07 + 0.2 + 0.03);
}

TEST_F(FirmwareTest, HomingWithoutAnEndStopGivesUp) {
  home_speed_mm_s_ = 11;
  Design design = DesignOf({{0, 300}, {2, 306}});
  design.d_max_mm = 308;  // little travel, so that it gives up after 3.4 s
  Build(design);
  actuator_.retract_stop_mm = -1000;
  rig_ = std::make_unique<AvrRig>(elf_, actuator_);
  rig_->Run(0.05);
  rig_->Send("home");
  EXPECT_TRUE(rig_->RunUntil("# fault: no end stop met while homing", 5)) << rig_->Serial();
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, JogKeepsTheSoftLimits) {
  Build(DesignOf({{0, 372}, {1, 373}}));  // the upper soft limit is 374.02 mm
  rig_->Run(0.05);
  rig_->Send("zero");
  ASSERT_TRUE(rig_->RunUntil("# ok", 0.2));
  rig_->Send("jog 700 5000");
  EXPECT_TRUE(rig_->RunUntil("# jog ended at an end stop or soft limit", 5)) << rig_->Serial();
  rig_->Run(0.1);
  EXPECT_LE(rig_->Stroke(), schedule_.limits.upper_mm + 0.15);
  rig_->Send("jog 700 500");
  EXPECT_TRUE(rig_->RunUntil("# refused: soft limit", 0.2));
  rig_->Send("jog -700 300");
  EXPECT_TRUE(rig_->RunUntil("# done", 1)) << "back is allowed";
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# refused: not at the start", 0.2)) << "after a jog the start is somewhere else";
}

TEST_F(FirmwareTest, ToleratesGarbageOnTheSerialLine) {
  Build(DesignOf({{0, 300}, {1, 303}}));
  rig_->Run(0.05);
  for (const char* line : {"", "strat", "jog", "jog 0 100", "jog 2000 100", "jog 100 99999", "jog 100", "jog 1 2 3",
                           "\xff\xfe\x01", "a line that is far longer than the buffer of the receiver, and then some"})
    rig_->Send(line), rig_->Run(0.15);
  EXPECT_THAT(rig_->Serial(), HasSubstr("# refused: jog DUTY MS"));
  EXPECT_THAT(rig_->Serial(), HasSubstr("# unknown"));
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0);
  Start();
  EXPECT_TRUE(rig_->RunUntil("# done", 2)) << "and goes on to work";
  rig_->Send("quit");
  rig_->Run(0.2);
  EXPECT_TRUE(rig_->HasEnded());
}

TEST_F(FirmwareTest, FromSixtyDegreesToStandingAtThePapersSpeed) {
  Design design;
  design.links = kPublishedLinks;
  design.program.emplace().speed_mm_s = 5;
  ScheduleOptions from_sixty;
  from_sixty.from_deg = 60;
  Build(design, "-DLAKE_SIMULATOR", from_sixty);
  Start();
  EXPECT_TRUE(rig_->RunUntil("# done", schedule_.Duration() + 1)) << rig_->Serial();
  rig_->Run(0.1);
  // Lag 5 mm/s x (30 - 10) ms = 0.10 mm; PWM rounding as computed.
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, 0.10 + stroke_table_.pwm_error_mm + 0.02);
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("fault")));
  RecordProperty("end_error_um", static_cast<int>(1000 * (rig_->Stroke() - schedule_.knots.back().stroke_mm)));
}

TEST_F(FirmwareTest, CalibrationFirmwareJogsAndHasNoProgram) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  const auto elf = BuildFirmware(folder_ / "calibration", CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR");
  rig_ = std::make_unique<AvrRig>(elf, actuator_);
  rig_->Run(0.05);
  rig_->Send("start");
  EXPECT_TRUE(rig_->RunUntil("# refused: this firmware is for calibration", 0.2)) << rig_->Serial();
  rig_->Send("jog -500 800");
  rig_->Run(0.5);
  EXPECT_NEAR(rig_->Samples().back().duty, -0.5, 0.5 / kPwmPeriod);
  EXPECT_TRUE(rig_->RunUntil("# done", 1)) << rig_->Serial();
}

// The whole way of a new actuator: the calibration firmware jogs it, its serial output with the potentiometer's
// readings becomes a duty table, and that table is the actuator's.
TEST_F(FirmwareTest, SerialOutputOfJogsBecomesTheActuatorsDutyTable) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  actuator_.potentiometer_mm[0] = 240, actuator_.potentiometer_mm[1] = 380;
  rig_ = std::make_unique<AvrRig>(
      BuildFirmware(folder_ / "calibration", CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR"), actuator_);
  rig_->Run(0.05);
  for (const int duty : {200, 400, 700, 1000})
    for (const int sign : {1, -1}) {
      rig_->Send(fmt::format("jog {} 1200", sign * duty));
      ASSERT_TRUE(rig_->RunUntil("# done", 2)) << rig_->Serial();
      rig_->Run(0.15);
    }
  WriteTextFile(folder_ / "serial.csv", rig_->Serial());
  const DutyLog log = ReadDutyLog(folder_ / "serial.csv", ParsePotentiometerScale("0=240,1023=380"));
  const DutyTable measured = MakeDutyTable(CalibrateDuty({log}, {}).rows, "measured");
  for (const int direction : {1, -1}) {
    const DutyCurve &truth = table_.Curve(direction), &found = measured.Curve(direction);
    // Ten readings in steps of 0.14 mm (uniform: 0.04 mm SD) over 1 s: 0.04 / sqrt(10 x 0.29^2) = 0.045 mm/s, times 3.
    for (const double duty : {0.4, 0.7, 1.0}) EXPECT_NEAR(found.SpeedFor(duty), truth.SpeedFor(duty), 0.14) << duty;
    EXPECT_NEAR(found.DeadBandDuty(), truth.DeadBandDuty(),
                0.02);  // 0.14 mm/s of 13 mm/s per duty, extrapolated: twice that
  }
}

// What a user uploads: without the simulator's hooks, and within the flash next to the largest table.
TEST_F(FirmwareTest, ReleaseBuildFitsTheFlash) {
  Build(DesignOf(kKnots), "");
  rig_->Run(0.05);
  rig_->Send("hang");
  EXPECT_TRUE(rig_->RunUntil("# unknown", 0.2)) << rig_->Serial();
  const std::string line =
      "avr-size '" + elf_.string() + "' | awk 'NR==2 {print $1+$2, $2+$3}' > '" + (folder_ / "size").string() + "'";
  ASSERT_EQ(std::system(line.c_str()), 0);
  int flash = 0, ram = 0;
  ASSERT_EQ(std::sscanf(ReadTextFile(folder_ / "size").c_str(), "%d %d", &flash, &ram), 2);
  EXPECT_LT(flash - static_cast<int>(stroke_table_.segments.size()) * kSegmentBytes, kFirmwareBytes);
  EXPECT_LT(ram, 1024);  // of 2048; the stack needs the rest
  RecordProperty("flash_bytes", flash);
}

}  // namespace
}  // namespace lake

#endif
