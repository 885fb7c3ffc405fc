// study.yaml: what is read, and what is refused with its line.
#include "lake/study/study_file.h"

#include <gmock/gmock.h>

#include <map>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/removed.h"
#include "lake/study/study.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class StudyYaml : public testing::Test {
 protected:
  StudyYaml() {
    for (const char* name : {"human.mp4", "exo.mp4", "camera.yaml", "corrections.csv", "events.csv", "trial.trc",
                             "board.png", "worn.yaml", "duty.csv"})
      WriteTextFile(folder_ / name, "");
    fs::create_directory(folder_ / "frames");
    fs::create_directory(folder_ / "boards");
    WriteTextFile(folder_ / "boards/b2.png", "");
    WriteTextFile(folder_ / "boards/b1.png", "");
  }

  study::StudyFile Read(const std::string& text) {
    WriteTextFile(folder_ / "study.yaml", text);
    return study::ReadStudyFile(folder_ / "study.yaml");
  }

  std::vector<steps::StudyStep> Steps(const std::string& text) {
    return study::StudySteps(Read(text), folder_ / "out", Json::object());
  }

  // What each step depends on, by its name.
  std::map<std::string, Json> StepOptions(const std::string& text) {
    std::map<std::string, Json> options;
    for (const steps::StudyStep& step : Steps(text)) options[step.name] = step.options;
    return options;
  }

  void ExpectRefused(const std::string& text, const std::string& message) {
    EXPECT_THAT([&] { Read(text); }, ThrowsMessage<Error>(AllOf(HasSubstr(message), Not(HasSubstr("\n"))))) << text;
  }

  TemporaryFolder folder_;
};

TEST_F(StudyYaml, TheTemplateIsAStudy) {
  const study::StudyFile study = Read(study::StudyTemplate());
  EXPECT_EQ(study.human.Recording().filename(), "human.mp4");
  ASSERT_TRUE(study.exo);
  EXPECT_FALSE(study.redesign || study.loads || study.stroke);
}

// Each key by itself, in its section and with what that needs.
TEST_F(StudyYaml, EveryKeyOfTheTemplateIsKnown) {
  std::istringstream lines(study::StudyTemplate());
  std::vector<std::string> parents;  // by their indentation
  std::string trial = "video: human.mp4";
  int keys = 0;
  for (std::string line; std::getline(lines, line);) {
    if (const std::size_t hash = line.find('#'); hash == line.find_first_not_of(' ') && hash != line.npos)
      line.erase(hash, 1);
    const std::size_t indent = line.find_first_not_of(' '), colon = line.find(':');
    const bool is_key =
        indent != line.npos && colon != line.npos && indent % 2 == 0 &&
        line.substr(indent, colon - indent).find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") == line.npos;
    if (!is_key) continue;
    parents.resize(indent / 2);
    if (colon + 1 == line.size()) {
      parents.push_back(line);
      continue;
    }
    if (line.starts_with("  trial:")) trial = "trial: trial.trc";
    std::string text;
    for (const std::string& parent : parents) text += parent + "\n";
    const std::string section = parents.empty() ? "" : parents.front();
    const bool is_of_trial = section == "human:" || section == "exo:";
    if (is_of_trial && !line.starts_with("  video:") && !line.starts_with("  trial:")) text += "  " + trial + "\n";
    text += line + "\n";
    if (section != "human:") text += "human: {video: human.mp4}\n";
    if (section != "exo:") text += "exo: {video: exo.mp4}\n";
    if (section == "assistance:") text += "loads: {mass_kg: 70}\n";
    ++keys;
    EXPECT_THAT(MessageOf([&] { Read(text); }), Not(HasSubstr("unknown key"))) << text;
  }
  EXPECT_GT(keys, 150);
}

