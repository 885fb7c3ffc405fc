// What a recording shows of a movement over its own clock: markers, ground forces or an inertial sensor.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace lake::sync {

enum class MovementKind { kMarkers, kForces, kInertial };

// "markers", "ground forces", "an inertial sensor".
std::string_view ToString(MovementKind kind);

struct Movement {
  MovementKind kind = MovementKind::kMarkers;
  std::filesystem::path file = {};  // that was read: of a folder, its table
  std::vector<double> time_s = {};  // increasing
  // Markers: px, mm or whatever the file has, two or three columns each; forces: one, the sum of the plates' vertical
  // forces, N; inertial: angular rates about the sensor's axes, in any unit.
  std::vector<std::string> names = {};  // of markers, or of the columns
  int dimensions = 1;                   // columns to a name
  int up = 0;                           // which of a marker's columns is the vertical, up or down
  Eigen::MatrixXd values = {};          // a row to each time; NaN where missing
};

struct MovementOptions {
  double rate_hz = 0;  // of files without times
};

// A lake-track folder or a file that exchange::ReadPoints knows (.c3d: its points), .mot or .sto with ground forces,
// or a .csv of an inertial sensor: a column whose name begins with "time" (s; ms or us if the name says so), and those
// of the angular rates, whose names hold "gyr" or "angular". Throws Error for others.
Movement ReadMovement(const std::filesystem::path& path, const MovementOptions& options = {});

// A common signal that somebody sent to both: times at which a marker comes into sight (an LED), or a column of the
// file rises through the middle between its levels (a trigger channel). Throws Error where there is no such marker or
// column, or it never does.
std::vector<double> RisesOf(const std::filesystem::path& path, const std::string& name,
                            const MovementOptions& options = {});

}  // namespace lake::sync
