#include "lake/problem/linear_actuator.h"

#include <algorithm>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/nearest_name.h"
#include "lake/core/numbers.h"

namespace lake::problem {

// The text of calibration/actuators.csv, as actuator_catalogue.cc.in has it.
std::string_view ActuatorCatalogue();

namespace {

namespace fs = std::filesystem;
using ForceSpeed = LinearActuator::ForceSpeed;

constexpr double kMostOfAnything = 1e6;

// The columns that hold a number.
constexpr struct {
  const char* name;
  std::optional<double> LinearActuator::*value;
  double most = kMostOfAnything;
} kNumbers[] = {{"closed_mm", &LinearActuator::closed_mm},
                {"stroke_mm", &LinearActuator::travel_mm},
                {"max_force_n", &LinearActuator::max_force_n},
                {"no_load_speed_mm_s", &LinearActuator::no_load_speed_mm_s},
                {"holding_force_n", &LinearActuator::holding_force_n},
                {"mass_g", &LinearActuator::mass_g},
                {"duty_cycle_percent", &LinearActuator::duty_cycle_percent, 100}};

std::vector<std::string> Columns() {
  std::vector<std::string> columns = {"name", "maker", "force_speed_points", "voltage_v", "feedback", "source"};
  for (const auto& number : kNumbers) columns.emplace_back(number.name);
  return columns;
}

void CheckWithinReason(std::optional<double> value, const char* what, double most = kMostOfAnything) {
  if (value && !(*value > 0 && *value <= most))
    throw Fail("{} = {} must lie above 0, and not beyond {}", what, *value, most);
}

// The points known, ascending in force, with the speed without load; below the first a speed is at least the first's.
std::vector<ForceSpeed> KnownPoints(const LinearActuator& actuator) {
  std::vector<ForceSpeed> points = actuator.force_speed;
  if (actuator.no_load_speed_mm_s)
    points.insert(points.begin(), {0, *actuator.no_load_speed_mm_s});
  else if (!points.empty())
    points.insert(points.begin(), {0, points.front().speed_mm_s});
  return points;
}

// "16 mm/s at 50 N"
ForceSpeed ParsePoint(const std::string& text) {
  const std::size_t speed_end = text.find("mm/s at"), force_end = text.rfind('N');
  if (speed_end != std::string::npos && force_end == text.size() - 1) {
    const std::size_t force_begin = speed_end + std::string_view("mm/s at").size();
    const auto speed = ParseNumber(Trim(std::string_view(text).substr(0, speed_end)));
    const auto force = ParseNumber(Trim(std::string_view(text).substr(force_begin, force_end - force_begin)));
    if (speed && force) return {*force, *speed};
  }
  throw Fail("'{}' is no point of a force–speed law: write 16 mm/s at 50 N", text);
}

std::vector<ForceSpeed> ParsePoints(const std::string& text) {
  std::vector<ForceSpeed> points;
  for (const std::string& point : SplitText(text, ';')) points.push_back(ParsePoint(point));
  std::ranges::sort(points, {}, &ForceSpeed::force_n);
  return points;
}

LinearActuator ReadRow(const CsvTable& table, std::size_t row) {
  const auto text = [&](const char* column) {
    return table.Has(column) ? std::string(Trim(table.Text(row, table.Column(column)))) : "";
  };
  LinearActuator actuator;
  actuator.name = text("name");
  actuator.maker = text("maker");
  actuator.source = text("source");
  for (const auto& number : kNumbers)
    if (table.Has(number.name)) actuator.*number.value = table.Number(row, table.Column(number.name));
  try {
    actuator.force_speed = ParsePoints(text("force_speed_points"));
    actuator.Check();
  } catch (const Error& error) {
    throw Fail("{}: {}", table.Where(row), error.what());
  }
  return actuator;
}

std::vector<LinearActuator> ReadTable(const CsvTable& table, const fs::path& path) {
  const std::vector<std::string> columns = Columns();
  for (const std::string& column : table.Header())
    if (std::ranges::find(columns, column) == columns.end())
      throw Fail("{}: unknown column '{}'; a catalogue of actuators has {}", path.string(), column,
                 fmt::join(columns, ", "));
  table.Column("name");
  std::vector<LinearActuator> actuators;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    LinearActuator actuator = ReadRow(table, row);
    if (std::ranges::find(actuators, actuator.name, &LinearActuator::name) != actuators.end())
      throw Fail("{}: '{}' stands twice", table.Where(row), actuator.name);
    actuators.push_back(std::move(actuator));
  }
  if (actuators.empty()) throw Fail("{}: no actuator in it", path.string());
  return actuators;
}

const LinearActuator& Named(const std::vector<LinearActuator>& actuators, const std::string& name,
                            const std::string& where) {
  const auto found = std::ranges::find(actuators, name, &LinearActuator::name);
  if (found != actuators.end()) return *found;
  std::vector<std::string> names;
  for (const LinearActuator& actuator : actuators) names.push_back(actuator.name);
  throw Fail("there is no actuator '{}' in {}{}; it has {}. A catalogue of your own: FILE.csv:NAME", name, where,
             DidYouMean(name, names), fmt::join(names, ", "));
}

}  // namespace