constexpr const char* kWhole = R"(name: A study
out: results
camera: camera.yaml
human:
  video: human.mp4
  markers: [ankle, knee, hip]
  seeds: ["knee=10,20.5@7"]
  detector: color
  colors: ["#ff0000"]
  scale: [1, 2, 3, 4, 500]
  crop: [0, 10, 640, 480]
  start_s: 0.5
  end_s: 9.25
  capture_rate_hz: 240
  vertical: [0, 0, 0, 100]
  depth_mm: {knee: 12}
  filter: butterworth
  cutoff_hz: 6
  corrections: corrections.csv
  events: events.csv
  overlay: false
exo:
  trial: trial.trc
  map: {ankle: R_A, knee: R_K, hip: R_H, exo_knee: E_K}
  up: y
  forward: -x
  unit: m
  facing: left
  events: events.csv
compare: {human_knee: knee, exo_knee: exo_knee, replacement_sd_mm: 1.5}
design:
  problem: {margins: {grashof_mm: 2}}
  worn: worn.yaml
  certify_deg: 0.5
  yield_mm: 0.1
reoptimize:
  problem: {margins: {grashof_mm: 3}}
  max_misalignment_percent: 4
  penalty: 0.5
  program: free
  max_speed_mm_s: 6
  duration_s: 30
  monotone: true
  knots: 31
  fit_placement: true
  placement_reach_mm: 25
  pareto: 5
simulate: {height_mm: 1650, mass_kg: 60, seat_edge_mm: 150}
stroke: {duty_table: duty.csv, margin_mm: 1, return: true, hold_s: 3, rate_hz: 20, accept_drift: true,
         speed_tolerance_percent: 3, home_stroke_mm: 244, extend_stop_mm: 0.7}
)";

