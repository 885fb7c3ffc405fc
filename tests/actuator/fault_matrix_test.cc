// Every single fault in every state, with everything wired: what is told, how far the rod goes, and
// whether anything is dangerous. The whole matrix makes libs/design/actuator/RISKS.md:
//   LAKE_LONG_TESTS=1 LAKE_RISKS=libs/design/actuator/RISKS.md build/test/bin/lake_actuator_test
//   --gtest_filter='FaultMatrix*'
// Without LAKE_LONG_TESTS every ninth case is tried. Each is compared with what RISKS.md says.
#include <fmt/format.h>

#include <cstdlib>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "host/host_states.h"
#include "lake/core/atomic_file.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kStopWay_mm = 0.3;        // after a stop, whatever is broken: coasting from 5 mm/s takes 0.13
constexpr double kFailedBridgeWay_mm = 1;  // where the bridge drives by itself: the relay opens 10 ms after the stop
                                           // has found it out, and the motor coasts from full speed
constexpr double kFailedBridgeTold_s = 0.085;  // then: the relay opens within 100 ms of the fault

// A single fault, and what is to be seen of it in whatever state it comes: the numbers are those of RISKS.md, rounded
// up.
struct SingleFault {
  std::string name;       // "in1_open"
  std::string how;        // it is made
  std::vector<int> told;  // ALARM numbers, any of them; empty: it need not be told, since nothing moves by it
  double way_mm = 0;      // that the rod may go meanwhile, with what was asked for until the fault is told
  Act make;
};

const std::vector<SingleFault>& SingleFaults() {
  using B = RigBreaks;
  using enum Wire;
  static const auto supply = [](double part) -> Act {
    return [=](HostRig& rig) { rig.Actuator().supply = [part](double) { return part; }; };
  };
  static const std::vector<int> kStill = {8, 11, 13, 15}, kMoves = {8, 9, 11, 13, 15}, kStops = {1, 2, 5},
                                kShorted = {8, 9, 10, 11, 12, 15};
  static const std::vector<SingleFault> faults = {
      {"none", "nothing is broken: a stop alone", {}, 0.5, [](HostRig&) {}},
      {"ena_open", "ENA's wire off at the UNO", kStill, 0.5, Breaks(&B::ena, kOpen)},
      {"ena_ground", "ENA's wire at ground", kStill, 0.5, Breaks(&B::ena, kGround)},
      {"ena_5v", "ENA's jumper on, or its wire at 5 V", {8, 9, 10, 11, 15}, 7, Breaks(&B::ena, kFive)},
      {"in1_open", "IN1's wire off at the UNO", kMoves, 7, Breaks(&B::in1, kOpen)},
      {"in1_ground", "IN1's wire at ground", kStill, 7, Breaks(&B::in1, kGround)},
      {"in1_5v", "IN1's wire at 5 V", kMoves, 7, Breaks(&B::in1, kFive)},
      {"in2_open", "IN2's wire off at the UNO", kMoves, 7, Breaks(&B::in2, kOpen)},
      {"in2_ground", "IN2's wire at ground", kStill, 7, Breaks(&B::in2, kGround)},
      {"in2_5v", "IN2's wire at 5 V", kMoves, 7, Breaks(&B::in2, kFive)},
      {"retract_wire", "the retract end stop's wire off", kStops, 2.5, PullsWires(true, false)},
      {"extend_wire", "the extend end stop's wire off", kStops, 2.5, PullsWires(false, true)},
      {"both_wires", "both end stops' wires off", {2}, 0.5, PullsWires(true, true)},
      {"retract_shorted",
       "the retract end stop's wire at ground",
       {4, 12},
       8,
       [](HostRig& rig) { rig.Actuator().retract_stop_mm = -1000; }},
      {"supply_off", "the emergency stop pressed", {6, 8, 11, 12, 13}, 0.5, supply(0)},
      {"supply_low", "the supply at half its voltage", {6}, 0.5, supply(0.5)},
      {"supply_high", "the supply at one and a half times its voltage", {6}, 0.5, supply(1.5)},
      {"supply_sense", "the wire of A2 off", {6, 16}, 0.5, Breaks(&B::supply_wire, true)},
      {"wiper_lost", "the wire of A0 off", {7}, 0.5, Breaks(&B::wiper, B::Wiper::kLost)},
      {"wiper_shorted", "A0 at 5 V", {7}, 0.5, Breaks(&B::wiper, B::Wiper::kShorted)},
      {"wiper_frozen",
       "the wiper's wire at a fixed voltage",
       {1, 4, 7, 8, 9, 10, 11},
       6,
       Breaks(&B::wiper, B::Wiper::kFrozen)},
      {"current_sense", "the wire of A1 off", {12}, 0.5, Breaks(&B::current_wire, true)},
      {"short", "the motor's leads shorted", {12}, 0.5, [](HostRig& rig) { rig.Actuator().idle_a = 6; }},
      {"motor_unplugged", "one of the motor's leads off", {8, 11, 13}, 0.5, Breaks(&B::is_motor_unplugged, true)},
      {"blocked", "the rod held", {8, 11, 12}, 0.5, Breaks(&B::is_blocked, true)},
      {"shorted_extend",
       "the bridge has failed and extends, whatever its inputs are: OUT1 at the supply, OUT2 at ground", kShorted, 1,
       Breaks(&B::shorted, 1)},
      {"shorted_retract", "the bridge has failed and retracts: OUT2 at the supply, OUT1 at ground", kShorted, 1,
       Breaks(&B::shorted, -1)},
      {"relay_welded", "the safety relay's contact bridged", {16}, 3, Breaks(&B::is_relay_welded, true)},
      {"host_silent", "the USB cable out", {}, 10, [](HostRig& rig) { rig.KeepTalking(false); }},
      {"main_hangs",
       "the main loop hangs (a firmware with LAKE_SIMULATOR)",
       {},
       2,
       [](HostRig& rig) { rig.Hang(true); }},
      {"current_offset", "the current sensor 30 mV off", {}, 0.5, Breaks(&B::current_offset_v, 0.03)},
  };
  return faults;
}

