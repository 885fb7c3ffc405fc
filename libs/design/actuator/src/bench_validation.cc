#include "lake/actuator/bench_validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::actuator {
namespace {

constexpr const char* kEndurance = "endurance";

const BenchFault* FindFault(const std::string& name) {
  const auto found = std::ranges::find(BenchFaults(), name, &BenchFault::name);
  return found == BenchFaults().end() ? nullptr : &*found;
}

std::filesystem::path LogOf(const std::filesystem::path& folder, const std::string& cell) {
  return cell.empty() ? std::filesystem::path() : folder / cell;
}

std::vector<BenchCase> ReadCases(const std::filesystem::path& folder) {
  const CsvTable table = CsvTable::Read(folder / "bench.csv");
  const std::size_t fault = table.Column("fault"), state = table.Column("state"), serial = table.Column("serial"),
                    logic = table.Column("logic"), way = table.Column("way_mm");
  std::vector<BenchCase> cases;
  for (std::size_t i = 0; i < table.Rows(); ++i) {
    BenchCase one{.fault = table.Text(i, fault),
                  .state = table.Text(i, state),
                  .serial = LogOf(folder, table.Text(i, serial)),
                  .logic = LogOf(folder, table.Text(i, logic)),
                  .way_mm = table.Number(i, way)};
    if (one.fault != kEndurance && !FindFault(one.fault))
      throw Fail("{}: the plan has no fault '{}'; lake-stroke validate-bench without a folder writes the plan",
                 table.Where(i), one.fault);
    if (one.fault != kEndurance && std::ranges::find(BenchStates(), one.state) == BenchStates().end())
      throw Fail("{}: the plan has no state '{}'; lake-stroke validate-bench without a folder writes the plan",
                 table.Where(i), one.state);
    cases.push_back(std::move(one));
  }
  return cases;
}

// What lake-stroke has logged: rows of the firmware, and ALARM:N among them or as the state "fault".
struct SerialLog {
  std::optional<int> alarm;
  double from_s = NAN, to_s = NAN;

  double Duration() const { return to_s > from_s ? to_s - from_s : 0; }
};

SerialLog ReadSerial(const std::filesystem::path& file) {
  constexpr std::string_view kAlarm = "ALARM:";
  SerialLog log;
  std::istringstream lines(ReadTextFile(file));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kAlarm) && !log.alarm) {
      int number = 0;
      std::from_chars(line.data() + kAlarm.size(), line.data() + line.size(), number);
      log.alarm = number;
    }
    const std::optional<double> time_s = ParseNumber(line.substr(0, line.find(',')));
    if (!time_s || line.find(',') == std::string::npos) continue;
    if (std::isnan(log.from_s)) log.from_s = *time_s;
    log.to_s = *time_s;
  }
  return log;
}

// From the first time that the channel `fault` is high to the last at which the bridge drives: ENA high, its inputs
// different. None if the bridge does not drive after the fault.
std::optional<double> DriveAfterFault(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::Read(file);
  const std::size_t time = table.Column("time_s"), fault = table.Column("fault"), ena = table.Column("ena"),
                    in1 = table.Column("in1"), in2 = table.Column("in2");
  std::optional<double> since_s, last_s;
  bool drove = false;
  double before_s = -INFINITY;
  for (std::size_t i = 0; i < table.Rows(); ++i) {
    const double now_s = table.RequiredNumber(i, time);
    if (!(now_s > before_s)) throw Fail("{}: the times must ascend", table.Where(i));
    before_s = now_s;
    const auto level = [&](std::size_t column) { return table.RequiredNumber(i, column) > 0.5; };
    if (since_s && drove) last_s = now_s;
    if (!since_s && level(fault)) since_s = now_s;
    drove = level(ena) && level(in1) != level(in2);
  }
  if (!since_s) throw Fail("{}: the channel 'fault' is never high: when was the fault made?", file.string());
  if (drove) return INFINITY;
  if (!last_s) return std::nullopt;
  return *last_s - *since_s;
}

