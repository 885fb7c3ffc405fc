// What stands beside a sketch: schematic, sign-off sheet, notes.
#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "places.h"
#include "program_fixture.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

actuator::FirmwareOptions Everything() {
  actuator::FirmwareOptions options;
  WireAll(options);
  options.pins.hold_button = 4, options.pins.in1 = 6;
  return options;
}

TEST(Commissioning, TheSchematicHasThisSketchsPins) {
  const std::string all = actuator::SchematicSvg(Everything());
  for (const char* part : {"<svg", ">D9<", ">D6<", ">D8<", ">D5<", ">D4<", ">A3<", ">A4<", "fuse 1.9 A",
                           "emergency stop", "safety relay", "Not tried on a board"})
    EXPECT_THAT(all, HasSubstr(part));
  const std::string least = actuator::SchematicSvg({});
  EXPECT_THAT(least, AllOf(HasSubstr(">D7<"), Not(HasSubstr("safety relay")), Not(HasSubstr(">A3<"))));
}

TEST(Commissioning, TheSignOffSheetSaysWhatTheFirmwareCannotKnow) {
  actuator::FirmwareOptions options;
  const auto sheet = [&] {
    return actuator::SignOffSheet({FreeSchedule({{0, 300}, {2, 306}}), ModelTable(), options});
  };
  EXPECT_THAT(sheet(), AllOf(HasSubstr("not been tried on a board"), HasSubstr("It does not see the emergency stop"),
                             HasSubstr("ENA's jumper removed")));
  options = Everything();
  EXPECT_THAT(sheet(), AllOf(HasSubstr("ALARM:16"), HasSubstr("ALARM:12 below 400 N"), HasSubstr("error:10"),
                             Not(HasSubstr("emergency stop: released"))));
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

// The folder needs no other: pins, commands, what the numbers mean, and of safety what the project says. It is a sketch
// of the Arduino IDE: one .ino, of the folder's name.
TEST(SketchNotes, TheFolderExplainsItself) {
  std::map<std::string, std::string> files;
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources()) files[file.name] = file.text;
  for (const char* part : {"D9", "D2, D3", "NORMALLY CLOSED", "A0", "115200", "jog DUTY MS", "ALARM:N", "error:N"})
    EXPECT_THAT(files["README.txt"], HasSubstr(part));
  EXPECT_TRUE(files.contains("SAFETY.md") && files.contains("RISKS.md"));
  EXPECT_EQ(std::ranges::count_if(files, [](const auto& file) { return file.first.ends_with(".ino"); }), 1);
  EXPECT_TRUE(files.contains(std::string(actuator::kSketchFolder) + ".ino"));
}

}  // namespace
}  // namespace lake