// What one fault in one state came to.
struct Found {
  int alarm = 0;       // 0: none was told
  double told_s = 0;   // after the fault
  double way_mm = 0;   // from the fault to the rest after what was told
  double stop_mm = 0;  // after a stop
  std::string danger;  // empty: none
};

class FaultMatrixTest : public HostStatesTest {
 protected:
  void SetUp() override {
    WireAll(firmware_options_);
    firmware_options_.extend_stop_mm = 0.7;
    actuator_.noise_counts = 0.5;
    actuator_.has_relay = true;
    actuator_.extend_stop_mm = 374.5205 - 0.7;
  }

  // Of the samples from there on: past the linkage's ends, or driven into an end stop that is pressed.
  std::string Danger(std::size_t from, int most_driven_ms) const {
    int driven_ms = 0;
    for (std::size_t i = from; i < rig_->Samples().size(); ++i) {
      const RigSample& sample = rig_->Samples()[i];
      if (sample.stroke_mm > schedule_.limits.upper_end_mm || sample.stroke_mm < schedule_.limits.lower_end_mm)
        return fmt::format("at {:.3f} mm, past the linkage's end", sample.stroke_mm);
      const bool into_stop = (sample.motor_duty > 0 && sample.stroke_mm >= actuator_.extend_stop_mm) ||
                             (sample.motor_duty < 0 && sample.stroke_mm <= rig_->Actuator().retract_stop_mm);
      driven_ms = into_stop ? driven_ms + 1 : 0;
      if (driven_ms > most_driven_ms)
        return fmt::format("driven into a pressed end stop at {:.3f} mm", sample.stroke_mm);
    }
    return {};
  }

  double WayFrom(std::size_t from) const {
    double way = 0;
    for (std::size_t i = from; i < rig_->Samples().size(); ++i)
      way = std::max(way, std::abs(rig_->Samples()[i].stroke_mm - rig_->Samples()[from].stroke_mm));
    return way;
  }

  Found Try(const std::string& state, const Act& make, bool drives_by_itself) {
    Reach(state);
    Found found;
    if (HasFatalFailure()) return found;
    const std::size_t from = rig_->Samples().size() - 1;
    const double since_s = rig_->Time();
    make(*rig_);
    if (rig_->RunUntil("ALARM:", 2)) {
      found.told_s = rig_->Time() - since_s;
      rig_->Run(0.002);
      found.alarm = std::atoi(rig_->Serial().c_str() + rig_->Serial().find("ALARM:") + 6);
      rig_->Run(0.3);
      found.way_mm = WayFrom(from);
    }
    const std::size_t stopped = rig_->Samples().size();
    rig_->SendNow('!');
    rig_->Run(0.6);
    found.stop_mm = WayFrom(stopped + 1);  // it acts with the next tick
    // What a user would try.
    for (const char* line : {"reset", "home", "run", "jog 400 800", "jog -400 800", "reset", "home"})
      rig_->Send(line), rig_->Run(1);
    found.danger = Danger(from, drives_by_itself ? 120 : 3);
    if (found.danger.empty() && found.stop_mm > (drives_by_itself ? kFailedBridgeWay_mm : kStopWay_mm))
      found.danger = fmt::format("{:.2f} mm after a stop", found.stop_mm);
    return found;
  }
};

// One row of the risk table: the worst of all states.
struct Risk {
  std::set<int> alarms;
  int states = 0, told = 0, dangers = 0;
  double told_s = 0, way_mm = 0, stop_mm = 0;

  void Add(const Found& found) {
    ++states;
    dangers += !found.danger.empty();
    stop_mm = std::max(stop_mm, found.stop_mm);
    if (found.alarm == 0) return;
    ++told;
    alarms.insert(found.alarm);
    told_s = std::max(told_s, found.told_s), way_mm = std::max(way_mm, found.way_mm);
  }
};