TEST_F(StudyYaml, IsRead) {
  const study::StudyFile study = Read(kWhole);
  EXPECT_EQ(study.name, "A study");
  EXPECT_EQ(study.out, folder_ / "results");
  EXPECT_EQ(study.camera, folder_ / "camera.yaml");
  ASSERT_TRUE(study.human.IsVideo());
  const auto& video = std::get<commands::TrackRunOptions>(study.human.work);
  EXPECT_EQ(video.video, folder_ / "human.mp4");
  EXPECT_THAT(video.track.names, ElementsAre("ankle", "knee", "hip"));
  ASSERT_EQ(video.track.seeds.size(), 1u);
  EXPECT_EQ(video.track.seeds[0].frame, 7);
  EXPECT_EQ(video.track.seeds[0].position, Eigen::Vector2d(10, 20.5));
  EXPECT_EQ(video.track.detector, "color");
  EXPECT_EQ(video.scale, (std::array<double, 5>{1, 2, 3, 4, 500}));
  EXPECT_EQ(video.track.crop, cv::Rect(0, 10, 640, 480));
  EXPECT_EQ(video.track.reader.start_s, 0.5);
  EXPECT_EQ(video.track.reader.end_s, 9.25);
  EXPECT_EQ(video.track.reader.capture_rate_hz, 240);
  EXPECT_EQ(video.depths.at("knee").mm, 12);
  EXPECT_EQ(video.fit.filter, gait::LegFilter::kButterworth);
  EXPECT_EQ(video.fit.cutoff_hz, 6);
  EXPECT_EQ(video.corrections, folder_ / "corrections.csv");
  EXPECT_EQ(video.events, folder_ / "events.csv");
  EXPECT_FALSE(video.overlay);
  const auto& trial = std::get<commands::GaitRunOptions>(study.exo->work);
  EXPECT_EQ(trial.trial, folder_ / "trial.trc");
  EXPECT_EQ(trial.events, folder_ / "events.csv");
  EXPECT_EQ(trial.reading.names.at("exo_knee"), "E_K");
  EXPECT_EQ(trial.reading.up, 'y');
  EXPECT_EQ(trial.reading.forward, "-x");
  EXPECT_EQ(trial.reading.mm_per_unit, 1000);
  EXPECT_EQ(trial.fit.facing, motion::Facing::kLeft);
  EXPECT_EQ(study.compare.exo_knee, "exo_knee");
  EXPECT_EQ(study.compare.misalignment.replacement_sd_mm, 1.5);
  EXPECT_EQ(study.design.problem.grashof_margin_mm, 2);
  EXPECT_EQ(study.worn, folder_ / "worn.yaml");
  EXPECT_EQ(study.optimum.certify_gap_deg, 0.5);
  EXPECT_EQ(study.optimum.yield_tolerance_mm, 0.1);
  ASSERT_TRUE(study.redesign);
  EXPECT_EQ(study.redesign->design.problem.grashof_margin_mm, 3);
  const commands::ReoptimizeRunOptions& redesign = study.redesign->options;
  EXPECT_EQ(redesign.max_misalignment_percent, 4);
  EXPECT_EQ(redesign.penalty_deg_per_mm, 0.5);
  EXPECT_EQ(redesign.program.kind, linkage::StrokeProgram::Kind::kFree);
  EXPECT_EQ(redesign.program.max_speed_mm_s, 6);
  EXPECT_EQ(redesign.program.duration_s, 30);
  EXPECT_TRUE(redesign.program.monotone);
  EXPECT_EQ(redesign.program.knots, 31);
  EXPECT_TRUE(redesign.fit_placement);
  EXPECT_EQ(redesign.placement_reach_mm, 25);
  EXPECT_EQ(redesign.pareto_points, 5);
  EXPECT_EQ(study.simulation.body.height_mm, 1650);
  EXPECT_EQ(study.simulation.body.mass_kg, 60);
  EXPECT_EQ(study.simulation.seat_edge_mm, 150);
  ASSERT_TRUE(study.stroke);
  EXPECT_EQ(study.stroke->duty_table, folder_ / "duty.csv");
  EXPECT_EQ(study.stroke->schedule.margin_mm, 1);
  EXPECT_TRUE(study.stroke->schedule.return_trip);
  EXPECT_EQ(study.stroke->rate_hz, 20);
  EXPECT_TRUE(study.stroke->firmware.accept_drift);
  EXPECT_EQ(study.stroke->firmware.speed_tolerance_percent, 3);
  EXPECT_EQ(study.stroke->firmware.home_stroke_mm, 244);
  EXPECT_EQ(study.stroke->firmware.extend_stop_mm, 0.7);
  EXPECT_EQ(study.inputs.size(), 7u);
}

// A section knows every option of the program that does its work.
TEST_F(StudyYaml, HasEveryOptionOfItsPrograms) {
  const study::StudyFile study = Read(
      "human: {video: human.mp4, export: [trc, mot], dictionary: DICT_5X5_100}\n"
      "exo: {video: exo.mp4, seeds: ['knee=1,2']}\ncompare: {replacement_sd_mm: 7}\n"
      "design: {starts: 5, seed_number: 3, round_mm: 0.5}\n"
      "reoptimize: {human_only: true, starts: 4, seed_number: 9, yield_mm: 0.2}\n"
      "simulate: {angles_deg: [10, 90], knee_torque_nm: 25, animation: false}\n"
      "stroke: {max_acceleration_mm_s2: 30, lag_s: 0.1, home_error_mm: 0.2}\n");
  const auto& human = std::get<commands::TrackRunOptions>(study.human.work);
  EXPECT_THAT(human.exports, ElementsAre("trc", "mot"));
  EXPECT_EQ(human.track.dictionary, "DICT_5X5_100");
  EXPECT_EQ(study.compare.misalignment.replacement_sd_mm, 7);
  EXPECT_EQ(study.optimum.optimize.starts, 5);
  EXPECT_EQ(study.optimum.optimize.seed, 3u);
  EXPECT_EQ(study.optimum.round_mm, 0.5);
  EXPECT_EQ(study.redesign->search.optimize.starts, 4);
  EXPECT_EQ(study.redesign->search.optimize.seed, 9u);
  EXPECT_EQ(study.redesign->search.yield_tolerance_mm, 0.2);
  EXPECT_THAT(study.simulation.angles_deg, ElementsAre(10, 90));
  EXPECT_EQ(study.simulation.knee_torque_nm, 25);
  EXPECT_FALSE(study.simulation.animation);
  EXPECT_EQ(study.stroke->schedule.max_acceleration_mm_s2, 30);
  EXPECT_EQ(study.stroke->firmware.lag_s, 0.1);
  ExpectRefused("human: {video: human.mp4}\ndesign:\n  starts: 0\n", "study.yaml:3: 'starts' must be at least 1");
}

