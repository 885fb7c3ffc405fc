// A linear actuator as its maker describes it, and the catalogue of them. What a maker does not say is unknown, not
// guessed: an actuator is used for what is known of it.
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
  std::optional<double> stroke_mm;           // its travel: d_max is closed + stroke
  std::optional<double> max_force_n;         // that it can lift
  std::optional<double> no_load_speed_mm_s;  //
  std::vector<ForceSpeed> force_speed;       // under load, ascending in force
  std::optional<double> holding_force_n;     // that it bears at rest, unpowered
  std::optional<double> mass_g;
  std::optional<double> duty_cycle_percent;  // of the time that it may run

  // The greatest force that may be asked of it: its largest, but while its speed is known under some loads, no more
  // than the greatest of these. nullopt if neither is known.
  std::optional<double> LiftingForce() const;
  // Its speed is known at all, and also under load.
  bool HasSpeed() const { return no_load_speed_mm_s || HasForceSpeedLaw(); }
  bool HasForceSpeedLaw() const { return !force_speed.empty(); }
  // What its speed must keep below, all of them: lines through the points known, the speed without load among them. The
  // lowest line counts: of a law that bends outwards that is interpolation, of another the safe side. Without a speed
  // under load, the speed without; empty if none is known.
  std::vector<SpeedLine> SpeedLines() const;
  // mm/s under a force in N by these lines, whatever it can lift; infinity if no speed is known.
  double SpeedAt(double force_n) const;
  // W, the greatest product of force and speed; infinity if no speed or no force is known.
  double LargestPower() const;

  // Throws Error naming what cannot be: not positive, a speed that grows with the force.
  void Check() const;
};

// Throws Error naming file and line: an unknown column, a cell that is no number, what Check() refuses, a name that
// stands twice, no actuator at all.
std::vector<LinearActuator> ReadActuators(const std::filesystem::path& path);

// The catalogue that lake comes with, calibration/actuators.csv.
std::vector<LinearActuator> KnownActuators();

// NAME of the catalogue that lake comes with, or a file, relative to `folder`: FILE.csv with a single actuator,
// FILE.csv:NAME. Throws Error that lists the names there are.
LinearActuator FindActuator(const std::string& text, const std::filesystem::path& folder = {});

}  // namespace lake::problem
