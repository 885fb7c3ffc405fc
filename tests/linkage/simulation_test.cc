// lake-simulate as a user runs it: files, columns, exit codes, messages.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdio>
#include <regex>
#include <set>

#include "lake/core/angles.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/linkage/linkage.h"
#include "lake/video/video_reader.h"
#include "places.h"
#include "published_links.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
constexpr const char* kLinksOption = "--links 59.081,68.840,55.964,71.849,118.630,287.310";

// Of labels and pins in a drawing; how gnuplot writes the rest depends on its release.
std::set<std::string> PlacesIn(const std::filesystem::path& svg) {
  const std::string text = ReadTextFile(svg);
  const std::regex place("translate\\([^)]*\\)");
  std::set<std::string> places;
  for (std::sregex_iterator at(text.begin(), text.end(), place), end; at != end; ++at) places.insert(at->str());
  return places;
}

struct Outcome {
  int exit_code;
  std::string out, err;
};

class Simulate : public ::testing::Test {
 protected:
  Outcome RunIt(const std::string& arguments) {
    const auto out = folder_ / "stdout", err = folder_ / "stderr";
    const std::string command = fmt::format("{} {} -o {} >{} 2>{}", Quoted(BinDir() / "lake-simulate"), arguments,
                                            Quoted(Out()), Quoted(out), Quoted(err));
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadTextFile(out), ReadTextFile(err)};
  }
  std::filesystem::path Out() const { return folder_ / "out"; }

  // loads.json: a constant moment over a rise of 2 s from 90° to 30°, a sample per so many percent.
  void WriteProfile(double knee_nm, int step_percent) const {
    Json profile;
    for (int percent = 0; percent <= 100; percent += step_percent) {
      profile["percent"].push_back(percent);
      profile["time_s"].push_back(0.02 * percent);
      profile["knee_deg"].push_back(90 - 0.6 * percent);
      profile["knee_nm"].push_back(knee_nm);
    }
    WriteJsonFile(folder_ / "loads.json", profile);
  }

  // One line on stderr, this exit code, and nothing left behind.
  void ExpectRefusal(const std::string& arguments, int exit_code, const std::string& message) {
    const Outcome outcome = RunIt(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(StartsWith("lake-simulate: "), HasSubstr(message))) << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(Out() / "summary.json"));
  }

  TemporaryFolder folder_;
};

TEST_F(Simulate, WritesTheTableOnTheAssembledBranch) {
  const Outcome outcome = RunIt(
      fmt::format("{} --stroke 242 377 --angles 2,70,110,148 --rows 51 --knee-torque 40 --no-animation", kLinksOption));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const CsvTable table = CsvTable::Read(Out() / "angle_vs_stroke.csv");
  EXPECT_THAT(table.Header(), ::testing::ElementsAre("stroke_mm", "knee_deg", "deg_per_mm", "moment_arm_mm", "force_n",
                                                     "transmission_deg", "actuator_angle_deg", "branch"));
  ASSERT_EQ(table.Rows(), 51 + 1 + 4u);  // 242 is the grid's first row
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const double stroke = table.RequiredNumber(row, 0);
    const linkage::Pose pose = linkage::RequirePose(kPublishedLinks, stroke);
    const linkage::Transmission transmission = linkage::TransmissionOf(kPublishedLinks, pose);
    EXPECT_EQ(table.RequiredNumber(row, 1), DegreesFromRadians(pose.theta_rad));
    EXPECT_EQ(table.RequiredNumber(row, 4), linkage::ActuatorForce(transmission, 40));
    EXPECT_NEAR(table.RequiredNumber(row, 4) * table.RequiredNumber(row, 3), 40000, 1e-6);
    EXPECT_EQ(table.RequiredNumber(row, 7), 0);
    if (row > 0) {
      EXPECT_GT(stroke, table.RequiredNumber(row - 1, 0));
    }
  }
  EXPECT_NEAR(table.RequiredNumber(table.Rows() - 1, 1), -44.84, 5e-3);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("148.5715"), HasSubstr("374.5205"), HasSubstr("crank-rocker")));
  const Json summary = ReadJsonFile(Out() / "summary.json");
  EXPECT_NEAR(summary["range_deg"].get<double>(), 148.5715, 5e-5);
  EXPECT_NEAR(summary["mannequin"]["mount_below_hip_mm"].get<double>(), 85.726, 1e-9);
  EXPECT_EQ(summary["poses"].size(), 6u);
  EXPECT_THAT(summary["warnings"].dump(), AllOf(HasSubstr("0.00224 mm from the actuator's dead point"),
                                                HasSubstr("exceeds what it bears at 148.6°"),
                                                HasSubstr("from a dead point there"), Not(HasSubstr("thicker"))));
  EXPECT_LT(summary["weakest"]["safety"], 1);
}