TEST_F(StudyYaml, TakesItsProblemFromAFileToo) {
  WriteTextFile(folder_ / "problem.yaml", "d_min_mm: 250\n");
  EXPECT_EQ(Read("human: {video: human.mp4}\ndesign: {problem: problem.yaml}\n").design.problem.d_min_mm, 250);
  WriteTextFile(folder_ / "problem.yaml", "d_mim_mm: 250\n");
  ExpectRefused("human: {video: human.mp4}\ndesign: {problem: problem.yaml}\n", "problem.yaml:1: unknown key");
  ExpectRefused("human: {video: human.mp4}\ndesign:\n  problem: {d_min_mm: -1}\n", "study.yaml:3: ");
  ExpectRefused("human: {video: human.mp4}\ndesign: {certify_deg: 0}\n", "'certify_deg' must be positive");
}

TEST_F(StudyYaml, NamesItsResultsAfterItsFolderOrItself) {
  const std::string text = "human: {video: human.mp4}\n";
  EXPECT_EQ(Read(text).ResultName(), folder_.Path().filename());
  WriteTextFile(folder_ / "knees.yaml", text);
  EXPECT_EQ(study::ReadStudyFile(folder_ / "knees.yaml").ResultName(), "knees");
  EXPECT_EQ(Read("out: there\n" + text).ResultName(), (folder_ / "there").string());
}

TEST_F(StudyYaml, MayAskForACalibration) {
  const study::StudyFile study = Read(
      "camera:\n  calibrate:\n    images: [boards/*.png, board.png]\n    board: chessboard:9x6:25\n"
      "    plane: {image: board.png, board: 'chessboard:9x6:25'}\nhuman: {video: frames/%05d.png}\n");
  ASSERT_TRUE(study.calibration);
  EXPECT_THAT(study.calibration->camera.pictures,
              ElementsAre(folder_ / "boards/b1.png", folder_ / "boards/b2.png", folder_ / "board.png"));
  EXPECT_EQ(study.calibration->plane->picture, folder_ / "board.png");
  EXPECT_EQ(study.inputs.size(), 4u) << "each file once, the sequence as its folder";
  ExpectRefused("camera: {calibrate: {images: boards/*.png}}\nhuman: {video: human.mp4}\n", ":1: 'board' is missing");
  ExpectRefused("camera: {calibrate: {images: boards/*.png, board: chess}}\nhuman: {video: human.mp4}\n", ":1: ");
  ExpectRefused("camera: {calibrate: {board: 'chessboard:9x6:25'}}\nhuman: {video: human.mp4}\n",
                "either 'images' or 'video'");
}

TEST_F(StudyYaml, TellsOfAllMissingFilesAtOnce) {
  ExpectRefused(
      "camera: no-camera.yaml\nhuman:\n  video: no-human.mp4\n  corrections: corrections.csv\n"
      "exo: {video: exo.mp4, corrections: no-corrections.csv}\n",
      fmt::format("study.yaml: 3 files are missing: {0}/no-camera.yaml ({0}/study.yaml:1), {0}/no-human.mp4 "
                  "({0}/study.yaml:3), {0}/no-corrections.csv ({0}/study.yaml:5)",
                  folder_.Path().string()));
  ExpectRefused("camera: {calibrate: {images: other/*.png, board: 'chessboard:9x6:25'}}\nhuman: {video: human.mp4}\n",
                "a file is missing: " + (folder_ / "other/*.png").string());
}

