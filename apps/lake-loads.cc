// lake-loads: the moments at ankle, knee and hip over the rise from a chair.
#include "lake/commands/gait.h"
#include "lake/commands/loads.h"
#include "lake/core/error.h"
#include "lake/exchange/ground_forces.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-loads", "The moments at ankle, knee and hip over the rise from a chair",
                        "lake-loads lake-out/human --mass 70 --height 1750 -o loads");
  lake::commands::LoadsRunOptions options;
  lake::loads::LoadsOptions& loads = options.loads;
  std::string trial, map, up, forward, filter = "spline", unit = "mm", facing, sex, foot, forces, plates;
  double height_mm = 0;
  CLI::App& cli = program.Cli();
  cli.add_option("trial", trial, "A lake-track folder, or .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker)")
      ->required();
  cli.add_option("--mass", loads.body.mass_kg, "kg: of the person, with what is worn")->required();
  CLI::Option* height = cli.add_option("--height", height_mm, "mm: stature (default: from the leg's length)");
  cli.add_option("--sex", sex, "male or female: which table of deleva");
  cli.add_option("--anthropometry", loads.body.anthropometry, "winter, deleva or a YAML file: the segments' masses");
  cli.add_option("--share", loads.body.share, "Of the trunk's weight: what this leg bears");
  cli.add_option("--foot", foot, "HEEL,TOE in mm, behind and before the ankle (default: from the stature)");
  cli.add_option("--forces", forces,
                 "Ground forces as OpenSim writes them, .mot or .sto (default: from the trunk down)");
  cli.add_option("--plates", plates, "right=1,left=2: the feet's plates in the order of the file");
  cli.add_option("--leg", options.leg, "right or left: whose markers these are (default: by the ankle marker's name)");
  cli.add_option("--map", map,
                 "ankle=NAME,knee=NAME,hip=NAME,shoulder=NAME,waist=NAME; A+B is the middle of two markers");
  cli.add_option("--up", up, "x, y or z: vertical axis of a 3-D file (default: TRC y, C3D its own or z)");
  cli.add_option("--forward", forward, "+x, -x, …: where the subject faces (default: found from the movement)");
  cli.add_option("--facing", facing, "left or right, in the plane (default: found from the movement)");
  cli.add_option("--filter", filter, "spline, butterworth or none: of the leg fit");
  cli.add_option("--unit", unit, "mm, cm or m: of files that do not say (Tracker text, Kinovea)");
  cli.add_option("--draws", loads.draws, "How many draws the 95 % bands are taken from")->check(CLI::Range(20, 100000));
  cli.add_option("--seed-number", loads.seed, "Of the draws");
  return program.Main(
      argc, argv, [&] { return std::filesystem::path(trial).stem().string(); },
      [&](lake::Run& run) {
        options.trial = trial;
        options.reading.names = lake::exchange::ParseNameMap(map);
        options.reading.up = lake::exchange::ParseUp(up);
        options.reading.forward = forward;
        options.reading.mm_per_unit = lake::commands::MmPerUnit(unit);
        options.fit.filter = lake::gait::ParseLegFilter(filter);
        if (!facing.empty()) options.fit.facing = lake::commands::ParseFacing(facing);
        if (height->count() > 0) loads.body.height_m = height_mm / 1000;
        if (!sex.empty()) loads.body.sex = lake::loads::ParseSex(sex);
        if (!foot.empty()) loads.body.foot = lake::commands::ParseFoot(foot);
        options.forces = forces;
        options.plates = lake::exchange::ParsePlates(plates);
        return lake::commands::RunLoads(options, run);
      },
      lake::commands::LoadsReport);
}