// What is only looked at is no part of the used range: the optimum of calibration/problems/buildable.yaml, whose
// linkage can be assembled far beyond standing, where the coupler would bear twice as much.
TEST_F(Simulate, PosesBeyondTheUsedRangeDoNotCountForStrength) {
  const auto run = [&](const std::string& more) {
    const Outcome outcome =
        RunIt("--links 52,73.3467868,50,73.3467868,90.4776700,300 --no-animation --json --quiet" + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(outcome.out);
  };
  const Json plain = run(""), beyond = run(" --stroke 386");
  EXPECT_NEAR(plain["weakest"]["safety"].get<double>(), 2.2154, 1e-3);
  const CsvTable rows = CsvTable::Read(Out() / "pin_forces.csv");
  EXPECT_LT(rows.RequiredNumber(rows.Rows() - 1, 1), -10) << "the stroke stands in the table";
  const Json bent_back = run(" --angles=-10,70");
  EXPECT_TRUE(std::filesystem::exists(Out() / "pose_-10.png"));
  for (const char* key : {"weakest", "pin_forces", "used_stroke_mm", "mannequin"}) {
    EXPECT_EQ(beyond[key], plain[key]) << key;
    EXPECT_EQ(bent_back[key], plain[key]) << key;
  }
}

// Each row against virtual work; the largest pin force is in the summary.
TEST_F(Simulate, WritesTheForcesInMembersAndPins) {
  WriteTextFile(folder_ / "torques.csv", "knee_deg,knee_torque_nm\n90,50\n10,20\n");
  const Outcome outcome = RunIt(fmt::format("{} --angles 50 --rows 41 --no-animation --torques '{}' --json",
                                            kLinksOption, (folder_ / "torques.csv").string()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const CsvTable table = CsvTable::Read(Out() / "pin_forces.csv");
  EXPECT_THAT(table.Header(),
              ::testing::ElementsAre("stroke_mm", "knee_deg", "actuator_n", "coupler_n", "bar_n", "knee_pin_n",
                                     "thigh_pin_n", "tip_pin_n", "shank_pin_n", "mount_n"));
  double largest_n = 0;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const double knee_deg = table.RequiredNumber(row, 1);
    ASSERT_EQ(table.Number(row, 2).has_value(), knee_deg >= 10 && knee_deg <= 90) << knee_deg;
    if (!table.Number(row, 2)) continue;
    const linkage::Pose pose = linkage::RequirePose(kPublishedLinks, table.RequiredNumber(row, 0));
    const double torque_nm = 20 + 30 * (knee_deg - 10) / 80;
    const double force_n = linkage::ActuatorForce(linkage::TransmissionOf(kPublishedLinks, pose), torque_nm);
    EXPECT_NEAR(table.RequiredNumber(row, 2), force_n, 1e-9 * force_n);
    EXPECT_EQ(table.RequiredNumber(row, 9), table.RequiredNumber(row, 2));
    largest_n = std::max(largest_n, table.RequiredNumber(row, 7));
  }
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary["pin_forces"]["tip_pin"]["largest_n"], largest_n);
  const CsvTable strength = CsvTable::Read(Out() / "strength.csv");
  double least = HUGE_VAL;
  for (std::size_t row = 0; row < strength.Rows(); ++row)
    least = std::min(least, strength.RequiredNumber(row, strength.Column("safety")));
  EXPECT_EQ(summary["weakest"]["safety"], least);
  const CsvTable parts = CsvTable::Read(Out() / "parts.csv");
  EXPECT_EQ(parts.Text(0, 0), "thigh plate KPM");
  for (std::size_t row = 0; row < parts.Rows(); ++row)
    for (std::size_t column = 0; column < parts.Header().size(); ++column) {
      const std::string cell = parts.Text(row, column);
      if (const std::size_t point = cell.find('.'); point != cell.npos && parts.Number(row, column)) {
        EXPECT_LE(cell.size() - point - 1, 3u) << cell << ": a workshop's decimals";
      }
    }
  for (const char* name : {"pin_forces.png", "pin_forces.svg"}) EXPECT_TRUE(std::filesystem::exists(Out() / name));
}

TEST_F(Simulate, RefusesATableOfTorquesThatIsNone) {
  const auto torques = folder_ / "torques.csv";
  const auto expect = [&](const char* text, const char* message) {
    WriteTextFile(torques, text);
    ExpectRefusal(fmt::format("{} --torques '{}'", kLinksOption, torques.string()), 1, message);
  };
  expect("time_s,knee_torque_nm\n0,1\n1,2\n", "needs a column stroke_mm or knee_deg");
  expect("knee_deg,knee_torque_nm\n0,1\n0,2\n", "torques.csv:3: a second torque for knee_deg 0");
  expect("stroke_mm,knee_torque_nm\n250,1\n", "needs two rows or more");
}

TEST_F(Simulate, DrawsEverything) {
  ASSERT_EQ(RunIt(fmt::format("{} --angles 2,70,12.5 --quiet", kLinksOption)).exit_code, 0);
  for (const char* name : {"angle_vs_stroke.png", "pose_2.png", "pose_70.png", "pose_12.5.png", "mannequin.png"})
    EXPECT_THAT(ReadTextFile(Out() / name), StartsWith("\x89PNG")) << name;
  EXPECT_THAT(ReadTextFile(Out() / "pose_70.svg"),
              AllOf(HasSubstr("<svg"), HasSubstr("59.08"), HasSubstr("287.31"), HasSubstr("313.36")));
  // READMEs show what the programs draw today.
  EXPECT_EQ(PlacesIn(Out() / "schematic.svg"), PlacesIn(SourceDir() / "libs/design/linkage/linkage.svg"))
      << "lake simulate of the published links, schematic.svg";
  for (const char* name : {"pose_70.svg", "schematic.svg", "mannequin.svg", "angle_vs_stroke.svg"})
    EXPECT_THAT(ReadTextFile(Out() / name),
                AllOf(Not(HasSubstr("Gnuplot<")), Not(HasSubstr("gnuplot_")), HasSubstr("prefers-color-scheme: dark")));
  // The wearer looks to the right in the schematic too, and stands on the ground.
  EXPECT_THAT(ReadTextFile(Out() / "schematic.svg"), HasSubstr("to the left"));
  EXPECT_THAT(ReadTextFile(Out() / "mannequin.svg"), ::testing::ContainsRegex("136, 136, 136"));
  EXPECT_THAT(ReadTextFile(Out() / "angle_vs_stroke.svg"), HasSubstr("<svg"));
  EXPECT_THAT(ReadTextFile(Out() / "design.dxf"), HasSubstr("OUTLINE"));
  EXPECT_THAT(ReadTextFile(Out() / "animation.gif"), StartsWith("GIF89a"));
  const auto video = video::VideoReader::Open(Out() / "animation.mp4");
  EXPECT_EQ(video->Info().width, 1280);
  int frames = 0;
  double time_s = -1;
  for (video::VideoFrame frame; video->Read(frame); ++frames) {
    EXPECT_GT(frame.time_s, time_s);
    time_s = frame.time_s;
  }
  EXPECT_EQ(frames, 78);  // 40 poses out, 38 back
  int others = 0;         // scratch files must be gone
  for (const auto& entry : std::filesystem::directory_iterator(Out()))
    others += entry.path().extension() == ".gnuplot" || entry.path().extension() == ".frames" || entry.is_directory();
  EXPECT_EQ(others, 0);
}

TEST_F(Simulate, TakesADesignFileAndDefaultAngles) {
  const auto design = folder_ / "design.yaml";
  WriteTextFile(
      design,
      "links: {l1: 60, l2: 70, l3: 55, l4: 72, l5: 70, l6: 240}\nd_min_mm: 205\nd_max_mm: 300\nrange_deg: 100\n");
  const Outcome outcome = RunIt(fmt::format("'{}' --no-animation --json", design.string()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary["used_range_ends_at"], "d_max");
  EXPECT_EQ(summary["inputs"].size(), 1u);
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("range_deg = 100, but its links give 114.98"));
  EXPECT_TRUE(std::filesystem::exists(Out() / "pose_114.png"));
  EXPECT_FALSE(std::filesystem::exists(Out() / "pose_2.png"));  // d_max ends at 28 degrees
}

// Parts, body and load stand in the file; an option says otherwise for one run. A file that was carried away without
// its load is simulated nevertheless.
TEST_F(Simulate, TakesPartsBodyAndLoadOfTheDesign) {
  WriteProfile(50, 10);
  const auto design = folder_ / "design.yaml";
  const std::string links = "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\n";
  WriteTextFile(design, links +
                            "d_min_mm: 242\nparts: {\"plate\": \"6mm,S235\", bar_width_mm: 28}\n"
                            "body: {height_mm: 1700, seat_edge_mm: 190}\n"
                            "load: {profile: loads.json, assist: 0.4, knee_torque_nm: 25}\n");
  const std::string run = fmt::format("'{}' --angles 70 --rows 11 --no-animation --json", design.string());
  const auto summary_of = [&](const std::string& more) {
    const Outcome outcome = RunIt(run + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(outcome.out);
  };
  const Json taken = summary_of("");
  const Json given = [&] {
    const Outcome outcome = RunIt(fmt::format(
        "{} --angles 70 --rows 11 --no-animation --json --plate 6mm,S235 --bar-width 28 --height 1700 --seat-edge 190 "
        "--profile '{}' --assist 0.4 --knee-torque 25",
        kLinksOption, (folder_ / "loads.json").string()));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(outcome.out);
  }();
  for (const char* key : {"knee_torque_nm", "parts", "weakest", "mannequin", "assistance", "poses"})
    EXPECT_EQ(taken[key], given[key]) << key;
  EXPECT_EQ(taken["options"]["plate"], "6mm,S235");
  EXPECT_EQ(summary_of(" --plate 4mm,PLA")["options"]["plate"], "4mm,PLA");
  EXPECT_EQ(summary_of(" --knee-torque 30")["knee_torque_nm"], 30);

  std::filesystem::remove(folder_ / "loads.json");
  const Json without = summary_of("");
  EXPECT_THAT(without["warnings"].dump(), AllOf(HasSubstr("loads.json, which is not there"), HasSubstr("--profile")));
  EXPECT_FALSE(without.contains("assistance"));
  EXPECT_EQ(without["parts"], given["parts"]);

  std::filesystem::remove_all(Out());
  WriteTextFile(design, links + "d_min_mm: 242\nparts: {plat: 6mm}\n");
  ExpectRefusal(fmt::format("'{}'", design.string()), 1, "design.yaml: unknown key 'plat'");
  WriteTextFile(design, links + "d_min_mm: 242\nparts: {bar_width_mm: broad}\n");
  ExpectRefusal(fmt::format("'{}'", design.string()), 1, "design.yaml: 'bar_width_mm'");
}

// A design's own d_max is the end of its range to the last digit or but one; 377 mm is past standing.
TEST_F(Simulate, WarnsOfAStrokePastTheUsedRangeButNotOfRounding) {
  const double end_mm = linkage::FindUsedRange(kPublishedLinks, 242, {}).stroke.upper_mm;
  for (const double past_mm : {0.0, 1e-12, -1e-12, 377 - end_mm}) {
    const Outcome outcome =
        RunIt(fmt::format("{} --d-max {} --angles 70 --no-animation --json", kLinksOption, end_mm + past_mm));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string warnings = Json::parse(outcome.out)["warnings"].dump();
    EXPECT_EQ(warnings.find("past the used range") != std::string::npos, past_mm > 1) << past_mm << ": " << warnings;
  }
}

// The paper's mannequin carries the published design beside the leg; behind it, it collides with seat, thigh and shank.
TEST_F(Simulate, WarnsOfWhatCollidesOnTheBodyAndSaysWhatToDo) {
  const Outcome beside = RunIt(fmt::format("{} --angles 70 --no-animation --json", kLinksOption));
  ASSERT_EQ(beside.exit_code, 0) << beside.err;
  const Json usual = Json::parse(beside.out);
  EXPECT_EQ(usual["mannequin"]["mount"], "beside");
  EXPECT_TRUE(usual["mannequin"]["clears_seat"].is_null());
  EXPECT_TRUE(usual["mannequin"]["clears_limb"].is_null());
  EXPECT_THAT(usual["warnings"].dump(), AllOf(Not(HasSubstr("seat")), Not(HasSubstr("overlaps"))));

  const Outcome average = RunIt(fmt::format("{} --mount behind --angles 70 --no-animation --json", kLinksOption));
  ASSERT_EQ(average.exit_code, 0) << average.err;
  const Json summary = Json::parse(average.out);
  const std::string warnings = summary["warnings"].dump();
  EXPECT_FALSE(summary["mannequin"]["clears_seat"].get<bool>());
  EXPECT_FALSE(summary["mannequin"]["clears_limb"].get<bool>());
  EXPECT_THAT(warnings, AllOf(HasSubstr("mm into the seat: use a seat that begins at least"),
                              HasSubstr("the actuator overlaps the thigh by"), HasSubstr("mount it beside the leg")));
  EXPECT_THAT(warnings, Not(HasSubstr("does not fit on the thigh")));

  const Outcome own = RunIt(fmt::format("{} --angles 70 --thigh 330 --shank 390 --no-animation --json", kLinksOption));
  ASSERT_EQ(own.exit_code, 0) << own.err;
  const Json body = Json::parse(own.out)["mannequin"];
  EXPECT_EQ(body["thigh_mm"], 330);
  EXPECT_EQ(body["shank_mm"], 390);
  EXPECT_NEAR(body["height_mm"].get<double>(), 720 / 0.491, 1e-9);
  EXPECT_NEAR(body["mass_kg"].get<double>() / std::pow(body["height_mm"].get<double>() / 1000, 2), 80 / 1.8 / 1.8,
              1e-9);
  EXPECT_THAT(Json::parse(own.out)["warnings"].dump(), HasSubstr("does not fit on the thigh"));
}

// With a load profile its share is what counts, without one the constant torque.
TEST_F(Simulate, HoldsTheDesignAgainstAnActuator) {
  WriteTextFile(folder_ / "own.csv",
                "name,closed_mm,stroke_mm,max_force_n,no_load_speed_mm_s,holding_force_n\n"
                "short,250,100,300,20,100\nweak,240,140,20,20,\n");
  WriteProfile(12, 1);
  const auto with = [&](const char* actuator, const std::string& more) {
    const Outcome outcome = RunIt(fmt::format("{} --angles 70 --rows 41 --no-animation --actuator '{}:{}' {}",
                                              kLinksOption, (folder_ / "own.csv").string(), actuator, more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out + outcome.err;
  };
  const std::string loaded = fmt::format("--profile '{}'", (folder_ / "loads.json").string());
  EXPECT_THAT(with("short", ""), AllOf(HasSubstr("short is 250 mm long when closed"), HasSubstr("short reaches 350 mm"),
                                       HasSubstr("short lifts 300 N, and the torque at the knee takes")));
  // 12 N m at a moment arm below 0.1 m are more than 100 N; 60° over 1.0 s at more than 40 mm/rad more than 20 mm/s.
  const std::string share = with("short", loaded + " --duration 1");
  EXPECT_THAT(share, AllOf(HasSubstr("short is 250 mm long when closed"), HasSubstr("short holds 100 N at rest"),
                           HasSubstr("a rise in 1 s is asked for, and short takes")));
  EXPECT_THAT(share, Not(HasSubstr("torque at the knee takes"))) << "the share counts";
  EXPECT_THAT(with("weak", loaded), HasSubstr("and it lifts 20 N"));
  std::filesystem::remove_all(Out());
  ExpectRefusal(fmt::format("{} --rest standing", kLinksOption), 2, "give --actuator, --profile");
}

// One cuff without length on each segment: 40 N m over 0.25 m shear the knee by 160 N wherever it bends; limits warn,
// and name the pose. At a straight knee, where the used range ends, such cuffs do not bear it.
TEST_F(Simulate, TellsWhatTheLegBears) {
  const std::string run = fmt::format("{} --angles 70 --rows 41 --no-animation", kLinksOption);
  const std::string narrow = run + " --thigh-cuff 250:0 --shank-cuff 250:0 --thigh-link-mass 0 --shank-link-mass 0";
  const Outcome outcome = RunIt(narrow + " --max-leg-shear 159 --max-cuff-force 100");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("on the leg, shank upright: thigh cuff "), HasSubstr("shear at the knee 160 N at ")));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("shear at the knee: 160 N at "), HasSubstr("above --max-leg-shear 159"),
                                 HasSubstr("thigh cuff: "), HasSubstr("above --max-cuff-force 100"),
                                 HasSubstr("the cuffs cannot bear the moment at 0.0°")));
  const CsvTable table = CsvTable::Read(Out() / "leg_loads.csv");
  EXPECT_THAT(table.Header(), ::testing::ElementsAre("stroke_mm", "knee_deg", "moment_nm", "thigh_cuff_n",
                                                     "shank_cuff_n", "knee_shear_n", "knee_compression_n"));
  ASSERT_EQ(table.Rows(), 42u);
  for (std::size_t row = 0; row + 1 < table.Rows(); ++row) {
    const double half_rad = RadiansFromDegrees(table.RequiredNumber(row, 1)) / 2;
    EXPECT_EQ(table.RequiredNumber(row, 2), 40);
    EXPECT_NEAR(table.RequiredNumber(row, 5), 160, 1e-6);
    EXPECT_NEAR(table.RequiredNumber(row, 3) * std::sin(half_rad), 160, 1e-6);
    EXPECT_NEAR(table.RequiredNumber(row, 6) * std::tan(half_rad), -160, 1e-6);
  }
  EXPECT_FALSE(table.Number(table.Rows() - 1, 5)) << "straight";

  // Two cuffs bear it there; the links are as heavy as their parts.
  const Outcome two = RunIt(run + " --thigh-cuff 100:80 250:80 --shank-cuff 100:80 250:80 --json");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  const CsvTable couple = CsvTable::Read(Out() / "leg_loads.csv");
  EXPECT_NEAR(couple.RequiredNumber(couple.Rows() - 1, 5), 0, 1e-6);
  const Json summary = Json::parse(two.out);
  const Json& loads = summary["leg_loads"];
  EXPECT_NEAR(loads["thigh_link_kg"].get<double>() + loads["shank_link_kg"].get<double>(),
              0.8 + summary["parts"]["mass_g"].get<double>() / 1000, 1e-9);
}

