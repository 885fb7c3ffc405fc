#include "lake/sync/movement.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <optional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/ground_forces.h"
#include "lake/exchange/mot.h"

namespace lake::sync {
namespace {

namespace fs = std::filesystem;

std::string LowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string EndingOf(const fs::path& path) {
  return LowerCase(path.extension().string());
}

// How long a unit of a column of times is, by its name; "Time (s)" and "time_s" are in seconds.
double SecondsPerUnit(const std::string& lower_name) {
  for (const auto& [unit, seconds] : {std::pair{"us", 1e-6}, {"µs", 1e-6}, {"ms", 1e-3}})
    for (const char* form : {"({})", "[{}]", "_{}"})
      if (lower_name.ends_with(fmt::format(fmt::runtime(form), unit))) return seconds;
  return 1;
}

// The columns of an inertial sensor's table; empty where it is none.
struct SensorColumns {
  std::size_t time = 0;
  double seconds_per_unit = 1;
  std::vector<std::size_t> rates;
};

std::optional<SensorColumns> FindSensorColumns(const std::vector<std::string>& header) {
  std::optional<SensorColumns> columns;
  for (std::size_t i = 0; i < header.size() && !columns; ++i)
    if (const std::string name = LowerCase(header[i]); name.starts_with("time") || name.starts_with("timestamp"))
      columns = SensorColumns{i, SecondsPerUnit(name), {}};
  if (!columns) return std::nullopt;
  for (std::size_t i = 0; i < header.size(); ++i)
    if (const std::string name = LowerCase(header[i]);
        name.find("gyr") != std::string::npos || name.find("angular") != std::string::npos)
      columns->rates.push_back(i);
  return columns->rates.empty() ? std::nullopt : columns;
}

void CheckTimes(const fs::path& path, const std::vector<double>& time_s) {
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (!(time_s[i] > time_s[i - 1]))
      throw Fail("{}: row {}: time {} s does not follow the one before", path.string(), i + 1, time_s[i]);
}

std::vector<double> TimesOf(const CsvTable& table, std::size_t column, double seconds_per_unit) {
  std::vector<double> time_s;
  for (std::size_t row = 0; row < table.Rows(); ++row)
    time_s.push_back(seconds_per_unit * table.RequiredNumber(row, column));
  return time_s;
}

Movement SensorMovement(const fs::path& path, const CsvTable& table, const SensorColumns& columns) {
  Movement movement{.kind = MovementKind::kInertial, .file = path};
  movement.time_s = TimesOf(table, columns.time, columns.seconds_per_unit);
  CheckTimes(path, movement.time_s);
  movement.values.resize(static_cast<Eigen::Index>(table.Rows()), static_cast<Eigen::Index>(columns.rates.size()));
  for (std::size_t c = 0; c < columns.rates.size(); ++c) {
    movement.names.push_back(table.Header()[columns.rates[c]]);
    for (std::size_t row = 0; row < table.Rows(); ++row)
      movement.values(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(c)) =
          table.Number(row, columns.rates[c]).value_or(kNaN);
  }
  return movement;
}

Movement ForceMovement(const fs::path& path) {
  const exchange::GroundForceRecording forces = exchange::ReadGroundForces(path);
  Movement movement{.kind = MovementKind::kForces, .file = path, .time_s = forces.time_s, .names = {"vertical force"}};
  movement.values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(forces.time_s.size()), 1);
  for (const exchange::PlateForces& plate : forces.plates)
    for (std::size_t i = 0; i < plate.force_n.size(); ++i)
      movement.values(static_cast<Eigen::Index>(i), 0) += plate.force_n[i][forces.up_axis - 'x'];
  return movement;
}

Movement MarkerMovement(const fs::path& path, double rate_hz) {
  const exchange::PointRecording points = exchange::ReadPoints(path, {.rate_hz = rate_hz});
  const bool in_space = points.space == exchange::PointSpace::kSpace;
  Movement movement{.kind = MovementKind::kMarkers,
                    .file = path,
                    .time_s = points.time_s,
                    .dimensions = in_space ? 3 : 2,
                    .up = in_space ? points.up_axis - 'x' : 1};
  const auto frames = static_cast<Eigen::Index>(points.time_s.size());
  movement.values.resize(frames, static_cast<Eigen::Index>(points.points.size()) * movement.dimensions);
  for (std::size_t m = 0; m < points.points.size(); ++m) {
    movement.names.push_back(points.points[m].name);
    for (Eigen::Index i = 0; i < frames; ++i)
      movement.values.block(i, static_cast<Eigen::Index>(m) * movement.dimensions, 1, movement.dimensions) =
          points.points[m].positions[static_cast<std::size_t>(i)].head(movement.dimensions).transpose();
  }
  return movement;
}

bool IsTableOfForces(const fs::path& path) {
  return EndingOf(path) == ".mot" || EndingOf(path) == ".sto";
}

// The names in a .csv's first line; none of another file, and one of a table with another separator.
std::vector<std::string> HeaderOf(const fs::path& path) {
  if (EndingOf(path) != ".csv") return {};
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return SplitText(line, ',');
}

// A table that is not of markers: of an inertial sensor.
std::optional<Movement> FindSensorMovement(const fs::path& path) {
  const auto columns = FindSensorColumns(HeaderOf(path));
  return columns ? std::optional(SensorMovement(path, CsvTable::Read(path), *columns)) : std::nullopt;
}

// When a signal of two levels goes from the lower to the upper one: between two samples, where it passes the middle.
// Once it has risen it must fall below a quarter before it can rise again.
std::vector<double> RisesOfChannel(const std::vector<double>& time_s, const std::vector<double>& value,
                                   const std::string& where) {
  const auto [low, high] = std::ranges::minmax(value);
  const double middle = (low + high) / 2, quarter = (3 * low + high) / 4;
  std::vector<double> rises;
  bool is_down = false;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (is_down && value[i] >= middle)
      rises.push_back(std::lerp(time_s[i - 1], time_s[i], (middle - value[i - 1]) / (value[i] - value[i - 1])));
    is_down = value[i] < (is_down ? middle : quarter);
  }
  if (!(high > low) || rises.empty()) throw Fail("{}: it never rises from a lower level to a higher one", where);
  return rises;
}

