// lake-stroke as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/program_run.h"
#include "lake/actuator/firmware.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "model_program.h"
#include "places.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string kTable = Quoted(SourceDir() / "calibration/duty_table_model.csv");

class StrokeProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    WriteTextFile(folder_ / "design.yaml",
                  "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n"
                  "program: {kind: constant, speed_mm_s: 5}\n");
  }
  Outcome Run(const std::string& arguments) { return Shell(folder_, "lake-stroke " + arguments); }

  TemporaryFolder folder_;
};

TEST_F(StrokeProgramTest, WritesProgramAndFirmware) {
  const Outcome run = Run(std::string("design.yaml --margin 6 -o out --json --duty-table ") + kTable);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  EXPECT_NEAR(summary["duration_s"].get<double>(), (374.5205 - 241.9978 - 12) / 5, 1e-3);
  EXPECT_EQ(summary["inputs"].size(), 2u);
  EXPECT_LT(summary["firmware"]["pwm_error_mm"].get<double>(), 0.05);
  const CsvTable table = CsvTable::Read(folder_ / "out/program.csv");
  EXPECT_EQ(table.Header(),
            (std::vector<std::string>{"time_s", "stroke_mm", "speed_mm_s", "knee_deg", "direction", "duty"}));
  EXPECT_NEAR(table.RequiredNumber(0, 5), (5 / 1.1 + 3.2) / 12, 1e-4);
  for (const char* name : {"program.png", "lake_stroke/stroke_table.h", "lake_stroke/lake_stroke.ino",
                           "lake_stroke/controller.c", "summary.json", "options.toml"})
    EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out" / name)) << name;
#ifdef LAKE_AVR_GCC
  const Outcome build =
      Shell(folder_, std::string("cd out/lake_stroke && ") + LAKE_AVR_GCC +
                         " -mmcu=atmega328p -std=gnu99 -Os -Wall -Wextra -Werror *.c -o firmware.elf");
  EXPECT_EQ(build.exit_code, 0) << build.err;
#endif
}

// The published design to standing but for 0.5 mm: 131 mm of way leave no room for what a speed may differ.
TEST_F(StrokeProgramTest, ADriftThatLeavesTheRoomIsRefusedUnlessAccepted) {
  const std::string arguments = std::string("design.yaml -o out --duty-table ") + kTable;
  const Outcome refused = Run(arguments);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(refused.ErrorLines(), 1) << refused.err;
  EXPECT_THAT(refused.err, AllOf(HasSubstr("past the linkage's end at 374.5"), HasSubstr("374.02"), HasSubstr(" ± "),
                                 HasSubstr("--margin"), HasSubstr("--accept-drift")));
  EXPECT_EQ(FilesIn(folder_ / "out"), 0u);

  const Outcome accepted = Run(arguments + " --accept-drift");
  ASSERT_EQ(accepted.exit_code, 0) << accepted.err;
  EXPECT_THAT(accepted.err, HasSubstr("the drift was accepted: 374.02"));
  EXPECT_THAT(accepted.out, HasSubstr("DRIFT ACCEPTED: only for a bench without a person"));
  for (const char* name : {"lake_stroke/lake_stroke.ino", "lake_stroke/stroke_table.h", "stroke_table.h"})
    EXPECT_THAT(ReadTextFile(folder_ / "out" / name), StartsWith("// DRIFT ACCEPTED: ")) << name;
  const Json drift = Json::parse(ReadTextFile(folder_ / "out/summary.json"))["firmware"]["drift"];
  EXPECT_TRUE(drift["accepted"].get<bool>());
  EXPECT_FALSE(drift["fits"].get<bool>());

  const Outcome fits = Run(arguments + " --margin 6 --json");
  ASSERT_EQ(fits.exit_code, 0) << fits.err;
  EXPECT_TRUE(Json::parse(fits.out)["firmware"]["drift"]["fits"].get<bool>());
  EXPECT_THAT(ReadTextFile(folder_ / "out/lake_stroke/lake_stroke.ino"), Not(HasSubstr("DRIFT ACCEPTED")));
}