TEST_F(StudyYaml, RefusesWithTheLine) {
  ExpectRefused("human: {video: human.mp4}\nexxo: {}\n",
                "study.yaml:2: unknown key 'exxo'; did you mean 'exo'?; known here: ");
  ExpectRefused("human:\n  video: human.mp4\n  seed: [a]\n", "study.yaml:3: unknown key 'seed'");
  ExpectRefused("human: {trial: trial.trc, markers: [knee]}\n", "study.yaml:1: unknown key 'markers'");
  ExpectRefused("exo: {video: exo.mp4}\n", "study.yaml:1: 'human' is missing");
  ExpectRefused("name: Me\nhumann: {video: human.mp4}\n", "study.yaml:2: unknown key 'humann'; did you mean 'human'?");
  ExpectRefused("human: {markers: [knee]}\n", "either 'video' or 'trial'");
  ExpectRefused("human: {video: human.mp4, trial: trial.trc}\n", "either 'video' or 'trial'");
  ExpectRefused("human:\n  video: human.mp4\n  seeds: [\"knee=1\"]\n", "study.yaml:3: ");
  ExpectRefused("human:\n  video: human.mp4\n  seeds: [\"toe=1,2\"]\n", "toe");
  ExpectRefused("human:\n  video: human.mp4\n  detector: magic\n", "study.yaml:3: 'detector' must be one of");
  ExpectRefused("human: {video: human.mp4, scale: [1, 2]}\n", "'scale' must have 5 numbers, not 2");
  ExpectRefused("human: {video: human.mp4, start_s: 5, end_s: 3}\n", "'end_s' is before 'start_s'");
  ExpectRefused("human: {video: human.mp4, start_s: early}\n", "must be a finite number, not 'early'");
  ExpectRefused("human: {video: human.mp4, cutoff_hz: .nan}\n", "must be a finite number, not '.nan'");
  ExpectRefused("human: {video: ''}\n", "a file is needed");
  ExpectRefused("human: human.mp4\n", "study.yaml:1: 'human' must have keys");
  ExpectRefused("- human\n", "a study is a map");
  ExpectRefused("human: {video: human.mp4\n", "not YAML");
  ExpectRefused("human: {video: human.mp4}\nexo: {video: exo.mp4}\ncompare: {replacement_sd_mm: -1}\n",
                "study.yaml:3: 'replacement_sd_mm' must be at least 0");
  ExpectRefused("human: {video: human.mp4}\ncompare: {human_knee: knee}\n", "'compare' needs an 'exo' trial");
}

TEST_F(StudyYaml, RefusesMarkersThatAreNotLookedFor) {
  ExpectRefused("human: {video: human.mp4}\nexo: {video: exo.mp4}\ncompare: {exo_knee: exo_knee}\n",
                "study.yaml:3: 'exo_knee' is not among the markers of exo.mp4 (ankle, knee, hip, waist)");
  ExpectRefused("human: {video: human.mp4, markers: [ankle, hip]}\nexo: {video: exo.mp4}\ncompare: {}\n",
                "'knee' is not among the markers of human.mp4");
}

