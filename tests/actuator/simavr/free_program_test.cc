// The whole way: a video of a person, tracked; a design with a free program for that person; its firmware in the
// simulator; the knee angle that comes out.
#include <fmt/format.h>

#include "firmware_fixture.h"
#include "lake/core/csv.h"
#include "lake/study/study.h"
#include "pipeline/rendered_trial.h"
#include "places.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

// When the program first moves: it may begin with a rest.
double FirstMove(const CsvTable& program) {
  std::size_t row = 0;
  while (row + 1 < program.Rows() && program.RequiredNumber(row, 4) == 0) ++row;
  return program.RequiredNumber(row, 0);
}

TEST_F(FirmwareTest, VideoToDesignToProgramToKneeAngle) {
  synth::SceneOptions scene;
  scene.motion.seed = 41, scene.motion.repetitions = 1;
  scene.frame_rate_hz = 30;
  scene.width_px = 720;  // holds the leg
  const RenderedTrial person(scene, {.preset = kQuickEncoder});
  WriteTextFile(person.folder / "study.yaml",
                "name: Short\nsimulate: {animation: false}\ncamera: camera.yaml\nhuman: {video: video.mp4}\n"
                "reoptimize: {problem: {margins: {grashof_mm: 2, singularity_mm: 2}}, max_misalignment_percent: 5, "
                "program: free, duration_s: 25, max_speed_mm_s: 5}\n"
                "stroke: {duty_table: \"" +
                    (SourceDir() / "calibration/duty_table_model.csv").string() +
                    "\", accept_drift: true}\n");  // nobody wears the simulator
  lake::Run run({"lake-run", "test", Json::object(), person.folder / "out", true});
  const Json stroke = study::RunStudyFile(study::ReadStudyFile(person.folder / "study.yaml"), run)["stroke"];

  // The folder that a user would open in the Arduino IDE, built as its firmware.c says.
  const auto out = person.folder / "out/stroke";
  elf_ = out / "lake_stroke.elf";
  ASSERT_EQ(std::system(fmt::format("cd '{}' && {} -mmcu=atmega328p -std=gnu99 -Os -Wall -Wextra -Werror *.c -o '{}'",
                                    (out / actuator::kSketchFolder).string(), LAKE_AVR_GCC, elf_.string())
                            .c_str()),
            0);
  const CsvTable program = CsvTable::Read(out / "program.csv");
  const linkage::Design design = linkage::ReadDesign(person.folder / "out/redesign/design.yaml");
  actuator_.table = &table_;
  actuator_.stroke_mm = program.RequiredNumber(0, 1);
  PowerUp();
  Start();
  ASSERT_TRUE(rig_->RunUntil("[MSG:done]", stroke["duration_s"].get<double>() + 2)) << rig_->Serial();
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));

  double worst = 0, compared_s = 0;
  std::size_t row = 0;
  const double start = FirstDrive() - FirstMove(program);
  ASSERT_FALSE(std::isnan(start)) << "the motor never drove";
  for (const RigSample& sample : rig_->Samples()) {
    while (row + 1 < program.Rows() && program.RequiredNumber(row + 1, 0) <= sample.time_s - start) ++row;
    if (sample.time_s < start || row + 1 == program.Rows()) continue;
    const double t0 = program.RequiredNumber(row, 0), t1 = program.RequiredNumber(row + 1, 0);
    const double planned = std::lerp(program.RequiredNumber(row, 3), program.RequiredNumber(row + 1, 3),
                                     (sample.time_s - start - t0) / (t1 - t0));
    compared_s += 1e-3;  // samples are 1 ms apart
    worst = std::max(worst, std::abs(actuator::KneeDegAt(design.links, sample.stroke_mm) - planned));
  }
  std::printf("free program of %.1f s, %d reversals: knee within %.3f degrees of program.csv\n",
              stroke["duration_s"].get<double>(), stroke["reversals"].get<int>(), worst);
  EXPECT_LT(worst, 0.5);
  EXPECT_NEAR(compared_s, stroke["duration_s"].get<double>(), 0.1);
}

}  // namespace
}  // namespace lake