// Before the program is sampled and the prototype aligned, which here cannot be: its knee does not move.
TEST_F(StrokeProgramTest, AFolderThatIsTakenIsFoundBeforeTheWork) {
  motion::LegMotion still;
  for (int i = 0; i < 100; ++i) {
    still.frame.push_back(i), still.time_s.push_back(i / 30.0);
    still.samples.emplace_back().knee_deg = 90;
  }
  std::filesystem::create_directories(folder_ / "still");
  motion::WriteKinematicsCsv(folder_ / "still/kinematics.csv", still);
  const std::string arguments = "design.yaml --validate still -o out";
  EXPECT_THAT(Run(arguments).err, HasSubstr("which cannot be aligned"));
  EXPECT_EQ(FilesIn(folder_ / "out"), 0u);
  std::filesystem::create_directories(folder_ / "out");
  WriteTextFile(folder_ / "out/validation.csv", "a user's own");
  const Outcome taken = Run(arguments);
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_THAT(taken.err, HasSubstr("out/validation.csv: is not a result of lake's"));
  EXPECT_EQ(ReadTextFile(folder_ / "out/validation.csv"), "a user's own");
  EXPECT_EQ(FilesIn(folder_ / "out"), 1u);
}

// With a potentiometer no drift needs room; the sketch's folder says what it is for.
TEST_F(StrokeProgramTest, FeedbackCurrentAndSupplyGoIntoTheSketch) {
  const std::string base = std::string("design.yaml --margin 2 -o out --duty-table ") + kTable + " --feedback pot";
  const Outcome no_scale = Run(base);
  EXPECT_EQ(no_scale.exit_code, 2);
  EXPECT_THAT(no_scale.err, HasSubstr("--pot COUNTS=MM,COUNTS=MM"));
  const Outcome run = Run(base + " --pot 102=242,921=372 --supply 12 --current-sense");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string header = ReadTextFile(folder_ / "out/lake_stroke/stroke_table.h");
  for (const char* line : {"#define LAKE_FEEDBACK 1\n", "#define LAKE_SUPPLY_SENSE 1\n",
                           "#define LAKE_CURRENT_SENSE 1\n", "#define LAKE_CURRENT_ZERO 2046\n"})
    EXPECT_THAT(header, HasSubstr(line));
  const std::string ino = ReadTextFile(folder_ / "out/lake_stroke/lake_stroke.ino");
  for (const char* part : {"from design.yaml and duty_table_model.csv", "(SHA-256)", "MODEL duty table", "UNWORN ONLY"})
    EXPECT_THAT(ino, HasSubstr(part));
  EXPECT_THAT(ino, Not(HasSubstr("open loop")));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out/lake_stroke/README.txt"));
#ifdef LAKE_AVR_GCC
  const Outcome build =
      Shell(folder_, std::string("cd out/lake_stroke && ") + LAKE_AVR_GCC +
                         " -mmcu=atmega328p -std=gnu99 -Os -Wall -Wextra -Werror *.c -o firmware.elf && avr-size "
                         "firmware.elf | awk 'NR==2 {print $1+$2}'");
  ASSERT_EQ(build.exit_code, 0) << build.err;
  const Json summary = Json::parse(ReadTextFile(folder_ / "out/summary.json"));
  const int code = std::stoi(build.out) - summary["firmware"]["segment_bytes"].get<int>();
  std::printf("flash with potentiometer, current and supply: %d bytes of %d\n", code, actuator::kFirmwareBytes);
  EXPECT_LT(code, actuator::kFirmwareBytes);
#endif
}

TEST_F(StrokeProgramTest, WithoutADutyTableSaysSoAndWritesNoFirmware) {
  const Outcome run = Run("design.yaml -o out");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no firmware is written; measure one (lake-stroke calibrate)"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/lake_stroke"));
  const CsvTable table = CsvTable::Read(folder_ / "out/program.csv");
  for (std::size_t i = 0; i < table.Rows(); ++i) ASSERT_FALSE(table.Number(i, 5)) << "row " << i;
}

TEST_F(StrokeProgramTest, OptionsFromAFileGiveTheSameProgram) {
  ASSERT_EQ(Run("design.yaml -o a --speed 4 --from-angle 80 --return --rate 20").exit_code, 0);
  const Outcome run = Run("--config a/options.toml -o b");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadTextFile(folder_ / "a/program.csv"), ReadTextFile(folder_ / "b/program.csv"));
}