// What the logs contradict of what is wanted; empty if nothing.
std::string Contradiction(const BenchFault& wanted, const BenchFinding& finding) {
  if (finding.alarm && std::ranges::find(wanted.told, *finding.alarm) == wanted.told.end())
    return fmt::format("ALARM:{} was told, which this fault does not give", *finding.alarm);
  if (!finding.alarm && !wanted.told.empty()) return "no ALARM was told";
  if (finding.off_s && !wanted.told.empty() && *finding.off_s > wanted.off_s)
    return fmt::format("the bridge drove for {:.3f} s, at most {:.3f} are allowed", *finding.off_s, wanted.off_s);
  if (finding.found.way_mm && std::abs(*finding.found.way_mm) > wanted.way_mm)
    return fmt::format("the rod went {:.2f} mm, at most {:.2f} are allowed", *finding.found.way_mm, wanted.way_mm);
  return {};
}

BenchFinding Judge(const BenchFault& wanted, const BenchCase& found) {
  BenchFinding finding{.found = found};
  if (found.serial.empty() || found.logic.empty() || !found.way_mm) {
    finding.why = "the serial log, the analyser's or the rod's way is missing";
    return finding;
  }
  finding.alarm = ReadSerial(found.serial).alarm;
  finding.off_s = DriveAfterFault(found.logic);
  finding.why = Contradiction(wanted, finding);
  finding.verdict = finding.why.empty() ? BenchVerdict::kPassed : BenchVerdict::kFailed;
  return finding;
}

BenchFinding JudgeEndurance(const std::vector<BenchCase>& cases, double& longest_s) {
  BenchFinding finding{.found = {.fault = kEndurance, .state = "a program, over and over"}};
  finding.why = "no log";
  for (const BenchCase& one : cases) {
    if (one.fault != kEndurance || one.serial.empty()) continue;
    const SerialLog log = ReadSerial(one.serial);
    finding.found = one;
    finding.alarm = log.alarm;
    if (!log.alarm) longest_s = std::max(longest_s, log.Duration());
    finding.verdict = longest_s >= kEndurance_s ? BenchVerdict::kPassed : BenchVerdict::kFailed;
    finding.why = longest_s >= kEndurance_s ? "" : fmt::format("{:.1f} h without an alarm of 24", longest_s / 3600);
  }
  return finding;
}

const char* NameOf(BenchVerdict verdict) {
  switch (verdict) {
    case BenchVerdict::kPassed:
      return "passed";
    case BenchVerdict::kFailed:
      return "failed";
    case BenchVerdict::kMissing:
      break;
  }
  return "missing";
}

std::string NumbersOf(const std::vector<int>& told) {
  return fmt::format("{}", fmt::join(told, " "));
}

}  // namespace