TEST_F(StudyYaml, TakesLoadsAndAnActuator) {
  const std::string trial = "human: {video: human.mp4}\n", loads = trial + "loads: {mass_kg: 70, height_mm: 1750}\n";
  WriteTextFile(folder_ / "problem.yaml", "load: {max_force_n: 900}\n");
  WriteTextFile(folder_ / "own.csv", "name,max_force_n,no_load_speed_mm_s\nslow,300,2\nfast,200,90\n");
  const study::StudyFile study = Read(
      loads +
      "assistance: {problem: problem.yaml, actuator: 'own.csv:fast', assist: 0.3, duration_s: 4, rest: standing}\n");
  EXPECT_EQ(study.loads->loads.body.mass_kg, 70);
  EXPECT_EQ(study.loads->loads.body.height_mm, 1750);
  const problem::SynthesisProblem& problem = study.assistance->options.problem;
  EXPECT_EQ(problem.limits["max_force_n"], 900);
  EXPECT_EQ(problem.actuator->no_load_speed_mm_s, 90);
  EXPECT_EQ(problem.assist, 0.3);
  EXPECT_EQ(problem.duration_s, 4);
  EXPECT_FALSE(problem.rests_anywhere);
  EXPECT_EQ(Read(loads + "assistance: {actuators: own.csv}\n").assistance->options.actuators, folder_ / "own.csv");
  ExpectRefused(trial + "loads: {height_mm: 1750}\n", "mass");
  ExpectRefused(trial + "loads: {mass_kg: 700}\n", "mass");
  ExpectRefused(trial + "assistance: {actuator: LA31-1000}\n", "study.yaml:2: 'assistance' is a share");
  ExpectRefused(loads + "assistance: {assist: 0.4}\n", "study.yaml:3: 'assistance' needs an 'actuator'");
  ExpectRefused(loads + "assistance: {actuator: L17}\n", "study.yaml:3: there is no actuator 'L17'");
  ExpectRefused(loads + "assistance: {actuator: LA31-1000, assist: 3}\n", "between 0 and 1");
  ExpectRefused(loads + "assistance: {actuators: none.csv}\n", "none.csv");
}

TEST_F(StudyYaml, TakesBalanceOfABodyThatItKnows) {
  const std::string trial = "human: {video: human.mp4}\n", balance = "reoptimize: {balance: {margin_mm: 20}}\n";
  const study::StudyFile study = Read(trial + "loads: {mass_kg: 70}\n" + balance);
  EXPECT_EQ(study.redesign->options.balance_mm, 20);
  for (const steps::StudyStep& step : study::StudySteps(study, folder_ / "out", Json::object()))
    if (step.name == "redesign") {
      EXPECT_THAT(step.inputs, testing::Contains(folder_ / "out/loads/loads.json"));
    }
  const study::StudyFile held = Read(trial + "loads: {mass_kg: 70}\n" +
                                     "reoptimize: {balance: {margin_mm: 20, device_mass_kg: 2.5, hold_force_n: 60}}\n");
  EXPECT_EQ(held.redesign->options.aids.device_kg, 2.5);
  EXPECT_EQ(held.redesign->options.aids.hold_n, 60);
  ExpectRefused(trial + "loads: {mass_kg: 70}\nreoptimize: {balance: {margin_mm: 20, hold_force_n: -1}}\n",
                "'hold_force_n'");
  ExpectRefused(trial + balance, "'balance' needs the person's body");
  ExpectRefused(trial + "loads: {mass_kg: 70}\nreoptimize: {balance: {margin_mm: -1}}\n", "'margin_mm'");
  ExpectRefused(trial + "loads: {mass_kg: 70}\nreoptimize: {balance: {margin: 20}}\n", "'margin_mm'");
}

std::vector<std::string> Changed(const std::map<std::string, Json>& before, const std::map<std::string, Json>& after) {
  std::vector<std::string> names;
  for (const auto& [name, options] : before)
    if (options != after.at(name)) names.push_back(name);
  return names;
}

// A catalogue of one's own that changes makes those steps due that its actuator counts in.
TEST_F(StudyYaml, StepsKnowTheirActuator) {
  const std::string trial = "human: {video: human.mp4}\nloads: {mass_kg: 70}\n";
  const auto options = [&](const std::string& yaml, int speed_mm_s) {
    WriteTextFile(folder_ / "own.csv", fmt::format("name,max_force_n,no_load_speed_mm_s\nfast,200,{}\n", speed_mm_s));
    return StepOptions(yaml);
  };
  const auto changed = [&](const std::string& yaml) { return Changed(options(yaml, 90), options(yaml, 80)); };
  EXPECT_THAT(changed(trial + "assistance: {actuator: 'own.csv:fast'}\n"), ElementsAre("assistance", "simulation"));
  EXPECT_THAT(changed(trial + "design: {problem: {actuator: 'own.csv:fast'}}\n"), ElementsAre("optimum", "simulation"));
}