// A tracked human gives the constant program its angles; the prototype's video is compared with it.
TEST_F(StrokeProgramTest, MotionAndValidation) {
  motion::LegMotion human, prototype;
  for (int i = 0; i <= 100; ++i) {
    motion::LegSample sample;
    sample.repetition = 1;
    sample.percent = i;
    sample.knee_deg = 95 - 0.88 * i;  // 95 to 7 degrees
    human.frame.push_back(i), human.time_s.push_back(i / 60.0), human.samples.push_back(sample);
  }
  std::filesystem::create_directories(folder_ / "human");
  motion::WriteKinematicsCsv(folder_ / "human/kinematics.csv", human);
  ASSERT_EQ(Run("design.yaml -o a --motion human").exit_code, 0);
  const CsvTable program = CsvTable::Read(folder_ / "a/program.csv");
  EXPECT_NEAR(program.RequiredNumber(0, 3), 95, 1e-9);
  EXPECT_NEAR(program.RequiredNumber(program.Rows() - 1, 3), 7, 1e-9);

  // The prototype follows the program from 1.5 s on, sampled at 30 Hz, two degrees too far bent.
  const double duration = program.RequiredNumber(program.Rows() - 1, 0);
  for (int i = 0; i / 30.0 < duration + 3; ++i) {
    const double at = std::clamp(i / 30.0 - 1.5, 0.0, duration);
    const double d0 = program.RequiredNumber(0, 1);
    motion::LegSample sample;
    sample.knee_deg = actuator::KneeDegAt(kPublishedLinks, d0 + 5 * at) + 2;
    if (i % 50 == 7) sample.knee_deg = std::nan("");
    prototype.frame.push_back(i), prototype.time_s.push_back(i / 30.0), prototype.samples.push_back(sample);
  }
  std::filesystem::create_directories(folder_ / "prototype");
  motion::WriteKinematicsCsv(folder_ / "prototype/kinematics.csv", prototype);
  const Outcome run = Run("design.yaml -o b --motion human --validate prototype --speed 5 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json v = Json::parse(run.out)["validation"];
  EXPECT_NEAR(v["offset_deg"].get<double>(), 2, 1e-3);
  EXPECT_LT(v["rms_with_offset_deg"].get<double>(), 1e-3);
  EXPECT_NEAR(v["shift_s"].get<double>(), 1.5, 0.5);  // two degrees are 0.4 s
  EXPECT_THAT(run.err, HasSubstr("a constant +2.00°"));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "b/validation.png"));
  EXPECT_EQ(CsvTable::Read(folder_ / "b/validation.csv").Header().front(), "time_s");
}

// A slow stretch costs no warning, but is told with what it costs; the table says 0.44 mm/s is the slowest.
TEST_F(StrokeProgramTest, CrawlingIsSteppedAndTold) {
  WriteTextFile(folder_ / "slow.yaml",
                "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n"
                "program: {kind: free, knots: [[0, 300], [2, 310], [6, 310.4], [8, 320]]}\n");
  const Outcome run = Run(std::string("slow.yaml -o out --duty-table ") + kTable);
  EXPECT_THAT(run.out, HasSubstr(actuator::kUntried));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  // 0.4 mm in 4 s: two steps of 0.2 mm, behind by 0.1 mm/s x (2 - 0.2 / 0.44) s.
  EXPECT_THAT(run.out, HasSubstr("for 4.00 s: rests and steps instead, at most 0.155 mm"));
  EXPECT_EQ(Run("slow.yaml -o out --max-acceleration 20").exit_code, 0);
  // A ramp of 5 / 20 s in 13 stretches: the middle of the first has 5 x 0.5 / 13 mm/s.
  EXPECT_NEAR(CsvTable::Read(folder_ / "out/program.csv").RequiredNumber(0, 2), 5 * 0.5 / 13, 1e-6);
}