// The times and ways are those of the simulator's tests (RISKS.md), rounded up. A way includes what was asked for until
// the fault is told.
const std::vector<BenchFault>& BenchFaults() {
  static const std::vector<BenchFault> faults = {
      {"none", "nothing is broken: a stop alone", {}, 0, 0.5},
      {"ena_open", "ENA's wire off at the UNO", {8, 11, 13, 15}, 1.5, 0.5},
      {"ena_ground", "ENA's wire at ground", {8, 11, 13, 15}, 1.5, 0.5},
      {"ena_5v", "ENA's jumper on, or its wire at 5 V", {8, 9, 10, 11, 15}, 1.5, 7},
      {"in1_open", "IN1's wire off at the UNO", {8, 9, 11, 13, 15}, 2, 7},
      {"in1_ground", "IN1's wire at ground", {8, 11, 13, 15}, 2, 7},
      {"in1_5v", "IN1's wire at 5 V", {8, 9, 11, 13, 15}, 2, 7},
      {"in2_open", "IN2's wire off at the UNO", {8, 9, 11, 13, 15}, 2, 7},
      {"in2_ground", "IN2's wire at ground", {8, 11, 13, 15}, 2, 7},
      {"in2_5v", "IN2's wire at 5 V", {8, 9, 11, 13, 15}, 2, 7},
      {"retract_wire", "the retract end stop's wire off", {1, 2, 5}, 1.5, 2.5},
      {"extend_wire", "the extend end stop's wire off", {1, 2, 5}, 1.5, 2.5},
      {"both_wires", "both end stops' wires off", {2}, 0.3, 0.5},
      {"retract_shorted", "the retract end stop's wire at ground", {4, 12}, 5, 8},
      {"supply_off", "the emergency stop pressed", {6, 8, 11, 12, 13}, 0.05, 0.5},
      {"supply_low", "the supply at half its voltage", {6}, 0.05, 0.5},
      {"supply_high", "the supply at one and a half times its voltage", {6}, 0.05, 0.5},
      {"supply_sense", "the wire of A2 off", {6, 16}, 0.05, 0.5},
      {"wiper_lost", "the wire of A0 off", {7}, 0.05, 0.5},
      {"wiper_shorted", "A0 at 5 V", {7}, 0.05, 0.5},
      {"wiper_frozen", "the wiper's wire at a fixed voltage", {1, 4, 7, 8, 9, 10, 11}, 2, 6},
      {"current_sense", "the wire of A1 off", {12}, 0.05, 0.5},
      {"short", "the motor's leads shorted", {12}, 0.3, 0.5},
      {"motor_unplugged", "one of the motor's leads off", {8, 11, 13}, 1.5, 0.5},
      {"blocked", "the rod held", {8, 11, 12}, 2, 0.5},
      {"shorted_extend",
       "the bridge has failed and extends, whatever it is told: OUT1 at the supply, OUT2 at ground",
       {8, 9, 10, 11, 12, 15},
       0.1,
       1},
      {"shorted_retract",
       "the bridge has failed and retracts: OUT2 at the supply, OUT1 at ground",
       {8, 9, 10, 11, 12, 15},
       0.1,
       1},
      {"relay_welded", "the safety relay's contact bridged", {16}, 1.5, 3},
      {"host_silent", "the USB cable out", {}, 0, 10},
      {"main_hangs", "the main loop hangs (a firmware with LAKE_SIMULATOR)", {}, 0, 2},
      {"current_offset", "the current sensor 30 mV off", {}, 0, 0.5},
  };
  return faults;
}

const std::vector<std::string>& BenchStates() {
  static const std::vector<std::string> states = {"idle, stroke unknown",
                                                  "idle, at the start",
                                                  "homing, seeking",
                                                  "homing, backing off",
                                                  "homing, coming again",
                                                  "positioning",
                                                  "running, extending",
                                                  "running, resting",
                                                  "running, retracting",
                                                  "running, at the upper limit",
                                                  "hold",
                                                  "jogging, extending",
                                                  "jogging, retracting",
                                                  "worn, extending"};
  return states;
}

int BenchReport::Count(BenchVerdict verdict) const {
  return static_cast<int>(std::ranges::count(findings, verdict, &BenchFinding::verdict));
}

void WriteBenchPlan(const std::filesystem::path& file) {
  CsvWriter csv({"fault", "state", "how", "alarms", "most_off_s", "most_way_mm", "serial", "logic", "way_mm"});
  for (const BenchFault& fault : BenchFaults())
    for (const std::string& state : BenchStates())
      csv.AddRow(fault.name, state, fault.how, NumbersOf(fault.told), fault.off_s, fault.way_mm, "", "", NAN);
  csv.AddRow(kEndurance, "a program, over and over", "24 h, home and run", "", NAN, NAN, "", "", NAN);
  csv.Write(file);
}

BenchReport ValidateBench(const std::filesystem::path& folder) {
  const std::vector<BenchCase> cases = ReadCases(folder);
  BenchReport report;
  for (const BenchFault& fault : BenchFaults())
    for (const std::string& state : BenchStates()) {
      const auto is_it = [&](const BenchCase& one) { return one.fault == fault.name && one.state == state; };
      const auto found = std::ranges::find_if(cases, is_it);
      report.findings.push_back(
          Judge(fault, found == cases.end() ? BenchCase{.fault = fault.name, .state = state} : *found));
    }
  report.findings.push_back(JudgeEndurance(cases, report.endurance_s));
  return report;
}

void WriteBenchReport(const std::filesystem::path& file, const BenchReport& report) {
  CsvWriter csv({"fault", "state", "verdict", "alarm", "off_s", "way_mm", "why"});
  for (const BenchFinding& finding : report.findings)
    csv.AddRow(finding.found.fault, finding.found.state, NameOf(finding.verdict),
               finding.alarm ? std::to_string(*finding.alarm) : "", finding.off_s, finding.found.way_mm, finding.why);
  csv.Write(file);
}

}  // namespace lake::actuator
