// Whole studies of marker files: what comes out, what is done again, what is refused.
#include <gmock/gmock.h>

#include "lake/core/error.h"
#include "page_text.h"
#include "pipeline/study_trials.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

// The plan's outputs are what the steps leave, its order what they read, and it knows what is to be done.
void ExpectPlanHolds(const StudyFolder& study) {
  const study::StudyPlan plan = study::PlanStudy(study::ReadStudyFile(study.Folder() / "study.yaml"), study.Out());
  for (const study::PlannedStep& step : plan.steps) {
    EXPECT_FALSE(step.due.has_value()) << step.name << ": " << *step.due;
    for (const fs::path& output : step.outputs) EXPECT_TRUE(fs::is_regular_file(output)) << output;
  }
  EXPECT_THAT(plan.steps[2].after, ElementsAre("human", "exo"));
  EXPECT_EQ(plan.steps.back().after.size(), plan.steps.size() - 1) << "the report is of all steps";
  EXPECT_EQ(study::PlanJson(plan)["steps"].size(), plan.steps.size());
}

// human, exo -> comparison; optimum -> simulation, stroke; the report reads all.
TEST(StudyOfMarkerFiles, FindsWhatWasMadeAndRepeatsExactlyWhatDependsOnAChange) {
  StudyFolder study;
  study.WriteStudy(fmt::format("stroke: {{duty_table: '{}', accept_drift: true}}\n",
                               (SourceDir() / "calibration/duty_table_model.csv").string()));
  const Json summary = study.Go();
  EXPECT_THAT(study.Done(summary),
              ElementsAre("human", "exo", "comparison", "optimum", "simulation", "stroke", "report"));
  const Json& comparison = summary["comparison"];
  // 18 mm and 32 mm apart in a shank that holds marker noise of 0.1 mm and a body that sways by itself in each trial.
  EXPECT_NEAR(comparison["decomposition"]["offset_mm"][0].get<double>(), 18, 1);
  EXPECT_NEAR(comparison["decomposition"]["offset_mm"][1].get<double>(), 32, 1);
  EXPECT_NEAR(comparison["metrics"]["rms_mm"].get<double>(), std::hypot(18, 32), 2);
  EXPECT_EQ(summary["human"]["sit_to_stands"].size(), 2u);
  // The design is checked on the leg that was measured: noise of 0.1 mm at both ends of a vector.
  const synth::StsMotionOptions human = HumanMotionOptions();
  EXPECT_NEAR(summary["simulation"]["mannequin"]["thigh_mm"].get<double>(), human.thigh_mm, 0.1);
  EXPECT_NEAR(summary["simulation"]["mannequin"]["shank_mm"].get<double>(), human.shank_mm, 0.1);
  // Beside the leg, where no clearance to it is judged.
  EXPECT_EQ(summary["simulation"]["mannequin"]["mount"], "beside");
  EXPECT_THAT(summary["warnings"].dump(), Not(HasSubstr("the actuator overlaps")));
  for (const char* file :
       {"report.html", "summary.json", "human/kinematics.csv", "exo/gait.png", "simulation/animation.mp4",
        "comparison/comparison.json", "comparison/report.html", "human/summary.json"})
    EXPECT_TRUE(fs::is_regular_file(study.Out() / file)) << file;

  EXPECT_THAT(ReadPageText(study.Out() / "report.html"), HasSubstr("firmware for the Arduino UNO"));
  const std::string firmware = "stroke/lake_stroke/lake_stroke.ino";
  EXPECT_THAT(ReadTextFile(study.Out() / "report.html"), HasSubstr(fmt::format("href=\"./{}\"", firmware)));
  EXPECT_TRUE(fs::is_regular_file(study.Out() / firmware));

  ExpectPlanHolds(study);
  EXPECT_THAT(study.Done(study.Go()), IsEmpty());

  const std::string still = kNoAnimation;
  study.WriteStudy(still);
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("simulation", "report"));

  study.WriteTrial("exo.csv", RecordingOf(synth::StsMotion(ExoMotionOptions()), 3));
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("exo", "comparison", "report"));

  study.WriteStudy(still + "compare: {replacement_sd_mm: 1}\n# a comment\n");
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("comparison", "report"));

  study.WriteStudy(still + "compare: {replacement_sd_mm: 1.0}\ndesign: {problem: {d_min_mm: 245}}\n");
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("optimum", "simulation", "report"));

  fs::remove(study.Out() / "comparison/misalignment.csv");
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("comparison"));
  EXPECT_TRUE(fs::exists(study.Out() / "comparison/misalignment.csv"));
}