// The strokes of a calibration from a video: two markers on the actuator, which hangs obliquely in the picture.
TEST_F(StrokeProgramTest, CalibrateFromATrackedVideo) {
  std::string log = "time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops\n";
  motion::MarkerRecording film;
  film.unit = motion::LengthUnit::kMm;
  film.markers = {{"mount", {}}, {"rod", {}}};
  const auto duty_at = [](double t) {  // rests of 1 s, then 1.5 s of each duty, extending and retracting
    const int jog = static_cast<int>(t / 2.5);
    const double duties[] = {0.3, -0.3, 0.5, -0.5, 0.8, -0.8, 1, -1};
    return jog < 8 && t - 2.5 * jog >= 1 ? duties[jog] : 0;
  };
  for (double t = 0.1; t < 22; t += 0.1) log += fmt::format("{:.3f},,,{:.4f},1,jogging,0,0\nok\n", t, duty_at(t));
  double length = 300;
  for (int i = 0; i < 21 * 60; ++i) {
    const double t = i / 60.0, duty = duty_at(t + 0.73);  // the film began 0.73 s after the log's clock
    if (duty != 0) length += (duty > 0 ? 10 * (duty - 0.2) : 12 * (duty + 0.1)) / 60;
    film.frame.push_back(i), film.time_s.push_back(t);
    film.markers[0].samples.push_back({{100, 50}, 0.05, motion::SampleStatus::kDetected});
    film.markers[1].samples.push_back({{100 + 0.6 * length, 50 + 0.8 * length}, 0.05, motion::SampleStatus::kDetected});
  }
  film.markers[1].samples[300].status = motion::SampleStatus::kMissing;
  WriteTextFile(folder_ / "serial.csv", log);
  std::filesystem::create_directories(folder_ / "film");
  motion::WriteMarkerCsv(folder_ / "film/trajectory.csv", film);
  const Outcome run = Run("calibrate serial.csv --video film -o duty --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  EXPECT_NEAR(summary["video"]["shift_s"].get<double>(), 0.73, 0.06);  // the log's rows are 0.1 s apart
  EXPECT_NEAR(summary["dead_band"]["extend"]["duty"].get<double>(), 0.2, 1e-3);
  EXPECT_NEAR(summary["dead_band"]["retract"]["duty"].get<double>(), 0.1, 1e-3);
  const actuator::DutyTable table = actuator::ReadDutyTable(folder_ / "duty/duty_table.csv");
  for (const double duty : {0.3, 0.5, 0.8, 1.0}) {
    EXPECT_NEAR(table.extend.SpeedFor(duty), 10 * (duty - 0.2), 1e-3);
    EXPECT_NEAR(table.retract.SpeedFor(duty), 12 * (duty - 0.1), 1e-3);
  }
  const struct {
    const char *arguments, *message;
    int exit_code;
  } cases[] = {{"calibrate serial.csv --video nowhere", "no trajectory.csv", 1},
               {"calibrate serial.csv --video film --rod-markers mount,tip", "no marker 'tip'", 1},
               {"calibrate serial.csv --video film --rod-markers mount", "two names", 2},
               {"calibrate serial.csv serial.csv --video film", "the one log", 2}};
  for (const auto& c : cases) {
    const Outcome bad = Run(std::string(c.arguments) + " -o bad");
    EXPECT_EQ(bad.exit_code, c.exit_code) << c.arguments;
    EXPECT_THAT(bad.err, HasSubstr(c.message)) << c.arguments;
  }
  // Another run's film: every jog the other way round in time.
  std::reverse(film.markers[1].samples.begin(), film.markers[1].samples.end());
  for (std::size_t i = 0; i < film.markers[1].samples.size(); ++i)
    film.markers[1].samples[i].position.x() += 40 * std::sin(0.05 * static_cast<double>(i));
  motion::WriteMarkerCsv(folder_ / "film/trajectory.csv", film);
  const Outcome other = Run("calibrate serial.csv --video film -o bad");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, HasSubstr("agree nowhere"));
}

