// The linkage of a design in every pose: tables, pictures, animation, link plates, mannequin.
#include <cmath>
#include <filesystem>
#include <string>

#include "lake/commands/simulate.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "program.h"

namespace {

struct Input {
  std::string design_file, links;
  double d_min_mm = 0, d_max_mm = 0;
};

lake::linkage::Design LoadDesign(const Input& input, lake::Run& run) {
  if (input.design_file.empty() == input.links.empty())
    throw lake::UsageError("give either a design file or --links l1,l2,l3,l4,l5,l6");
  lake::linkage::Design design;
  if (input.links.empty()) {
    design = lake::linkage::ReadDesign(input.design_file);
    run.AddInput(input.design_file);
  } else {
    const auto values = lake::ParseNumbers(input.links, 6, "--links");
    design.links = {values[0], values[1], values[2], values[3], values[4], values[5]};
    lake::linkage::CheckLinks(design.links, "--links");
  }
  if (input.d_min_mm != 0) design.d_min_mm = input.d_min_mm;
  if (input.d_max_mm != 0) design.d_max_mm = input.d_max_mm;
  if (!(design.d_min_mm > 0 && std::isfinite(design.d_min_mm)))
    throw lake::UsageError(fmt::format("--d-min must be above 0, not {}", design.d_min_mm));
  return design;
}

}  // namespace

int main(int argc, char** argv) {
  Input input;
  lake::commands::SimulationOptions options;
  bool no_animation = false;
  lake::Program program("lake-simulate", "Show a knee linkage in its poses: tables, pictures, animation, link plates.",
                        "lake-simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 --angles 2,70,110,148");
  CLI::App& cli = program.Cli();
  cli.add_option("design", input.design_file, "design.yaml, as lake-optimize writes it");
  cli.add_option("--links", input.links, "Link lengths l1,l2,l3,l4,l5,l6 in mm, instead of a file");
  cli.add_option("--stroke", options.strokes_mm, "Stroke lengths in mm to add to the table")->delimiter(',');
  cli.add_option("--angles", options.angles_deg, "Knee angles in degrees to draw (default: 2, 70, 110 and the largest)")
      ->delimiter(',');
  cli.add_option("--d-min", input.d_min_mm, "Shortest stroke in mm (0: the design's, or 242)");
  cli.add_option("--d-max", input.d_max_mm, "Longest stroke in mm (0: the design's, or where the knee is straight)");
  cli.add_option("--knee-torque", options.knee_torque_nm, "Extension torque in N m for the force column");
  cli.add_option("--rows", options.rows, "Rows of the regular grid of angle_vs_stroke.csv");
  cli.add_option("--height", options.body_height_cm, "Height of the mannequin in cm");
  cli.add_option("--mass", options.body_mass_kg, "Mass of the mannequin in kg");
  cli.add_option("--seat-edge", options.seat_edge_mm, "Knee to the seat's front edge in mm (0: half the thigh)");
  cli.add_option("--bar-width", options.plates.bar_width_mm, "Width of the link plates in mm");
  cli.add_option("--pin-diameter", options.plates.pin_diameter_mm, "Diameter of their holes in mm");
  cli.add_option("--actuator-diameter", options.actuator_diameter_mm, "Diameter of the actuator in mm");
  cli.add_flag("--no-animation", no_animation, "Write no animation.mp4 and .gif");
  return program.Main(
      argc, argv,
      [&] { return input.design_file.empty() ? "links" : std::filesystem::path(input.design_file).stem().string(); },
      [&](lake::Run& run) {
        options.animation = !no_animation;
        return lake::commands::SimulateLinkage(LoadDesign(input, run), options, run);
      },
      lake::commands::SimulationReport);
}
