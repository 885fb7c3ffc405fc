// Walking by lake-gait and lake-compare: their files, and what is said where nobody walks forward.
#include <gmock/gmock.h>

#include <fstream>

#include "cli/program_run.h"
#include "exchange/model_output.h"
#include "gait/drawn_walk.h"
#include "gait/worn_joint_marker.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/exchange/c3d.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class WalkingProgram : public testing::Test {
 protected:
  void Write(const DrawnWalkOptions& drawn) { motion::WriteMarkerCsv(folder_ / "walk.csv", DrawWalk(drawn)); }

  const std::string kGait = "lake-gait walk.csv --json -o W ";
  TemporaryFolder folder_;
};

TEST_F(WalkingProgram, WritesTheStrides) {
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.5;
  Write(drawn);
  const Json summary = DoneJson(folder_, kGait);
  EXPECT_EQ(summary["movement"], "walking");
  EXPECT_EQ(summary["walking"]["ground"], "overground");
  EXPECT_EQ(summary["walking"]["incomplete_strides"], 2);
  const CsvTable cycles = CsvTable::Read(folder_ / "W/gait_cycles.csv");
  const int strides = summary["walking"]["strides"];
  EXPECT_EQ(static_cast<int>(cycles.Rows()), strides + 2);
  // As drawn; the tolerance is that of tests/gait/walking_test.cc.
  EXPECT_NEAR(cycles.RequiredNumber(0, cycles.Column("stride_s")), drawn.stride_s, 0.01);
  EXPECT_TRUE(CsvTable::Read(folder_ / "W/events.csv").Has("sd_s"));
  const CsvTable kinematics = CsvTable::Read(folder_ / "W/kinematics.csv");
  int in_stride = 0;
  for (std::size_t row = 0; row < kinematics.Rows(); ++row)
    in_stride += kinematics.Number(row, kinematics.Column("percent")).has_value() ? 1 : 0;
  EXPECT_NEAR(in_stride, strides * drawn.stride_s * drawn.rate_hz, 5);
  EXPECT_TRUE(fs::exists(folder_ / "W/gait_cycles.png"));
  EXPECT_FALSE(fs::exists(folder_ / "W/sit_to_stand.csv"));
}

TEST_F(WalkingProgram, IsComparedWithTheModelOfTheSameC3d) {
  Write({});
  Done(folder_, kGait);
  const CsvTable kinematics = CsvTable::Read(folder_ / "W/kinematics.csv");
  constexpr double kOffset_deg = 5;
  exchange::PointRecording points = exchange::PointsFromMarkers(DrawWalk({}));
  exchange::PointTrack& output = points.points.emplace_back();
  output.name = "LKneeAngles";
  for (std::size_t row = 0; row < kinematics.Rows(); ++row)
    output.positions.emplace_back(kinematics.RequiredNumber(row, kinematics.Column("knee_deg")) + kOffset_deg, 1, 2);
  exchange::WriteC3d(folder_ / "plain.c3d", points);
  const std::string plain = ReadTextFile(folder_ / "plain.c3d");
  WriteTextFile(folder_ / "angle.c3d", WithModelOutput(plain, "ANGLES", "LKneeAngles", "deg"));
  WriteTextFile(folder_ / "moment.c3d", WithModelOutput(plain, "MOMENTS", "LKneeAngles", "Nmm"));
  const std::string compare = " --json -o C --compare-with ";
  const Json difference = DoneJson(folder_, "lake-gait angle.c3d" + compare + "LKneeAngles")["compare_with"];
  EXPECT_NEAR(difference["offset_deg"], -kOffset_deg, 0.05);
  EXPECT_LT(difference["sd_deg"], 0.1);
  EXPECT_GT(difference["correlation"], 0.9999);
  EXPECT_EQ(CsvTable::Read(folder_ / "C/model_output.csv").Rows(), points.frame.size());
  EXPECT_THAT(Shell(folder_, "lake-gait angle.c3d" + compare + "RKneeAngles").err, HasSubstr("it has: LKneeAngles"));
  EXPECT_THAT(Shell(folder_, "lake-gait moment.c3d" + compare + "LKneeAngles").err, HasSubstr("not an angle"));
}

