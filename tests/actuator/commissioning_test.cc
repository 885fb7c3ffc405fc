// The schematic and the sign-off sheet of a sketch.
#include <set>

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

// What the sketch's folder has of safety is what the project says.
TEST(Commissioning, TheSketchHasSafetyAndRisks) {
  std::set<std::string> names;
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources()) names.insert(file.name);
  EXPECT_TRUE(names.contains("SAFETY.md") && names.contains("RISKS.md"));
}

}  // namespace
}  // namespace lake
