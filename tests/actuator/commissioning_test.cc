// The schematic and the sign-off sheet of a sketch.
#include "lake/actuator/commissioning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "model_program.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

actuator::FirmwareOptions Everything() {
  actuator::FirmwareOptions options;
  options.feedback = actuator::Feedback::kPotentiometer, options.potentiometer = {0, 240, 1023, 380};
  options.supply_v = 12, options.current_sense = true, options.bridge_sense = true;
  options.pins.safety_relay = 5, options.pins.hold_button = 4, options.pins.in1 = 6;
  options.speed_limit_mm_s = 6;
  options.force_limit_n = 400, options.force_n_per_a = 250, options.idle_a = 0.3;
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
  const actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {2, 306}});
  const actuator::DutyTable table = ModelTable();
  actuator::FirmwareOptions options;
  const auto sheet = [&] {
    return actuator::SignOffSheet(actuator::MakeStrokeTable(schedule, table, options), schedule, table, options);
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
