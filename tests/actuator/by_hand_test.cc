// What somebody with a serial monitor meets.
#include <algorithm>
#include <cctype>

#include "host/host_fixture.h"
#include "lake/core/atomic_file.h"
#include "places.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

using ByHandTest = HostFirmwareTest;

// Homing is longer than the time-out of a host that does not talk.
TEST_F(ByHandTest, HomingWithoutAHostThatTalksIsHeld) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SetStroke(330);
  rig_->KeepTalking(false);
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_FALSE(rig_->RunUntil("[MSG:done]", 4));
  EXPECT_THAT(rig_->Status(), HasSubstr("<hold"));
  EXPECT_EQ(rig_->Duty(), 0);
  EXPECT_TRUE(Asks("home", "error:4"));
  EXPECT_TRUE(Asks("stop", "ok"));
  rig_->KeepTalking(true);
  Home(20);
}

// Whatever moves stops within the ms in which the button is let go, and begins again with homing.
TEST_F(ByHandTest, TheButtonIsHeldWhileAnythingMoves) {
  firmware_options_.pins.hold_button = 4;
  Build(FreeDesign({{0, 300}, {2, 306}}));
  const auto let_go = [&](const char* line, const char* state) {
    ASSERT_TRUE(Asks(line, "ok")) << rig_->Serial();
    rig_->Run(0.3);
    ASSERT_NE(rig_->Duty(), 0) << line;
    const std::size_t from = rig_->Serial().size();
    rig_->ReleaseButton(true);
    rig_->Run(0.001);
    EXPECT_EQ(rig_->Duty(), 0) << line;
    rig_->Run(0.02);
    EXPECT_THAT(rig_->Serial().substr(from), HasSubstr("[MSG:button released, stopped]\n")) << line;
    EXPECT_THAT(rig_->Status(), HasSubstr(state)) << line;
    rig_->ReleaseButton(false);
    rig_->Run(1);
    EXPECT_EQ(rig_->Duty(), 0) << "held again it does not go on";
    ASSERT_TRUE(Asks("stop", "ok"));
  };
  let_go("home", "<hold");
  ASSERT_TRUE(Asks("zero", "ok"));
  let_go("run", "<hold");
  EXPECT_TRUE(Asks("run", "error:5")) << "it begins again with homing";
  let_go("jog 500 2000", "<idle");
  rig_->ReleaseButton(true);
  rig_->Run(0.01);
  for (const char* line : {"home", "jog 500 100"}) EXPECT_TRUE(Asks(line, "error:10")) << line;
  EXPECT_TRUE(Asks("stop", "ok"));
}

TEST_F(ByHandTest, StopGivesHomingUpAndHoldEndsIt) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SetStroke(330);
  rig_->KeepTalking(false);
  ASSERT_TRUE(Asks("home", "ok"));
  rig_->Run(3);
  ASSERT_TRUE(Asks("stop", "ok"));
  rig_->Run(1);
  EXPECT_EQ(rig_->Duty(), 0);
  EXPECT_TRUE(Asks("run", "error:5"));
  ASSERT_TRUE(Asks("home", "ok"));
  rig_->Run(0.5);
  rig_->SendNow('!');
  rig_->Run(0.2);
  EXPECT_THAT(rig_->Status(), HasSubstr("<idle"));
}

TEST_F(ByHandTest, IsToldWhoMayWearItAndWhatTheProgramIs) {
  firmware_options_.design_hash = "0123456789ab";
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SendNow('\x18');
  rig_->Run(0.1);
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:design 0123456789ab, duty table MODEL, not measured]\n"));
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:open loop: the stroke is planned, not measured]\n"));
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:unworn only: homing takes the knee to "));
}

TEST(SketchNotes, SayWhatIsOfThisSketchAlone) {
  actuator::FirmwareOptions options;
  options.design_hash = "0123456789ab", options.extend_stop_mm = 0.6;
  actuator::Sketch sketch(FreeSchedule({{0, 300}, {2, 306}}), ModelTable(), options);
  const std::string notes = actuator::SketchNotes(sketch, "from design.yaml");
  for (const char* part :
       {"0123456789ab (SHA-256)", actuator::kUntried, "MODEL duty table", "UNWORN ONLY: home takes the knee to 14",
        "open loop", "Retract end stop at 242.498 mm", "extend end stop at 373.9", "README.txt"})
    EXPECT_THAT(notes, HasSubstr(part));
  std::istringstream lines(notes);
  for (std::string line; std::getline(lines, line);) EXPECT_TRUE(line.empty() || line.starts_with("//")) << line;
  sketch.table.rows.front().extend_se_mm_s = 0.1;
  EXPECT_THAT(actuator::SketchNotes(sketch, ""), Not(HasSubstr("MODEL")));
}

// Wherever a person reads about safety; what `lake-stroke` prints is in stroke_cli_test.cc.
TEST(Untried, IsSaidWhereverSomebodyReadsAboutSafety) {
  for (const char* page : {"libs/design/actuator/SAFETY.md", "libs/design/actuator/README.md",
                           "libs/design/actuator/RISKS.md", "libs/design/actuator/BENCH.md",
                           "libs/design/actuator/firmware/README.txt", "libs/present/manual/pages/prototype.md"}) {
    std::string text = ReadTextFile(SourceDir() / page);
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
    EXPECT_THAT(text, HasSubstr("been tried on a board")) << page;
    EXPECT_THAT(text, HasSubstr("nobody may wear")) << page;
  }
}

// The folder needs no other: pins, commands, what the numbers mean.
TEST(SketchNotes, TheFolderExplainsItself) {
  std::string readme;
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources())
    if (file.name == "README.txt") readme = file.text;
  for (const char* part : {"D9", "D2, D3", "NORMALLY CLOSED", "A0", "115200", "jog DUTY MS", "ALARM:N", "error:N"})
    EXPECT_THAT(readme, HasSubstr(part));
}

}  // namespace
}  // namespace lake