// A row of it, as RISKS.md has it.
std::string RiskRow(const SingleFault& fault, const Risk& risk) {
  const std::string alarms = fmt::format("{}", fmt::join(risk.alarms, ", "));
  return fmt::format("| `{}` | {} | {} | {} of {} | {} | {} | {:.2f} mm | {} |", fault.name, fault.how,
                     alarms.empty() ? "–" : alarms, risk.told, risk.states,
                     risk.told ? fmt::format("{:.3f} s", risk.told_s) : "–",
                     risk.told ? fmt::format("{:.2f} mm", risk.way_mm) : "–", risk.stop_mm, risk.dangers);
}

std::string RiskTable(const std::vector<std::pair<SingleFault, Risk>>& risks) {
  std::string text = fmt::format(
      "# Risks of each single fault\n\n**None of this has been tried on a board: nobody may wear it.** In the form of "
      "ISO 14971, the hazardous "
      "situation, how it is detected, and the residual travel of the rod: what a person's leg would be moved by. "
      "Severity is "
      "not judged here; a laboratory that puts a person into the exoskeleton does, and measures the same rows on its "
      "bench "
      "([BENCH.md](BENCH.md)). Made by `FaultMatrixTest` (`tests/actuator/fault_matrix_test.cc`): the portable "
      "firmware with everything wired and a model of the plant, each fault in each of {} states; each column has the "
      "worst "
      "of them. The rod's way includes what was asked for until the fault is told. Dangerous is: past the linkage's "
      "end, driven into a pressed end stop, or more than {} mm after a stop, {} mm where the bridge itself has "
      "failed.\n\n"
      "| fault | how | ALARM | reported in | within | rod goes | after a stop | dangerous |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
      States().size(), kStopWay_mm, kFailedBridgeWay_mm);
  for (const auto& [fault, risk] : risks) text += RiskRow(fault, risk) + "\n";
  return text +
         "\nWhere a fault is not told nothing moves by it in that state, or it is told when something is to move next: "
         "what "
         "was asked for goes on or ends as planned, and the columns of danger hold all the same.\n";
}

// What RISKS.md says of a fault: its row, and the numbers of it.
struct Said {
  std::string row;
  std::set<int> alarms;
  double told_s = 0, way_mm = 0, stop_mm = 0;
};

std::map<std::string, Said> SaidRisks() {
  std::map<std::string, Said> said;
  std::istringstream lines(ReadTextFile(SourceDir() / "libs/design/actuator/RISKS.md"));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    for (std::size_t begin = 2, end = 0; (end = line.find(" |", begin)) != std::string::npos; begin = end + 3)
      cells.push_back(line.substr(begin, end - begin));
    const auto number = [&](std::size_t cell) { return std::atof(cells.at(cell).c_str()); };  // of "–": 0
    Said& one = said[cells.at(0).substr(1, cells[0].size() - 2)];
    one = {.row = line, .alarms = {}, .told_s = number(4), .way_mm = number(5), .stop_mm = number(6)};
    std::istringstream alarms(cells.at(2));
    for (std::string alarm; std::getline(alarms, alarm, ',');) one.alarms.insert(std::atoi(alarm.c_str()));
  }
  return said;
}

// Half of the last digit that it has; some of the states have no more than all of them.
void ExpectWithin(const Risk& found, const Said& said) {
  for (const int alarm : found.alarms) EXPECT_TRUE(said.alarms.contains(alarm)) << alarm << " not in " << said.row;
  EXPECT_LE(found.told_s, said.told_s + 0.0005) << said.row;
  EXPECT_LE(found.way_mm, said.way_mm + 0.005) << said.row;
  EXPECT_LE(found.stop_mm, said.stop_mm + 0.005) << said.row;
}

TEST_F(FaultMatrixTest, NoSingleFaultInAnyStateIsDangerous) {
  const bool all = std::getenv("LAKE_LONG_TESTS") != nullptr;
  const char* const file = std::getenv("LAKE_RISKS");
  const std::map<std::string, Said> said = SaidRisks();
  EXPECT_EQ(said.size(), SingleFaults().size());
  std::vector<std::pair<SingleFault, Risk>> risks;
  std::size_t number = 0;
  for (const SingleFault& fault : SingleFaults()) {
    Risk risk;
    for (const std::string& state : States()) {
      if (!all && number++ % 9 != 0) continue;
      const bool drives_by_itself = fault.name.starts_with("shorted_");
      const Found found = Try(state, fault.make, drives_by_itself);
      ASSERT_FALSE(HasFatalFailure()) << fault.name << ", " << state;
      risk.Add(found);
      EXPECT_EQ(found.danger, "") << fault.name << ", " << state;
      if (found.alarm == 0) continue;
      EXPECT_THAT(fault.told, testing::Contains(found.alarm)) << fault.name << ", " << state;
      EXPECT_LE(found.way_mm, fault.way_mm) << fault.name << ", " << state;
      if (drives_by_itself) {
        EXPECT_LE(found.told_s, kFailedBridgeTold_s) << fault.name << ", " << state;
      }
    }
    if (!file) ExpectWithin(risk, said.at(fault.name));
    if (!file && all) {
      EXPECT_EQ(RiskRow(fault, risk), said.at(fault.name).row);
    }
    risks.emplace_back(fault, risk);
  }
  if (file && all) WriteTextFile(file, RiskTable(risks));
}

}  // namespace
}  // namespace lake