// The safety factor that the design must have is of the parts that are simulated, whichever part changes.
TEST(StudyOfMarkerFiles, ADesignIsOfThePartsThatAreSimulated) {
  StudyFolder study;
  const auto go = [&](const std::string& parts, const std::string& simulate) {
    study.WriteStudy(
        "design: {problem: {d_min_mm: 242, standing_deg: 5, margins: {grashof_mm: 2, singularity_mm: 2}, "
        "load: {knee_torque_nm: 40, safety_factor: 1.5}" +
        parts + "}}\n" + simulate);
    const Json summary = study.Go();
    EXPECT_THAT(study.Done(summary), testing::IsSupersetOf({"optimum", "simulation"})) << parts << simulate;
    return std::pair(summary["optimum"]["range_deg"].get<double>(),
                     summary["simulation"]["weakest"]["safety"].get<double>());
  };
  const auto thick = go("", "simulate: {animation: false, plate: '4mm,6061-T6', rod_diameter_mm: 10}\n");
  EXPECT_NEAR(thick.first, 153.77, 0.01);
  const auto thin = go("", "simulate: {animation: false, plate: '4mm,6061-T6', rod_diameter_mm: 6}\n");
  EXPECT_NEAR(thin.first, 79.98, 0.01);
  EXPECT_NEAR(thin.second, 1.5, 1e-3);
  const auto of_problem = go(", parts: {plate: '4mm,6061-T6', rod_diameter_mm: 6}", kNoAnimation);
  EXPECT_NEAR(of_problem.first, 79.98, 0.01) << "what simulate does not say is as in the problem";
  EXPECT_NEAR(of_problem.second, 1.5, 1e-3);
}

TEST(StudyOfMarkerFiles, FitsADesignToThePersonWithoutAnExoTrialToo) {
  StudyFolder study;
  WriteTextFile(study.Folder() / "study.yaml",
                std::string(kNoAnimation) +
                    "human: {trial: human.csv}\n"
                    "reoptimize: {problem: {margins: {grashof_mm: 2, singularity_mm: 2}}, max_misalignment_percent: 5, "
                    "program: free, duration_s: 40, clearances: {seat_mm: 5}}\nstroke: {}\n"
                    "loads: {mass_kg: 70, draws: 40}\nassistance: {actuator: LA31-1000, assist: 0.4, duration_s: free, "
                    "starts: 3, problem: {margins: {grashof_mm: 2, singularity_mm: 2}, standing_deg: 8}}\n");
  const Json summary = study.Go();
  EXPECT_THAT(study.Done(summary),
              ElementsAre("human", "loads", "optimum", "redesign", "assistance", "simulation", "stroke", "report"));
  // The design that was made for the actuator is no slower than the one made for the person's path.
  const Json &lift = summary["assistance"]["assistance"], &redesign = summary["simulation"]["assistance"];
  EXPECT_GT(lift["shortest_duration_s"].get<double>(), lift["any_linkage_duration_s"].get<double>());
  EXPECT_LT(lift["shortest_duration_s"].get<double>(), redesign["shortest_duration_s"].get<double>());
  const Json &body = summary["simulation"]["mannequin"], &asked = summary["redesign"]["clearances"];
  EXPECT_EQ(body["mass_kg"], 70) << "as the loads have it";
  // What was required is held by the check, on the same body.
  for (const char* key : {"mass_kg", "height_mm", "thigh_mm", "shank_mm"}) EXPECT_EQ(asked[key], body[key]) << key;
  EXPECT_GE(body["seat_clearance_mm"].get<double>(), 5 - 1e-4);
  EXPECT_LE(summary["redesign"]["misalignment_percent"].get<double>(), 5 * (1 + 1e-4));
  EXPECT_LE(summary["redesign"]["stroke_program"]["duration_s"].get<double>(), 40 + 1e-3);
  EXPECT_NEAR(summary["stroke"]["duration_s"].get<double>(),
              summary["redesign"]["stroke_program"]["duration_s"].get<double>(),
              1);  // pauses before reversals
  const std::string page = ReadPageText(study.Out() / "report.html");
  for (const char* chapter : {"Result", "New design", "Fit on the body, and motion", "Stroke program", "Recordings",
                              "Benchmark optimum", "Methods"})
    EXPECT_THAT(page, HasSubstr(chapter));
  EXPECT_THAT(page, HasSubstr("The design was required to keep 5.0 mm from the seat."));
  for (const Json& warning : summary["warnings"]) {
    // As far as the first character that HTML escapes.
    const std::string whole = warning, text = whole.substr(whole.find(": ") + 2);  // the page has the step's own words
    EXPECT_THAT(page, HasSubstr(text.substr(0, text.find_first_of("&<>'\"")))) << "every warning is shown";
  }

  // Taken out of the study, they go with their chapters; what the user put there stays.
  ASSERT_TRUE(fs::is_regular_file(study.Out() / "stroke/summary.json"));
  WriteTextFile(study.Out() / "stroke/notes.txt", "mine");
  WriteTextFile(study.Folder() / "study.yaml", std::string(kNoAnimation) + "human: {trial: human.csv}\n");
  EXPECT_THAT(study.Done(study.Go()), ElementsAre("simulation", "report"));
  EXPECT_FALSE(fs::exists(study.Out() / "redesign"));
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(study.Out() / "stroke"), {}), 1) << "the user's notes";
  const std::string after = ReadPageText(study.Out() / "report.html");
  for (const char* chapter : {"New design", "Stroke program"}) EXPECT_THAT(after, Not(HasSubstr(chapter)));
}

}  // namespace
}  // namespace lake
