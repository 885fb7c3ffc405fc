// Whether a prototype on the bench does in each single fault what the simulator's does: the plan of the tests, and the
// verdict on what a laboratory has logged.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lake::actuator {

// A single fault, and what is to be seen of it in whatever state it comes.
struct BenchFault {
  std::string name;       // "in1_open"
  std::string how;        // is it made
  std::vector<int> told;  // ALARM numbers, any of them; empty: it need not be told, since nothing moves by it
  double off_s = 0;       // after which the bridge must not drive any more; of faults that are told
  double way_mm = 0;      // that the rod may go meanwhile, and after a stop
};

// Every single fault of the plan.
const std::vector<BenchFault>& BenchFaults();

// The states in which each is made.
const std::vector<std::string>& BenchStates();

// How long the prototype has to run without one.
inline constexpr double kEndurance_s = 24 * 3600;

// One line of the laboratory's list, bench.csv: which fault in which state, its logs, what was measured.
struct BenchCase {
  std::string fault, state;
  std::filesystem::path serial = {};  // of lake-stroke talk or run
  std::filesystem::path logic = {};   // of a logic analyser: time_s,fault,ena,in1,in2, a row per change
  std::optional<double> way_mm = {};  // of the rod, from the fault to its rest
};

enum class BenchVerdict { kPassed, kFailed, kMissing };

struct BenchFinding {
  BenchCase found;
  BenchVerdict verdict = BenchVerdict::kMissing;
  std::optional<int> alarm = {};
  std::optional<double> off_s = {};  // from the fault to the bridge's last drive
  std::string why = {};              // it has failed, or is missing
};

struct BenchReport {
  std::vector<BenchFinding> findings;  // of every fault in every state, in the plan's order; then of the endurance
  double endurance_s = 0;              // the longest log without an alarm
  int Count(BenchVerdict verdict) const;
};

// The plan as an empty bench.csv to fill in.
void WriteBenchPlan(const std::filesystem::path& file);

// Reads bench.csv of the folder and the logs that it names, relative to it. Throws Error: no such file, a fault or a
// state that the plan does not have, a log that cannot be read.
BenchReport ValidateBench(const std::filesystem::path& folder);

void WriteBenchReport(const std::filesystem::path& file, const BenchReport& report);

}  // namespace lake::actuator