TEST_F(WalkingProgram, SaysWhatItLeavesOut) {
  DrawnWalkOptions drawn;
  drawn.is_backward = true;
  Write(drawn);
  const Outcome outcome = Done(folder_, kGait);
  EXPECT_THAT(outcome.err, HasSubstr("the person walks backward"));
  EXPECT_THAT(outcome.err, HasSubstr("repetition and percent are left empty"));
  EXPECT_FALSE(fs::exists(folder_ / "W/gait_cycles.csv"));
  ExpectRefused(folder_, kGait + "--movement dancing", 2, "--movement");
}

// --movement of all programs that measure or have others measure; of lake-run over what the study's trial says.
TEST_F(WalkingProgram, TakesTheMovementInEveryProgram) {
  for (const char* program : {"track", "gait", "compare", "run", "cohort", "review"})
    EXPECT_THAT(Shell(folder_, fmt::format("lake-{} --help", program)).out,
                HasSubstr("--movement auto|sit-to-stand|walking|squat"))
        << program;
  Write({});
  std::ofstream(folder_ / "study.yaml") << "human: {trial: walk.csv, movement: sit-to-stand}\n";
  const auto movement = [&](const std::string& options) {
    Done(folder_, "lake-run study.yaml --only human -o S " + options);
    return ReadJsonFile(folder_ / "S/human/summary.json")["movement"];
  };
  EXPECT_TRUE(movement("").is_null());
  EXPECT_EQ(movement("--movement walking"), "walking");
  EXPECT_EQ(movement("--movement auto"), "walking");
  EXPECT_TRUE(movement("").is_null());
}

TEST_F(WalkingProgram, ForcePlatesWinOverTheMarkers) {
  const fs::path data = SharedData() / "walking_force_plates";
  if (!fs::exists(data)) GTEST_SKIP() << "no recordings";
  const CsvTable plates = CsvTable::Read(data / "plate_events.csv");
  const std::string leg = "--map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS,heel=r_calc,toe=r_toe";
  const std::string both = leg + ",other_ankle=L_ankle,other_heel=L_calc,other_toe=L_toe";
  for (const std::string& names : {leg, both}) {
    const Json summary =
        DoneJson(folder_, fmt::format("lake-gait {} {} --forces {} --json -o P", Quoted(data / "walking1.trc"), names,
                                      Quoted(data / "walking1_grf.mot")));
    const CsvTable events = CsvTable::Read(folder_ / "P/events.csv");
    std::size_t expected = 0;
    for (std::size_t row = 0; row < plates.Rows(); ++row) {
      const bool is_other = plates.Text(row, 1) == "L";
      if (plates.Text(row, 0) != "walking1" || (is_other && names == leg)) continue;
      ++expected;
      const std::string kind = plates.Text(row, 2) + (is_other ? "_other" : "");
      double nearest_s = 1;
      for (std::size_t i = 0; i < events.Rows(); ++i)
        if (events.Text(i, 1) == kind)
          nearest_s = std::min(
              nearest_s, std::abs(events.RequiredNumber(i, events.Column("time_s")) - plates.RequiredNumber(row, 3)));
      EXPECT_LT(nearest_s, 1e-3) << kind;
    }
    const Json& found = summary["walking"]["force_plates"];
    EXPECT_EQ(found.size(), expected);
    for (const Json& event : found) EXPECT_LT(std::abs(NumberOrNaN(event["markers_later_s"])), 0.04) << event;
  }
}

TEST_F(WalkingProgram, ExportsItsEvents) {
  Write({});
  Done(folder_, kGait);
  ExpectRefused(folder_, "lake-convert W walk.c3d", 2, "give --leg");
  Done(folder_, "lake-convert W walk.c3d --leg left");
  const CsvTable events = CsvTable::Read(folder_ / "W/events.csv");
  const Json info = DoneJson(folder_, "lake-info walk.c3d --json");
  ASSERT_EQ(info["events"].size(), events.Rows()) << info;
  for (std::size_t i = 0; i < events.Rows(); ++i) {
    const bool is_other = events.Text(i, 1).ends_with("_other"), is_strike = events.Text(i, 1).starts_with("heel");
    EXPECT_EQ(info["events"][i]["context"], is_other ? "Right" : "Left");
    EXPECT_EQ(info["events"][i]["label"], is_strike ? "Foot Strike" : "Foot Off");
    EXPECT_NEAR(info["events"][i]["time_s"].get<double>(), events.RequiredNumber(i, events.Column("time_s")), 0.011);
  }
  Done(folder_, "lake-convert W walk.mot --leg left");
  EXPECT_THAT(ReadTextFile(folder_ / "walk.mot"), HasSubstr("trunk_tilt\trepetition\tpercent\n"));
}

