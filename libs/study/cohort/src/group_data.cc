#include "lake/cohort/group_data.h"

#include <algorithm>
#include <cmath>

#include "lake/compare/decomposition.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/gait/squats.h"
#include "lake/motion/leg_motion.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

struct Angle {
  const char* name;
  double motion::LegSample::*field;
};
constexpr std::array kAngles = {
    Angle{"knee_deg", &motion::LegSample::knee_deg}, Angle{"trunk_deg", &motion::LegSample::trunk_deg},
    Angle{"thigh_deg", &motion::LegSample::thigh_deg}, Angle{"shank_deg", &motion::LegSample::shank_deg}};

// The samples of one rise, from onset to standing.
using Rise = std::vector<const motion::LegSample*>;

std::map<int, Rise> RisesOf(const motion::LegMotion& leg) {
  std::map<int, Rise> rises;
  for (const motion::LegSample& sample : leg.samples)
    if (sample.repetition && std::isfinite(sample.percent)) rises[*sample.repetition].push_back(&sample);
  return rises;
}

double Largest(const Rise& rise, double motion::LegSample::*field, double sign = 1) {
  double largest = kNaN;
  for (const motion::LegSample* sample : rise)
    if (const double value = sign * (sample->*field); !(value <= largest) && std::isfinite(value)) largest = value;
  return sign * largest;
}

// Straight between samples; at the ends the nearest sample, which is less than a frame away.
Curve OverPercent(const Rise& rise, double motion::LegSample::*field) {
  Curve curve;
  std::size_t next = 0;
  for (int percent = 0; percent < kPercents; ++percent) {
    while (next < rise.size() && rise[next]->percent < percent) ++next;
    const motion::LegSample& right = *rise[std::min(next, rise.size() - 1)];
    const motion::LegSample& left = *rise[next == 0 ? 0 : next - 1];
    const double span = right.percent - left.percent;
    const double part = span > 0 ? std::clamp((percent - left.percent) / span, 0.0, 1.0) : 0;
    curve[static_cast<std::size_t>(percent)] = (1 - part) * left.*field + part * right.*field;
  }
  return curve;
}

// The quantities of rows, in the order in which they first appear.
class ResultTable {
 public:
  ResultTable(GroupData& group, const DoneStudy& of) : group_(group), of_(of) {}

  void Set(gait::MovementKind movement) { group_.movement = movement; }
  void Begin(const std::string& trial, std::optional<int> repetition) {
    group_.rows.push_back({of_.participant, of_.session, of_.run, trial, repetition, {}});
  }
  void Add(const std::string& quantity, double value) {
    if (!std::isfinite(value)) return;
    group_.rows.back().values[quantity] = value;
    auto& known = group_.quantities;
    if (std::find(known.begin(), known.end(), quantity) == known.end()) known.push_back(quantity);
  }
  void AddCurve(const std::string& trial, const std::string& quantity, const Curve& curve) {
    group_.curves.push_back({of_.participant, trial, quantity, curve});
  }

 private:
  GroupData& group_;
  const DoneStudy& of_;
};

// The columns of a movement's table that are no times of the recording.
template <typename Row>
std::vector<std::string> ColumnsOf() {
  std::vector<std::string> columns;
  for (const gait::Field<Row>& field : Row::Fields())
    if (field.kind != gait::FieldKind::kMoment) columns.push_back(field.Column(motion::LengthUnit::kMm));
  return columns;
}

// What a trial's movement left: a row a repetition.
struct MeasuredTable {
  gait::MovementKind movement;
  std::vector<std::string> columns;
  CsvTable table;
};

MeasuredTable ReadMeasured(const fs::path& folder) {
  using enum gait::MovementKind;
  for (auto& [movement, columns, file] : {std::tuple{kWalking, ColumnsOf<gait::GaitCycle>(), "gait_cycles.csv"},
                                          {kSquat, ColumnsOf<gait::Squat>(), "squats.csv"}})
    if (fs::exists(folder / file)) return {movement, columns, CsvTable::Read(folder / file)};
  return {kSitToStand, ColumnsOf<gait::SitToStand>(), CsvTable::Read(folder / "sit_to_stand.csv")};
}

// The durations, angles, speeds and powers of one row; NaN where it has none.
std::map<std::string, double> RowOf(const MeasuredTable& measured, const std::string& repetition) {
  std::map<std::string, double> values;
  const CsvTable& table = measured.table;
  for (const std::string& column : measured.columns) {
    values[column] = kNaN;
    for (std::size_t row = 0; row < table.Rows(); ++row)
      if (table.Has(column) && table.Text(row, 0) == repetition)
        values[column] = table.Number(row, table.Column(column)).value_or(kNaN);
  }
  return values;
}

// The centre of mass's row of one rise in momentum.csv, without what sit_to_stand.csv has: loads are of the human trial
// alone, of a stature that may have been given, and both trials are to be compared.
void AddMomentum(const CsvTable& momenta, const CsvTable& measured, int repetition, ResultTable& table) {
  for (std::size_t row = 0; row < momenta.Rows(); ++row) {
    if (momenta.Text(row, momenta.Column("repetition")) != std::to_string(repetition)) continue;
    for (const std::string& column : momenta.Header())
      if (column.starts_with("com_") && !column.ends_with("_sd") && !measured.Has(column))
        table.Add(column, momenta.Number(row, momenta.Column(column)).value_or(kNaN));
  }
}