// Whatever a step is made of counts in what it depends on, wherever it is said.
TEST_F(StudyYaml, StepsKnowTheirPartsBodyAndLoad) {
  const std::string trial = "human: {trial: trial.trc}\nloads: {mass_kg: 70}\n";
  const auto changed = [&](const std::string& before, const std::string& after) {
    return Changed(StepOptions(trial + before), StepOptions(trial + after));
  };
  const std::string limited = "design: {problem: {load: {safety_factor: 1.5}}}\n";
  EXPECT_THAT(changed(limited + "simulate: {rod_diameter_mm: 10}\n", limited + "simulate: {rod_diameter_mm: 6}\n"),
              ElementsAre("optimum", "simulation"));
  EXPECT_THAT(changed(limited, limited + "simulate: {plate: '3mm,6061-T6'}\n"), ElementsAre("optimum", "simulation"));
  EXPECT_THAT(changed("design: {problem: {parts: {rod_diameter_mm: 10}}}\n",
                      "design: {problem: {parts: {rod_diameter_mm: 6}}}\n"),
              ElementsAre("optimum", "simulation"));
  EXPECT_THAT(changed("", "design: {problem: {load: {knee_torque_nm: 60}}}\n"), ElementsAre("optimum", "simulation"));
  const std::string seated = "design: {clearances: {seat_mm: 5}}\nreoptimize: {clearances: {seat_mm: 5}}\n";
  EXPECT_THAT(changed(seated, seated + "simulate: {height_mm: 1650}\n"),
              ElementsAre("optimum", "redesign", "simulation"));
  EXPECT_THAT(changed(limited, limited + "simulate: {animation: false}\n"), ElementsAre("simulation"));
}

// The parts are the problem's, but for what `simulate` says of them, of the design as of its simulation.
TEST_F(StudyYaml, PartsAreTheProblemsUnlessSimulateSaysOthers) {
  const auto parts = [&](const std::string& simulate) {
    std::map<std::string, std::string> of;
    const std::string yaml =
        "human: {trial: trial.trc}\ndesign: {problem: {load: {knee_torque_nm: 55}, parts: "
        "{rod_diameter_mm: 6, pin_diameter_mm: 5}}}\n" +
        simulate;
    for (const steps::StudyStep& step : Steps(yaml))
      if (step.summary_options.contains("rod-diameter"))
        of[step.name] = fmt::format("{} {} {}", step.summary_options["rod-diameter"].get<std::string>(),
                                    step.summary_options["pin-diameter"].get<std::string>(),
                                    step.summary_options["knee-torque"].get<std::string>());
    return of;
  };
  const auto both = [](const char* text) {
    return ElementsAre(testing::Pair("optimum", text), testing::Pair("simulation", text));
  };
  EXPECT_THAT(parts(""), both("6 5 55"));
  EXPECT_THAT(parts("simulate: {animation: false}\n"), both("6 5 55"));
  EXPECT_THAT(parts("simulate: {pin_diameter_mm: 8}\n"), both("6 8 55"));
}

// Each of the comparison's cuffs and stiffnesses that the redesign does not say otherwise.
TEST_F(StudyYaml, TheRedesignHasTheComparisonsCuffs) {
  const std::string yaml =
      "human: {video: human.mp4}\nexo: {trial: trial.trc}\n"
      "compare: {thigh_cuff: ['150:60'], cuff_softest_n_mm: 0.5}\n"
      "reoptimize: {human_only: true, cuff_softest_n_mm: 0.7, shank_cuff: ['180:80']}\n";
  const Json redesign = StepOptions(yaml).at("redesign");
  EXPECT_THAT(redesign.value("thigh-cuff", Json()).dump(), HasSubstr("150:60"));
  for (const char* name : {"shank-cuff", "cuff-softest", "cuff-stiffest"})
    EXPECT_FALSE(redesign.contains(name)) << name;
}

