// The plan of the bench's tests, and verdicts on made-up logs whose truth is known.
#include "lake/actuator/bench_validation.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "lake/actuator/commissioning.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "model_program.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using actuator::BenchReport;
using actuator::BenchVerdict;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class BenchValidationTest : public testing::Test {
 protected:
  // The bridge drives from 0 s to 1 s and so long after, the fault comes at 1 s.
  void WriteLogic(const std::string& name, double drives_on_s) {
    WriteTextFile(folder_ / name,
                  fmt::format("time_s,fault,ena,in1,in2\n0,0,1,1,0\n1,1,1,1,0\n{},1,0,1,0\n{},1,0,0,0\n3,0,0,0,0\n",
                              1 + drives_on_s, 1.001 + drives_on_s));
  }
  void WriteBench(const std::vector<std::string>& rows) {
    std::string text = "fault,state,how,alarms,most_off_s,most_way_mm,serial,logic,way_mm\n";
    for (const std::string& row : rows) text += row + "\n";
    WriteTextFile(folder_ / "bench.csv", text);
  }
  // The finding on the wiper's wire while it runs.
  actuator::BenchFinding Wiper() {
    for (const actuator::BenchFinding& finding : actuator::ValidateBench(folder_.Path()).findings)
      if (finding.found.fault == "wiper_lost" && finding.found.state == "running, extending") return finding;
    return {};
  }

  TemporaryFolder folder_;
};

const std::string kWiper = "wiper_lost,\"running, extending\",,,,,";

TEST_F(BenchValidationTest, TakesTimesAndAlarmsFromTheLogs) {
  WriteTextFile(folder_ / "serial.csv", "time_s,planned_mm\n0.100,300\nALARM:7\n0.200,\n");
  WriteLogic("logic.csv", 0.012);
  WriteBench({kWiper + "serial.csv,logic.csv,0.2"});
  EXPECT_EQ(Wiper().verdict, BenchVerdict::kPassed) << Wiper().why;
  EXPECT_EQ(Wiper().alarm, 7);
  EXPECT_NEAR(Wiper().off_s.value_or(NAN), 0.012, 1e-9);

  WriteLogic("logic.csv", 0.2);
  EXPECT_EQ(Wiper().verdict, BenchVerdict::kFailed);
  EXPECT_THAT(Wiper().why, HasSubstr("the bridge drove for 0.200 s, at most 0.050"));
  WriteLogic("logic.csv", 0.012);
  WriteBench({kWiper + "serial.csv,logic.csv,-1.5"});
  EXPECT_THAT(Wiper().why, HasSubstr("the rod went -1.50 mm, at most 0.50"));
  WriteTextFile(folder_ / "serial.csv", "0.100,300\n");
  EXPECT_THAT(Wiper().why, HasSubstr("no ALARM was told"));
  WriteTextFile(folder_ / "serial.csv", "ALARM:12\n");
  EXPECT_THAT(Wiper().why, HasSubstr("ALARM:12 was told, which this fault does not give"));
  WriteBench({kWiper + "serial.csv,,0.1"});
  EXPECT_EQ(Wiper().verdict, BenchVerdict::kMissing);
}

TEST_F(BenchValidationTest, ABridgeThatDrivesToTheEndOfTheLogHasFailed) {
  WriteTextFile(folder_ / "serial.csv", "ALARM:7\n");
  WriteTextFile(folder_ / "logic.csv", "time_s,fault,ena,in1,in2\n0,0,1,1,0\n1,1,1,1,0\n2,1,1,1,0\n");
  WriteBench({kWiper + "serial.csv,logic.csv,0.1"});
  EXPECT_EQ(Wiper().verdict, BenchVerdict::kFailed);
  WriteTextFile(folder_ / "logic.csv", "time_s,fault,ena,in1,in2\n0,0,1,1,0\n");
  EXPECT_THAT([&] { Wiper(); }, ThrowsMessage<Error>(HasSubstr("the channel 'fault' is never high")));
}

TEST_F(BenchValidationTest, NothingIsPassedThatIsNotThere) {
  WriteBench({});
  const BenchReport report = actuator::ValidateBench(folder_.Path());
  EXPECT_EQ(report.Count(BenchVerdict::kMissing),
            static_cast<int>(actuator::BenchFaults().size() * actuator::BenchStates().size()) + 1);
  WriteBench({"wiper_gone,\"running, extending\",,,,,,,"});
  EXPECT_THAT([&] { actuator::ValidateBench(folder_.Path()); },
              ThrowsMessage<Error>(HasSubstr("no fault 'wiper_gone'")));
}

TEST_F(BenchValidationTest, EnduranceIs24HoursWithoutAnAlarm) {
  for (const auto& [last_s, alarm, verdict] : {std::tuple{86'401.0, "", BenchVerdict::kPassed},
                                               {86'000.0, "", BenchVerdict::kFailed},
                                               {86'401.0, "ALARM:8\n", BenchVerdict::kFailed}}) {
    WriteTextFile(folder_ / "day.csv", fmt::format("0.000,300\n{}{:.3f},300\n", alarm, last_s));
    WriteBench({"endurance,\"a program, over and over\",,,,,day.csv,,"});
    EXPECT_EQ(actuator::ValidateBench(folder_.Path()).findings.back().verdict, verdict) << last_s << alarm;
  }
}

TEST_F(BenchValidationTest, ThePlanIsWhatItReads) {
  actuator::WriteBenchPlan(folder_ / "bench.csv");
  const CsvTable plan = CsvTable::Read(folder_ / "bench.csv");
  EXPECT_EQ(plan.Rows(), actuator::BenchFaults().size() * actuator::BenchStates().size() + 1);
  EXPECT_EQ(actuator::ValidateBench(folder_.Path()).Count(BenchVerdict::kPassed), 0);
}

actuator::FirmwareOptions Everything() {
  actuator::FirmwareOptions options;
  options.feedback = actuator::Feedback::kPotentiometer, options.potentiometer = {0, 240, 1023, 380};
  options.supply_v = 12, options.current_sense = true, options.bridge_sense = true;
  options.pins.safety_relay = 5, options.pins.in1 = 6;
  options.worn = true, options.speed_limit_mm_s = 6;
  options.force_limit_n = 400, options.force_n_per_a = 250, options.idle_a = 0.3;
  return options;
}

TEST(Commissioning, TheSchematicHasThisSketchsPins) {
  const std::string all = actuator::SchematicSvg(Everything());
  for (const char* part : {"<svg", ">D9<", ">D6<", ">D8<", ">D5<", ">A3<", ">A4<", "fuse 1.9 A", "emergency stop",
                           "safety relay", "hold-to-run", "Not tried on a board"})
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
                             HasSubstr("ENA's jumper removed"), Not(HasSubstr("hold-to-run"))));
  options = Everything();
  EXPECT_THAT(sheet(), AllOf(HasSubstr("ALARM:16"), HasSubstr("ALARM:12 below 400 N"), HasSubstr("hold-to-run"),
                             Not(HasSubstr("emergency stop: released"))));
}

// What the sketch's folder has of safety is what the project says.
TEST(Commissioning, TheSketchHasSafetyAndRisks) {
  std::set<std::string> names;
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources(actuator::Board::kUno)) names.insert(file.name);
  EXPECT_TRUE(names.contains("SAFETY.md") && names.contains("RISKS.md"));
}

}  // namespace
}  // namespace lake