// `momenta`: momentum.csv, where the loads of this trial are known.
void AddRises(const motion::LegMotion& leg, const MeasuredTable& measured, const std::optional<CsvTable>& momenta,
              const std::string& trial, ResultTable& table) {
  using motion::LegSample;
  for (const auto& [repetition, rise] : RisesOf(leg)) {
    table.Begin(trial, repetition);
    for (const auto& [quantity, value] : RowOf(measured, std::to_string(repetition))) table.Add(quantity, value);
    if (momenta) AddMomentum(*momenta, measured.table, repetition, table);
    const double least = Largest(rise, &LegSample::knee_deg, -1);
    table.Add("knee_min_deg", least);
    table.Add("knee_range_deg", Largest(rise, &LegSample::knee_deg) - least);
    table.Add("shank_max_deg", Largest(rise, &LegSample::shank_deg));
    for (const Angle& angle : kAngles) table.AddCurve(trial, angle.name, OverPercent(rise, angle.field));
  }
}

void AddTrial(const fs::path& folder, const std::optional<CsvTable>& momenta, const std::string& trial,
              ResultTable& table) {
  const motion::LegMotion leg = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  const MeasuredTable measured = ReadMeasured(folder);
  table.Set(measured.movement);
  AddRises(leg, measured, momenta, trial, table);
  std::map<std::string, double> whole;
  if (const auto five_times = RowOf(measured, "five_times"); five_times.contains("five_times_s"))
    whole = {{"five_times_s", five_times.at("five_times_s")}, {"five_times_power_w_kg", five_times.at("power_w_kg")}};
  if (leg.unit == motion::LengthUnit::kMm) {
    whole["shank_mm"] = motion::MedianLength(leg, &motion::LegSample::ak);
    whole["thigh_mm"] = motion::MedianLength(leg, &motion::LegSample::kh);
  }
  if (std::ranges::none_of(whole, [](const auto& of) { return std::isfinite(of.second); })) return;
  table.Begin(trial, {});
  for (const auto& [quantity, value] : whole) table.Add(quantity, value);
}

void AddComparison(const fs::path& folder, ResultTable& table) {
  const Json comparison = ReadJsonFile(folder / "comparison.json");
  table.Begin("comparison", {});
  for (const auto& [name, value] : comparison.at("metrics").items()) table.Add(name, NumberOrNaN(value));
  // Absent, or null, where the trial does not show the knee of the leg that wears the exoskeleton.
  if (const Json joint = comparison.value("joint", Json()); joint.is_object()) {
    for (const char* name : {"rms_mm", "max_mm", "relative_rms", "angle_rms_deg"})
      table.Add(fmt::format("joint_{}", name), NumberOrNaN(joint.value(name, Json())));
    for (const int axis : {0, 1})
      table.Add(axis ? "joint_offset_y_mm" : "joint_offset_x_mm",
                NumberOrNaN(joint.at("offset_mm").at(static_cast<std::size_t>(axis))));
  }
  const Json& parts = comparison.at("decomposition");
  for (const compare::Part& part : compare::kParts)
    table.Add(fmt::format("{}_fraction", part.name), NumberOrNaN(parts.at(part.name).at("fraction")));
  for (const int axis : {0, 1})
    table.Add(axis ? "offset_y_mm" : "offset_x_mm",
              NumberOrNaN(parts.at("offset_mm").at(static_cast<std::size_t>(axis))));
  const CsvTable curves = CsvTable::Read(folder / "misalignment.csv");
  for (const char* quantity : {"distance_mm", "relative_error"}) {
    Curve curve;
    curve.fill(kNaN);
    for (std::size_t row = 0; row < std::min<std::size_t>(curves.Rows(), kPercents); ++row)
      curve[row] = curves.Number(row, curves.Column(quantity)).value_or(kNaN);
    table.AddCurve("comparison", quantity, curve);
  }
}

// The design for this person, or the best of the problem.
void AddDesign(const fs::path& folder, ResultTable& table) {
  const Json summary = ReadJsonFile(folder / "summary.json");
  table.Begin("design", {});
  for (const char* name : {"range_deg", "misalignment_percent", "misalignment_rms_mm", "certified_upper_bound_deg"})
    if (summary.contains(name)) table.Add(name, NumberOrNaN(summary[name]));
}

}  // namespace

GroupData ReadGroup(const std::vector<DoneStudy>& studies) {
  GroupData group;
  for (const DoneStudy& study : studies) {
    ResultTable table(group, study);
    const auto has = [&](const char* step) { return study.steps.contains(step); };
    std::optional<CsvTable> momenta;
    // Loads of an earlier version have none.
    if (const fs::path file = study.folder / "loads/momentum.csv"; has("loads") && fs::exists(file))
      momenta = CsvTable::Read(file);
    if (has("human")) AddTrial(study.folder / "human", momenta, "human", table);
    if (has("exo")) AddTrial(study.folder / "exo", {}, "exo", table);
    if (has("comparison")) AddComparison(study.folder / "comparison", table);
    if (const char* design = study.has_redesign ? "redesign" : "optimum"; has(design))
      AddDesign(study.folder / design, table);
  }
  return group;
}

std::optional<double> ValueOf(const GroupData& group, const std::string& participant, const std::string& trial,
                              const std::string& quantity, const std::optional<std::string>& session) {
  std::vector<double> values;
  for (const GroupRow& row : group.rows)
    if (row.participant == participant && row.trial == trial && (!session || row.session == *session))
      if (const auto found = row.values.find(quantity); found != row.values.end()) values.push_back(found->second);
  return values.empty() ? std::nullopt : std::optional(Mean(values));
}

std::vector<std::string> ParticipantsOf(const GroupData& group) {
  std::vector<std::string> names;
  for (const GroupRow& row : group.rows)
    if (std::find(names.begin(), names.end(), row.participant) == names.end()) names.push_back(row.participant);
  return names;
}

}  // namespace lake::cohort
