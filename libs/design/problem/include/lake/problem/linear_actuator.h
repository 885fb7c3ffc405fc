// A linear actuator as its maker describes it, and the catalogue of actuators. Missing data stays unknown and is not
// guessed; limits follow only from known data.
//
// actuators.csv: name, maker, closed_mm, stroke_mm, max_force_n, no_load_speed_mm_s, force_speed_points
// ("16 mm/s at 50 N; 8 mm/s at 90 N"), holding_force_n, mass_g, voltage_v, feedback, source, and, if there is one,
// duty_cycle_percent; an empty cell is not known.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lake::problem {

// speed <= at_rest - per_newton x force
struct SpeedLine {
  double at_rest_mm_s = 0;
  double per_newton_mm_s = 0;  // 0 or above
};

struct LinearActuator {
  struct ForceSpeed {
    double force_n = 0, speed_mm_s = 0;
  };

  std::string name, maker, source;
  std::filesystem::path file = {};           // that it was read from; empty: lake's catalogue
  std::optional<double> closed_mm;           // shortest length, pin to pin: d_min
  std::optional<double> travel_mm;           // d_max is closed + travel; the column stroke_mm, as makers call it
  std::optional<double> max_force_n;         // that it can lift
  std::optional<double> no_load_speed_mm_s;  //
  std::vector<ForceSpeed> force_speed;       // under load, ascending in force
  std::optional<double> holding_force_n;     // that it bears at rest, unpowered
  std::optional<double> mass_g;
  std::optional<double> duty_cycle_percent;  // of the time that it may run

  // The largest permitted force: max_force_n, but no more than the largest load at which the speed is known, if it is
  // known under load at all. nullopt if neither is known.
  std::optional<double> LiftingForce() const;
  // Whether the speed is known at all, and whether under load.
  bool HasSpeed() const { return no_load_speed_mm_s || HasForceSpeedLaw(); }
  bool HasForceSpeedLaw() const { return !force_speed.empty(); }
  // Upper bounds of the speed, all of which hold: lines through the known points, the speed without load included. The
  // lowest line counts: this interpolates a concave law and is on the safe side of any other. Without a speed under
  // load, the speed without load; empty if none is known.
  std::vector<SpeedLine> SpeedLines() const;
  // Speed in mm/s under a force in N by these lines, also beyond the force that it can lift; infinity if no speed is
  // known.
  double SpeedAt(double force_n) const;
  // W, the greatest product of force and speed; infinity if no speed or no force is known.
  double LargestPower() const;

  // Throws Error naming the invalid value: not positive, a speed that grows with the force.
  void Check() const;
};

// Throws Error naming file and line: an unknown column, a cell that is no number, what Check() refuses, a name that
// stands twice, no actuator at all.
std::vector<LinearActuator> ReadActuators(const std::filesystem::path& path);

// The catalogue that lake comes with, calibration/actuators.csv.
std::vector<LinearActuator> KnownActuators();

// How a text names an actuator: NAME of the catalogue that lake comes with (no file), FILE.csv (no name),
// FILE.csv:NAME.
struct ActuatorPlace {
  std::filesystem::path file;
  std::string name;
};
ActuatorPlace PlaceOf(const std::string& text);

// NAME of the catalogue that lake comes with, or a file, relative to `folder`: FILE.csv with a single actuator,
// FILE.csv:NAME. Throws Error that lists the names there are.
LinearActuator FindActuator(const std::string& text, const std::filesystem::path& folder = {});

}  // namespace lake::problem