std::optional<double> LinearActuator::LiftingForce() const {
  if (force_speed.empty()) return max_force_n;
  return std::min(max_force_n.value_or(kInfinity), force_speed.back().force_n);
}

std::vector<SpeedLine> LinearActuator::SpeedLines() const {
  const std::vector<ForceSpeed> points = KnownPoints(*this);
  if (points.size() == 1) return {{points.front().speed_mm_s, 0}};
  std::vector<SpeedLine> lines;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double slope =
        (points[i - 1].speed_mm_s - points[i].speed_mm_s) / (points[i].force_n - points[i - 1].force_n);
    lines.push_back({points[i].speed_mm_s + slope * points[i].force_n, slope});
  }
  return lines;
}

double LinearActuator::SpeedAt(double force_n) const {
  double speed = kInfinity;
  for (const SpeedLine& line : SpeedLines())
    speed = std::min(speed, line.at_rest_mm_s - line.per_newton_mm_s * force_n);
  return std::max(0.0, speed);
}

double LinearActuator::LargestPower() const {
  constexpr double kMillimetresPerMetre = 1000;
  const std::optional<double> most_n = LiftingForce();
  if (!most_n || !HasSpeed()) return kInfinity;
  // Between corners of the law the product is a parabola.
  std::vector<double> forces = {*most_n};
  for (const ForceSpeed& point : force_speed) forces.push_back(point.force_n);
  for (const SpeedLine& line : SpeedLines())
    if (line.per_newton_mm_s > 0) forces.push_back(line.at_rest_mm_s / (2 * line.per_newton_mm_s));
  double power = 0;
  for (const double force_n : forces)
    if (force_n <= *most_n) power = std::max(power, force_n * SpeedAt(force_n) / kMillimetresPerMetre);
  return power;
}

void LinearActuator::Check() const {
  if (name.empty()) throw Fail("an actuator needs a name");
  for (const auto& number : kNumbers) CheckWithinReason(this->*number.value, number.name, number.most);
  for (const ForceSpeed& point : force_speed) {
    CheckWithinReason(point.force_n, "a force of force_speed_points");
    CheckWithinReason(point.speed_mm_s, "a speed of force_speed_points");
  }
  const std::vector<ForceSpeed> points = KnownPoints(*this);
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].force_n == points[i - 1].force_n)
      throw Fail("force_speed_points has two speeds at {} N", points[i].force_n);
    if (points[i].speed_mm_s > points[i - 1].speed_mm_s)
      throw Fail("{} mm/s at {} N, faster than the {} mm/s at {} N: a speed cannot grow with the force",
                 points[i].speed_mm_s, points[i].force_n, points[i - 1].speed_mm_s, points[i - 1].force_n);
  }
}

std::vector<LinearActuator> ReadActuators(const fs::path& path) {
  return ReadTable(CsvTable::Read(path), path);
}

std::vector<LinearActuator> KnownActuators() {
  const fs::path path = "actuators.csv";
  return ReadTable(CsvTable::Parse(std::string(ActuatorCatalogue()), path), path);
}

ActuatorPlace PlaceOf(const std::string& text) {
  const std::size_t table = text.rfind(".csv:");
  if (table != std::string::npos) return {text.substr(0, table + 4), text.substr(table + 5)};
  if (text.ends_with(".csv")) return {text, ""};
  return {"", text};
}

LinearActuator FindActuator(const std::string& text, const fs::path& folder) {
  const auto [file, name] = PlaceOf(text);
  if (file.empty()) return Named(KnownActuators(), name, "lake's catalogue");
  const fs::path path = folder / file;
  const std::vector<LinearActuator> actuators = ReadActuators(path);
  if (name.empty() && actuators.size() > 1)
    throw Fail("{} has {} actuators: name one, {}:{}", text, actuators.size(), text, actuators.front().name);
  LinearActuator actuator = name.empty() ? actuators.front() : Named(actuators, name, path.string());
  actuator.file = path;
  return actuator;
}

}  // namespace lake::problem