TEST_F(WalkingProgram, LoadsOverStance) {
  const fs::path data = SharedData() / "walking_force_plates";
  if (!fs::exists(data)) GTEST_SKIP() << "no recordings";
  const std::string trial = "lake-loads " + (data / "walking1.trc").string() + " --mass 70 --draws 20 -o L --map ",
                    forces = " --forces " + (data / "walking1_grf.mot").string();
  const std::string left = "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS,heel=L_calc,toe=L_toe";
  Done(folder_, trial + left + forces);
  const Json stances = ReadJsonFile(folder_ / "L/summary.json")["stances"];
  ASSERT_EQ(stances.size(), 1u);
  EXPECT_NEAR(stances[0]["heel_strike_s"].get<double>(), 0.5322, 1e-3);
  EXPECT_NEAR(stances[0]["toe_off_s"].get<double>(), 1.2075, 1e-3);
  // Push-off at one's own pace: 1.2 to 1.8 N m/kg (Winter 1991).
  EXPECT_NEAR(stances[0]["peak_ankle_nm"].get<double>() / 70, 1.5, 0.4);
  ExpectRefused(folder_, trial + left, 1, "give --forces");
  // The right foot is on the first plate from before the recording on.
  ExpectRefused(folder_, trial + "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS" + forces, 1,
                "no plate bears this foot from heel strike to toe-off");
}

TEST_F(WalkingProgram, TakesANormAndQuietStanding) {
  std::ofstream(folder_ / "norm.csv") << "percent,mean,sd\n0,5,4\n40,10,5\n72,60,6\n100,5,4\n";
  Write({});
  EXPECT_FALSE(DoneJson(folder_, kGait + "--reference norm.csv").contains("neutral"));
  EXPECT_THAT(ReadTextFile(folder_ / "W/gait_cycles.svg"), HasSubstr("reference"));
  EXPECT_THAT(Done(folder_, "lake-gait walk.csv -o W").out, HasSubstr("--neutral"));
  ExpectRefused(folder_, kGait + "--neutral 0.5,2.5", 1, "no quiet standing from 0.5 to 2.5 s");
  ExpectRefused(folder_, kGait + "--neutral 2,1", 2, "--neutral");
  // The same walk's markers, standing.
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.3;
  motion::MarkerRecording standing = DrawWalk(drawn);
  const motion::MarkerRecording walk = DrawWalk({});
  constexpr std::size_t kMidStance = 170;  // frame
  for (motion::MarkerTrack& marker : standing.markers)
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      marker.samples[i].position +=
          walk.Find(marker.name)->samples[kMidStance].position - walk.Find(marker.name)->samples[i].position;
  // The drawn knee is bent by 30° there.
  const auto place = [&](const char* name, std::size_t i) { return standing.Find(name)->samples[i].position; };
  auto knee = std::ranges::find(standing.markers, std::string("knee"), &motion::MarkerTrack::name);
  for (std::size_t i = 0; i < knee->samples.size(); ++i)
    knee->samples[i].position = (place("ankle", i) + place("hip", i)) / 2 + Eigen::Vector2d(20, 0);
  motion::WriteMarkerCsv(folder_ / "standing.csv", standing);
  const double neutral_deg = DoneJson(folder_, kGait + "--neutral standing.csv")["neutral"]["knee"]["deg"];
  const CsvTable kinematics = CsvTable::Read(folder_ / "W/kinematics.csv");
  for (const char* name : {"knee", "shank", "thigh", "trunk", "foot", "ankle"})
    EXPECT_TRUE(kinematics.Has(std::string(name) + "_neutral_deg")) << name;
  EXPECT_NEAR(kinematics.RequiredNumber(50, kinematics.Column("knee_neutral_deg")),
              kinematics.RequiredNumber(50, kinematics.Column("knee_deg")) - neutral_deg, 1e-9);
  EXPECT_THAT(ReadTextFile(folder_ / "W/uncertainty_budget.csv"),
              HasSubstr("knee_neutral_angle_deg,pose of quiet standing"));
}

