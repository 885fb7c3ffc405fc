// The linkage of a design in every pose: tables, pictures, animation, link plates, mannequin.
#include "lake/commands/simulate.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::commands::DesignSimulation simulation;
  lake::Program program("lake-simulate", "Show a knee linkage in its poses: tables, pictures, animation, link plates.",
                        "lake-simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 --angles 2,70,110,148");
  program.Add(lake::OptionsOf(simulation));
  program.Add(lake::OptionsOf(simulation.options)
                  .WithUsual({"angles", "knee-torque", "thigh", "shank", "mount", "profile", "assist", "actuator",
                              "animation"}));
  return program.Main(
      argc, argv, [&] { return simulation.file.empty() ? "links" : simulation.file.stem().string(); },
      [&](lake::Run& run) { return lake::commands::SimulateLinkage(simulation, run); });
}
