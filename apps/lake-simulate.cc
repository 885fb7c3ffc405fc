// The linkage of a design in every pose: tables, pictures, animation, link plates, mannequin.
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>

#include "lake/commands/simulate.h"
#include "lake/core/error.h"
#include "program.h"

namespace {

struct Input {
  std::filesystem::path design_file;
  std::optional<std::array<double, 6>> links;
  double d_min_mm = 0, d_max_mm = 0;
};

void Describe(Input& input, lake::OptionList& options) {
  options.AddOperand("design", input.design_file, "design.yaml, as lake-optimize writes it");
  options.Add("links", input.links, "Link lengths in mm, instead of a file").Value("l1,l2,l3,l4,l5,l6");
  options.Add("d-min", input.d_min_mm, "Shortest stroke; 0: the design's, or 242").Unit("mm");
  options.Add("d-max", input.d_max_mm, "Longest stroke; 0: the design's, or where the knee is straight").Unit("mm");
}

lake::linkage::Design LoadDesign(const Input& input, lake::Run& run) {
  if (input.design_file.empty() == !input.links)
    throw lake::UsageError("give either a design file or --links l1,l2,l3,l4,l5,l6");
  lake::linkage::Design design;
  if (!input.links) {
    design = lake::linkage::ReadDesign(input.design_file);
    run.AddInput(input.design_file, "design");
  } else {
    design.links = lake::linkage::Links::FromValues(*input.links);
    lake::linkage::CheckLinks(design.links, "--links");
  }
  if (input.d_min_mm != 0) design.d_min_mm = input.d_min_mm;
  if (input.d_max_mm != 0) design.d_max_mm = input.d_max_mm;
  if (!(design.d_min_mm > 0 && std::isfinite(design.d_min_mm)))
    throw lake::UsageError("--d-min must be above 0, not {}", design.d_min_mm);
  return design;
}

}  // namespace

int main(int argc, char** argv) {
  Input input;
  lake::commands::SimulationOptions options;
  lake::Program program("lake-simulate", "Show a knee linkage in its poses: tables, pictures, animation, link plates.",
                        "lake-simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 --angles 2,70,110,148");
  program.Add(lake::OptionsOf(input));
  program.Add(lake::OptionsOf(options).WithUsual(
      {"angles", "knee-torque", "thigh", "shank", "mount", "profile", "assist", "actuator", "animation"}));
  return program.Main(
      argc, argv, [&] { return input.design_file.empty() ? "links" : input.design_file.stem().string(); },
      [&](lake::Run& run) { return lake::commands::SimulateLinkage(LoadDesign(input, run), options, run); });
}