TEST_F(StudyYaml, RefusesDesignsThatCannotBe) {
  const std::string trial = "human: {video: human.mp4}\n";
  ExpectRefused(trial + "reoptimize:\n  program: slow\n", "study.yaml:3: 'program' must be one of");
  ExpectRefused(trial + "reoptimize: {pareto: 1}\n", "'pareto' must be at least 2");
  ExpectRefused(trial + "reoptimize: {max_misalignment: 1}\n", "study.yaml:2: unknown key 'max_misalignment'");
  ExpectRefused(trial + "reoptimize: {clearances: {seat: 5}}\n", "study.yaml:2: unknown key 'seat'");
  ExpectRefused(trial + "reoptimize: {clearances: {limb_mm: -5}}\n", "study.yaml:2: 'limb_mm' must be at least 0");
  ExpectRefused(trial + "reoptimize: {clearances: {limb_mm: 10}}\n", "give mount: behind");
  ExpectRefused(trial + "reoptimize: {duration_s: -1}\n", "'duration_s' must be positive");
  const std::string both = trial + "exo: {video: exo.mp4}\n";
  ExpectRefused(both + "reoptimize: {pareto: 3}\n", "human_only: true");
  EXPECT_TRUE(Read(both + "reoptimize: {human_only: true}\n").redesign->options.human_only);
  ExpectRefused(trial + "design: {worn: worn.yaml}\n", "'worn' needs an 'exo' trial");
  ExpectRefused(trial + "stroke: {margin_mm: -1}\n", "study.yaml:2: ");
  ExpectRefused(trial + "stroke: {speed_tolerance_percent: 300}\n", "study.yaml:2: ");
  ExpectRefused(trial + "stroke: {accept_drift: perhaps}\n", "study.yaml:2: ");
  ExpectRefused(trial + "stroke: {duty: x}\n", "study.yaml:2: unknown key 'duty'");
  for (const Removed& removed : AllRemoved())
    if (!removed.key.empty())
      ExpectRefused(fmt::format("{}stroke: {{{}: x}}\n", trial, removed.key),
                    fmt::format("study.yaml:2: '{}' is removed: {}", removed.key, removed.instead));
}

// What a step depends on: the same whatever the order of keys and the blanks, another for another value.
TEST_F(StudyYaml, KeepsWhatASectionSays) {
  const Json one = Read("human: {video: human.mp4, start_s: 5, filter: none}\n").human.section.text;
  const Json other =
      Read("human:\n  # a comment\n  start_s: 5.0\n  filter: none\n  video: human.mp4\n").human.section.text;
  EXPECT_EQ(one, other);
  EXPECT_NE(one, Read("human: {video: human.mp4, start_s: 6, filter: none}\n").human.section.text);
}

// What the study asks for stands above its problem, for each design by itself.
TEST_F(StudyYaml, ClearancesOfTheStudyStandAboveThoseOfTheProblem) {
  const study::StudyFile study = Read(
      "human: {trial: trial.trc}\ndesign: {problem: {clearances: {seat_mm: 1}, body: {mass_kg: 60}}}\n"
      "reoptimize: {problem: {mount: behind}, clearances: {seat_mm: 5, limb_mm: 10}}\n");
  EXPECT_EQ(study.design.problem.clearances.seat_mm, 1);
  EXPECT_EQ(study.design.problem.clearances.body.mass_kg, 60);
  const problem::Clearances& redesign = study.redesign->design.problem.clearances;
  EXPECT_EQ(redesign.seat_mm, 5);
  EXPECT_EQ(redesign.thigh_mm, 10);
  EXPECT_EQ(redesign.shank_mm, 10);
}

}  // namespace
}  // namespace lake