// A walk, and a slower one back with the exoskeleton's joint 12 mm from the knee.
class WalkingComparisonProgram : public testing::Test {
 protected:
  WalkingComparisonProgram() {
    DrawnWalkOptions drawn;
    drawn.noise_mm = 0.5;
    motion::WriteMarkerCsv(folder_ / "walk.csv", DrawWalk(drawn));
    drawn.stride_s = 1.5;
    drawn.stride_mm = 1100;
    drawn.length_s = 8;
    drawn.direction = -1;
    motion::MarkerRecording worn = DrawWalk(drawn);
    AddWornJoint({9, -7.93725}, -1, worn);
    motion::WriteMarkerCsv(folder_ / "worn.csv", worn);
  }
  TemporaryFolder folder_;
};

TEST_F(WalkingComparisonProgram, ComparesWalks) {
  const Outcome outcome = Done(folder_, "lake-compare walk.csv worn.csv -o C");
  EXPECT_THAT(outcome.out, HasSubstr("path difference at equal percent of the stride, relative to the hip,"));
  const Json comparison = ReadJsonFile(folder_ / "C/comparison.json");
  EXPECT_EQ(comparison["movement"], "walking");
  EXPECT_NEAR(comparison["joint"]["rms_mm"].get<double>(), 12, 0.5);
  EXPECT_NEAR(comparison["duration_s"]["exo"].get<double>(), 1.5, 0.02);
  const std::string report = ReadTextFile(folder_ / "C/report.html");
  EXPECT_THAT(report, HasSubstr("relative to the hip, x in the direction of walking"));
  for (const std::string& text : {outcome.out, comparison.dump(), report, ReadTextFile(folder_ / "C/misalignment.svg")})
    for (const char* of_rises :
         {"the rise", "rise (%)", "from rise", "seat-off", "what seat", "to standing", "stroke program"})
      EXPECT_THAT(text, Not(HasSubstr(of_rises)));
  EXPECT_FALSE(fs::exists(folder_ / "C/cuffs.csv"));
  // By what lake-gait wrote, and by the first comparison's curve.
  Done(folder_, "lake-gait worn.csv -o W && lake-compare C W -o D");
  EXPECT_NEAR(ReadJsonFile(folder_ / "D/comparison.json")["joint"]["rms_mm"].get<double>(), 12, 0.5);
}

TEST_F(WalkingComparisonProgram, DesignsOnlyWhatIsQuickEnough) {
  Done(folder_, "lake-compare walk.csv worn.csv -o C");
  const std::string optimize = "lake-optimize --comparison C --human-only --starts 4 --penalty 1 -o O ";
  // The paper's actuator, 5 mm/s.
  const Outcome slow = Shell(folder_, optimize);
  EXPECT_EQ(slow.exit_code, 3) << slow.out;
  EXPECT_THAT(slow.err, HasSubstr("no program follows this walk"));
  const double needed_s = ReadJsonFile(folder_ / "O/summary.json")["ways_out"][0]["duration_s"];
  EXPECT_GT(needed_s, 20);
  EXPECT_THAT(Done(folder_, fmt::format("{}--duration {}", optimize, 1.01 * needed_s)).err,
              HasSubstr("NOT USABLE FOR WALKING"));
  EXPECT_FALSE(ReadJsonFile(folder_ / "O/summary.json")["walking"]["is_quick_enough"]);
  // As quick as this needs for the person's own stride.
  Done(folder_, fmt::format("{}--max-speed {}", optimize, 1.01 * 5 * needed_s / 1.1));
  const Json summary = ReadJsonFile(folder_ / "O/summary.json");
  EXPECT_TRUE(summary["walking"]["is_quick_enough"]);
  EXPECT_LE(summary["stroke_program"]["duration_s"].get<double>(), 1.11);
  EXPECT_NEAR(summary["stroke_program"]["stroke_from_to_mm"][0], summary["stroke_program"]["stroke_from_to_mm"][1],
              1e-3);
  EXPECT_LE(summary["after"]["angle_mismatch_max_deg"].get<double>(), 5.001);
  ExpectRefused(folder_, optimize + "--pareto 3", 2, "--pareto is of sit-to-stands");
}

TEST_F(WalkingComparisonProgram, RefusesAnotherMovement) {
  Done(folder_, "lake-compare walk.csv worn.csv -o C");
  Json of_rises = ReadJsonFile(folder_ / "C/comparison.json");
  of_rises["movement"] = "sit-to-stand";
  WriteJsonFile(folder_ / "C/comparison.json", of_rises);
  ExpectRefused(folder_, "lake-compare C worn.csv -o D", 1, "C is of sit-to-stand and worn.csv of walking");
}

}  // namespace
}  // namespace lake