std::string Names(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 12;
  const std::size_t shown = std::min(names.size(), kMost);
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     shown < names.size() ? ", …" : "");
}

[[noreturn]] void ThrowNoSuchSignal(const fs::path& path, const std::string& name,
                                    const std::vector<std::string>& has) {
  throw Fail("{}: no signal '{}'; it has: {}", path.string(), name, Names(has));
}

// A light is on from half a frame before the first in which it is seen.
std::vector<double> RisesOfMarker(const exchange::PointRecording& points, const fs::path& path,
                                  const std::string& name) {
  const exchange::PointTrack* track = points.Find(name);
  if (!track) {
    std::vector<std::string> has;
    for (const exchange::PointTrack& point : points.points) has.push_back(point.name);
    ThrowNoSuchSignal(path, name, has);
  }
  std::vector<double> rises;
  for (std::size_t i = 1; i < points.time_s.size(); ++i)
    if (track->positions[i].allFinite() && !track->positions[i - 1].allFinite())
      rises.push_back((points.time_s[i - 1] + points.time_s[i]) / 2);
  if (rises.empty()) throw Fail("{}: marker '{}' never comes into sight after the first frame", path.string(), name);
  return rises;
}

std::vector<double> ColumnOf(const CsvTable& table, std::size_t column) {
  std::vector<double> values;
  for (std::size_t row = 0; row < table.Rows(); ++row) values.push_back(table.RequiredNumber(row, column));
  return values;
}

}  // namespace

std::string_view ToString(MovementKind kind) {
  switch (kind) {
    case MovementKind::kMarkers:
      return "markers";
    case MovementKind::kForces:
      return "ground forces";
    default:
      return "an inertial sensor";
  }
}

Movement ReadMovement(const fs::path& path, const MovementOptions& options) {
  if (exchange::HoldsOnlyForces(path)) return ForceMovement(path);
  if (auto sensor = FindSensorMovement(path)) return *sensor;
  return MarkerMovement(path, options.rate_hz);
}

std::vector<double> RisesOf(const fs::path& path, const std::string& name, const MovementOptions& options) {
  const std::string where = fmt::format("{}: '{}'", path.string(), name);
  if (IsTableOfForces(path)) {
    const exchange::MotTable table = exchange::ReadMot(path);
    if (std::ranges::count(table.columns, name) == 0) ThrowNoSuchSignal(path, name, table.columns);
    std::vector<double> values;
    for (const std::vector<double>& row : table.rows) values.push_back(row[table.Column(name)]);
    return RisesOfChannel(table.time_s, values, where);
  }
  const std::vector<std::string> header = HeaderOf(path);
  const auto time =
      std::ranges::find_if(header, [](const std::string& column) { return LowerCase(column).starts_with("time"); });
  if (time != header.end() && std::ranges::count(header, name) > 0) {
    const CsvTable table = CsvTable::Read(path);
    return RisesOfChannel(TimesOf(table, table.Column(*time), SecondsPerUnit(LowerCase(*time))),
                          ColumnOf(table, table.Column(name)), where);
  }
  if (FindSensorColumns(header)) ThrowNoSuchSignal(path, name, header);
  return RisesOfMarker(exchange::ReadPoints(path, {.rate_hz = options.rate_hz}), path, name);
}

}  // namespace lake::sync
