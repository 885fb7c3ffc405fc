// The results of a cohort's studies: a row per repetition, a row per whole result, and curves over the rise.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lake/gait/movement.h"

namespace lake::cohort {

constexpr int kPercents = 101;
using Curve = std::array<double, kPercents>;  // over 0 … 100 %; NaN where not known

struct GroupRow {
  std::string participant, session, run;
  std::string trial;              // human, exo, comparison, design
  std::optional<int> repetition;  // absent: of the whole trial
  std::map<std::string, double> values;
};

struct GroupCurve {
  std::string participant;
  std::string trial;     // human, exo, comparison
  std::string quantity;  // knee_deg, …
  Curve values;
};

struct GroupData {
  gait::MovementKind movement = gait::MovementKind::kSitToStand;  // of the last trial
  std::vector<GroupRow> rows;
  std::vector<GroupCurve> curves;       // one per repetition; of comparisons one per recordings
  std::vector<std::string> quantities;  // of the rows, each once, in the order of the tables
};

// The results of one study.
struct DoneStudy {
  std::string participant, session, run;
  std::filesystem::path folder;
  std::set<std::string> steps;  // that have been done
  bool has_redesign = false;    // a design for the person is among its steps, done or not
};

// Throws Error for a table that cannot be read.
GroupData ReadGroup(const std::vector<DoneStudy>& studies);

// The mean of what is known of one quantity: over repetitions, runs and, if none is named, sessions; nullopt if nothing
// is known.
std::optional<double> ValueOf(const GroupData& group, const std::string& participant, const std::string& trial,
                              const std::string& quantity, const std::optional<std::string>& session = {});

std::vector<std::string> ParticipantsOf(const GroupData& group);

}  // namespace lake::cohort