TEST_F(StrokeProgramTest, CalibrateMakesATable) {
  std::string log = "time_s,stroke_mm,duty\n";
  double time = 0, stroke = 300;
  for (const double duty : {0.3, -0.3, 0.5, -0.5, 0.8, -0.8})
    for (int i = 0; i < 100; ++i) {
      time += 0.01, stroke += 0.01 * (duty > 0 ? 10 * (duty - 0.2) : 10 * (duty + 0.1));
      log += fmt::format("{:.2f},{:.4f},{}\n", time, stroke, duty);
    }
  WriteTextFile(folder_ / "log.csv", log);
  const Outcome run = Run("calibrate log.csv -o duty --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  EXPECT_NEAR(summary["dead_band"]["extend"]["duty"].get<double>(), 0.2, 1e-3);
  EXPECT_NEAR(summary["dead_band"]["retract"]["duty"].get<double>(), 0.1, 1e-3);
  EXPECT_EQ(Run("design.yaml --margin 15 -o out --duty-table duty/duty_table.csv").exit_code, 0);
  EXPECT_EQ(Run("calibrate --write-firmware -o cal").exit_code, 0);
  EXPECT_THAT(ReadTextFile(folder_ / "cal/lake_stroke/stroke_table.h"), HasSubstr("#define LAKE_HAS_PROGRAM 0"));
  EXPECT_THAT(Run("run cal --port /dev/null -o log").err, HasSubstr("no program of lake-stroke"));
}

TEST_F(StrokeProgramTest, ErrorsAreOneLineWithTheRightCodeAndLeaveNothing) {
  const std::string free =
      "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n";
  WriteTextFile(folder_ / "far.yaml", free + "program: {kind: free, knots: [[0, 300], [20, 376]]}\n");
  WriteTextFile(folder_ / "long.yaml", free + "program: {kind: free, knots: [[0, 300], [1e12, 310]]}\n");
  WriteTextFile(folder_ / "nan.yaml", free + "program: {kind: free, knots: [[0, 300], [.nan, 310]]}\n");
  WriteTextFile(folder_ / "zero.yaml", free + "program: {kind: constant, speed_mm_s: 0}\n");
  WriteTextFile(folder_ / "none.yaml", free);
  WriteTextFile(folder_ / "bad.csv", "duty,extend_mm_s\n0.1,nan\n");
  WriteTextFile(folder_ / "empty.csv", "");
  const struct {
    const char* arguments;
    int exit_code;
    const char* message;
  } cases[] = {
      {"", 2, "the design is missing"},
      {"nowhere.yaml", 1, "nowhere.yaml"},
      {"far.yaml", 1, "stroke 376.0000 mm at 20 s is above the soft limit 374.02"},
      {"long.yaml", 1, "more than 1000000 rows"},
      {"nan.yaml", 1, "nan.yaml:3"},
      {"zero.yaml", 1, "speed_mm_s must be above 0"},
      {"none.yaml", 2, "--speed"},
      {"design.yaml --speed 0", 2, "--speed"},
      {"design.yaml --speed -5", 2, "--speed"},
      {"design.yaml --speed nan", 2, "--speed"},
      {"design.yaml --rate 0", 2, "--rate"},
      {"design.yaml --margin 500", 1, "leaves nothing"},
      {"design.yaml --max-speed 3", 1, "--max-speed is 3 mm/s"},
      {"design.yaml --max-acceleration 0", 2, "--max-acceleration"},
      {"design.yaml --dead-time 0.05", 2, "--dead-time"},
      {"design.yaml --tolerance 0", 2, "--tolerance"},
      {"design.yaml --duty-table bad.csv", 1, "bad.csv"},
      {"design.yaml --duty-table empty.csv", 1, "empty.csv"},
      {"design.yaml --validate nowhere", 1, "no kinematics.csv"},
      {"design.yaml --motion nowhere", 1, "no kinematics.csv"},
      {"design.yaml --from-angle 175", 2, "--from-angle 175"},
      {"calibrate", 2, "no logs given"},
      {"calibrate empty.csv", 1, "empty.csv"},
      {"calibrate design.yaml", 1, "design.yaml:1"},
      {"calibrate empty.csv --pot 3", 2, "--pot"},
      {"design.yaml --no-such-option", 2, "no-such-option"},
  };
  for (const auto& c : cases) {
    const Outcome run = Run(std::string(c.arguments) + " -o out");
    EXPECT_EQ(run.exit_code, c.exit_code) << c.arguments << "\n" << run.err;
    EXPECT_EQ(run.ErrorLines(), 1) << c.arguments << "\n" << run.err;
    EXPECT_THAT(run.err, HasSubstr(c.message)) << c.arguments;
    EXPECT_EQ(FilesIn(folder_ / "out"), 0u) << c.arguments;
  }
  const Outcome fast = Run(std::string("design.yaml --speed 11 -o out --duty-table ") + kTable);
  EXPECT_EQ(fast.exit_code, 1);
  EXPECT_THAT(fast.err, HasSubstr("asks for 11 mm/s from 0 s"));
  EXPECT_EQ(FilesIn(folder_ / "out"), 0u);
}

}  // namespace
}  // namespace lake