// Of a load profile it is the device's share.
TEST_F(Simulate, TheLegBearsTheShareOfAProfile) {
  WriteProfile(50, 10);
  const Outcome outcome =
      RunIt(fmt::format("{} --angles 70 --rows 41 --no-animation --profile '{}' --assist 0.4 --thigh-cuff 250:0 "
                        "--shank-cuff 250:0 --thigh-link-mass 0 --shank-link-mass 0",
                        kLinksOption, (folder_ / "loads.json").string()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const CsvTable table = CsvTable::Read(Out() / "leg_loads.csv");
  ASSERT_EQ(table.Rows(), 11u);
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    EXPECT_NEAR(table.RequiredNumber(row, 2), 20, 1e-9);
    EXPECT_NEAR(table.RequiredNumber(row, 5), 80, 1e-6);
  }
}

TEST_F(Simulate, LimitsOnTheLegNeedTheCuffs) {
  ExpectRefusal(fmt::format("{} --thigh-cuff 200:80", kLinksOption), 2, "--thigh-cuff and --shank-cuff");
  ExpectRefusal(fmt::format("{} --max-leg-shear 100", kLinksOption), 2, "give --thigh-cuff and --shank-cuff");
}

TEST_F(Simulate, RefusesHalfALeg) {
  ExpectRefusal(fmt::format("{} --thigh 400", kLinksOption), 2, "--thigh and --shank");
}

TEST_F(Simulate, RefusesWhatCannotBeAssembled) {
  ExpectRefusal("--links 1,1,1,1,1,1 --stroke 242", 1, "cannot be assembled at a stroke of 242 mm");
  ExpectRefusal(fmt::format("{} --stroke 241.9", kLinksOption), 1, "by 0.0978 mm");
  ExpectRefusal(fmt::format("{} --stroke 300,390", kLinksOption), 1, "cannot be assembled at a stroke of 390 mm");
  ExpectRefusal(fmt::format("{} --angles 70,149", kLinksOption), 1,
                "149° is outside the range of this design, 0.0°..148.6°");
  ExpectRefusal(fmt::format("{} --d-min 240", kLinksOption), 1, "at a stroke of 240 mm");
  ExpectRefusal(fmt::format("{} --d-max 200", kLinksOption), 1, "d_max = 200 mm must exceed d_min = 242 mm");
  ExpectRefusal("--links 59,68,55,71,118,-287", 1, "--links: link l6 is -287 mm");
  ExpectRefusal("--links 59,68,55,0,118,287", 1, "--links: link l4 is 0 mm");
}

TEST_F(Simulate, RefusesWrongUsage) {
  ExpectRefusal("", 2, "give either a design file or --links");
  ExpectRefusal("--links 59,68,55,71,118", 2, "--links");
  ExpectRefusal("--links 59,68,55,71,118,nan", 2, "--links");
  ExpectRefusal(fmt::format("{} --stroke nan", kLinksOption), 2, "--stroke must be a finite number, not 'nan'");
  ExpectRefusal(fmt::format("{} --rows 1", kLinksOption), 2, "--rows must be at least 2, not 1");
  ExpectRefusal(fmt::format("{} --angles 400", kLinksOption), 2, "--angles must be at most 360, not 400");
  ExpectRefusal(fmt::format("{} --knee-torque 0", kLinksOption), 2, "--knee-torque must not be 0");
  ExpectRefusal(fmt::format("{} --height 180", kLinksOption), 1, "a body of 180 mm");
  ExpectRefusal(fmt::format("{} --pin-diameter 30", kLinksOption), 1, "a pin of 30 mm does not fit");
  ExpectRefusal("--no-such-option", 2, "--no-such-option");
}

TEST_F(Simulate, RefusesABrokenDesignFile) {
  ExpectRefusal("/no/such/design.yaml", 1, "/no/such/design.yaml");
  ExpectRefusal("--angles -20 70 /no/such/design.yaml --no-animation", 1, "/no/such/design.yaml");
  const auto design = folder_ / "design.yaml";
  WriteTextFile(design, "links: {l1: 60, l2: 70, l3: 55, l4: 72, l5: 70, l6: 240}\nd_min_mm: 205\ncolour: red\n");
  ExpectRefusal(fmt::format("'{}'", design.string()), 1, "design.yaml:3: unknown key 'colour'");
}

}  // namespace
}  // namespace lake
