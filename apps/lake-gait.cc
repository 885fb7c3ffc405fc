// lake-gait: leg vectors, knee angle and sit-to-stand events from an existing trial.
#include "lake/commands/gait.h"
#include "lake/core/error.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-gait", "Leg vectors, knee angle and sit-to-stand events from an existing trial",
                        "lake-gait trial.trc --map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=R_Shoulder -o gait");
  std::string trial, map, up, forward, filter = "spline", unit = "mm", facing;
  double cutoff_hz = 0;
  CLI::App& cli = program.Cli();
  cli.add_option("trial", trial, "A lake-track folder, or .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker)")
      ->required();
  cli.add_option("--map", map, "ankle=NAME,knee=NAME,hip=NAME,waist=NAME; A+B is the middle of two markers");
  cli.add_option("--up", up, "x, y or z: vertical axis of a 3-D file (default: TRC y, C3D its own or z)");
  cli.add_option("--forward", forward, "+x, -x, …: where the subject faces (default: found from the movement)");
  cli.add_option("--facing", facing, "left or right, in the plane (default: found from the movement)");
  cli.add_option("--filter", filter, "spline, butterworth or none");
  CLI::Option* cutoff =
      cli.add_option("--cutoff", cutoff_hz, "Hz (default: spline found from the data, Butterworth 6)");
  cli.add_option("--unit", unit, "mm, cm or m: of files that do not say (Tracker text, Kinovea)");
  bool smoothed = false;
  cli.add_flag("--smoothed", smoothed, "Start from the fit's estimates of a trajectory.csv, not from the measurements");
  return program.Main(
      argc, argv, [&] { return std::filesystem::path(trial).stem().string(); },
      [&](lake::Run& run) {
        lake::commands::GaitRunOptions options;
        options.trial = trial;
        options.reading.names = lake::exchange::ParseNameMap(map);
        options.reading.up = lake::exchange::ParseUp(up);
        options.reading.forward = forward;
        options.reading.mm_per_unit = lake::commands::MmPerUnit(unit);
        if (smoothed) options.reading.values = lake::motion::MarkerValues::kEstimated;
        options.fit.filter = lake::gait::ParseLegFilter(filter);
        if (cutoff->count() > 0 && !(cutoff_hz > 0))
          throw lake::UsageError(fmt::format("--cutoff {}: not positive", cutoff_hz));
        if (cutoff->count() > 0) options.fit.cutoff_hz = cutoff_hz;
        if (!facing.empty()) options.fit.facing = lake::commands::ParseFacing(facing);
        return lake::commands::RunGait(options, run);
      },
      lake::commands::GaitReport);
}
