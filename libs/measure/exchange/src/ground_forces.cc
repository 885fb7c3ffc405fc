#include "lake/exchange/ground_forces.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/mot.h"
#include "readers.h"

namespace lake::exchange {
namespace {

// Where the `nth` column of a name is (older files of OpenSim name all plates alike).
std::optional<std::size_t> FindColumn(const MotTable& table, const std::string& name, std::size_t nth) {
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (table.columns[i] == name && nth-- == 0) return i;
  return std::nullopt;
}

// The nth vector of a name, 0 in cells without a number; none if the file has none of its three columns.
std::vector<Eigen::Vector3d> FindVector(const MotTable& table, const std::string& stem, std::size_t nth,
                                        const std::filesystem::path& path) {
  std::vector<std::size_t> columns;
  for (const char axis : {'x', 'y', 'z'})
    if (const auto column = FindColumn(table, stem + axis, nth)) columns.push_back(*column);
  if (columns.empty()) return {};
  if (columns.size() < 3) throw Fail("{}: of {}x, y and z one is missing", path.string(), stem);
  std::vector<Eigen::Vector3d> vectors;
  for (const std::vector<double>& row : table.rows)
    vectors.push_back(Eigen::Vector3d(row[columns[0]], row[columns[1]], row[columns[2]]).unaryExpr([](double value) {
      return std::isfinite(value) ? value : 0;
    }));
  return vectors;
}

// "ground_force_1_" → "ground_torque_1_"
std::string TorqueStem(std::string stem) {
  const std::size_t at = stem.find("force");
  return at == std::string::npos ? "" : stem.replace(at, 5, "torque");
}

std::string Names(const GroundForceRecording& forces) {
  std::string names;
  for (std::size_t i = 0; i < forces.plates.size(); ++i)
    names += fmt::format("{}{} is {}", i ? ", " : "", i + 1, forces.plates[i].name);
  return names;
}

// Less than this is a plate's noise.
constexpr double kLeast_n = 20;

bool BearsForce(const PlateForces& plate) {
  return std::any_of(plate.force_n.begin(), plate.force_n.end(), [](const auto& f) { return f.norm() > kLeast_n; });
}

}  // namespace

GroundForceRecording ReadGroundForces(const std::filesystem::path& path) {
  const std::string ending = Lower(path.extension().string());
  if (ending == ".c3d") return ReadC3dForces(path);
  if (!IsMot(path))
    throw Fail("{}: ground forces are read from .mot, .sto and .c3d, not from '{}'", path.string(), ending);
  const MotTable table = ReadMot(path);
  GroundForceRecording forces;
  forces.time_s = table.time_s;
  forces.warnings = table.warnings;
  std::erase_if(forces.warnings, [](const std::string& warning) {  // there is no angle among forces
    return warning.find("unit of angles") != std::string::npos;
  });
  std::map<std::string, std::size_t> seen;
  for (const std::string& column : table.columns) {
    if (!column.ends_with("vx")) continue;
    const std::size_t nth = seen[column]++;
    const std::string stem = column.substr(0, column.size() - 2);
    PlateForces& plate = forces.plates.emplace_back();
    plate.name = stem.substr(0, stem.find_last_not_of('_') + 1);
    plate.force_n = FindVector(table, stem + "v", nth, path);
    plate.point_m = FindVector(table, stem + "p", nth, path);
    plate.moment_nm = FindVector(table, stem + "m", nth, path);
    if (plate.moment_nm.empty() && !TorqueStem(stem).empty())
      plate.moment_nm = FindVector(table, TorqueStem(stem), nth, path);
    if (plate.point_m.empty()) {
      plate.unusable = fmt::format("{}: {} has a force but no point where it acts ({}px)", path.string(), stem, stem);
      forces.warnings.push_back(plate.unusable + "; only its force is read");
    }
    for (auto* vectors : {&plate.point_m, &plate.moment_nm})
      vectors->resize(table.rows.size(), Eigen::Vector3d::Zero());
  }
  if (forces.plates.empty())
    throw Fail("{}: no ground forces: there is no column that ends in 'vx', as in ground_force_1_vx", path.string());
  return forces;
}

bool HoldsOnlyForces(const std::filesystem::path& path) {
  return IsMot(path) || (Lower(path.extension().string()) == ".c3d" && IsC3dWithoutPoints(path));
}

void CheckPlates(const std::map<std::string, int>& plates) {
  for (const auto& [leg, number] : plates)
    if ((leg != "right" && leg != "left") || number < 1)
      throw UsageError("--plates {}={}: right=N,left=N, plates counted from 1", leg, number);
  if (plates.size() == 2 && plates.at("right") == plates.at("left"))
    throw UsageError(
        "--plates right={0},left={0}: a plate under both feet does not say what either bears; name each foot's own, or "
        "leave --forces out",
        plates.at("right"));
}

const PlateForces& PlateOf(const GroundForceRecording& forces, const std::map<std::string, int>& plates,
                           const std::string& leg, const std::filesystem::path& path) {
  if (const auto named = plates.find(leg); named != plates.end()) {
    if (static_cast<std::size_t>(named->second) > forces.plates.size())
      throw Fail("{}: no plate {}; it has: {}", path.string(), named->second, Names(forces));
    const PlateForces& plate = forces.plates[static_cast<std::size_t>(named->second) - 1];
    if (!plate.unusable.empty()) throw Fail("{}", plate.unusable);
    if (!BearsForce(plate))
      throw Fail("{}: plate {}, {}, bears no force; it has: {}", path.string(), named->second, plate.name,
                 Names(forces));
    return plate;
  }
  const PlateForces* only = nullptr;
  for (const PlateForces& plate : forces.plates) {
    if (!BearsForce(plate)) continue;
    if (only)
      throw Fail("{}: several plates bear a force: say which is the {} foot's, as --plates {}=1; plate {}",
                 path.string(), leg, leg, Names(forces));
    only = &plate;
  }
  if (!only) throw Fail("{}: no plate bears a force", path.string());
  return *only;
}

}  // namespace lake::exchange
