// lake-export: a design for simulators, CAD and cutters.
#include "lake/commands/export.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-export", "A design as a simulator's model, as solids for CAD, or as plates to cut",
                        "lake-export lake-out/buildable/design.yaml mjcf -o mujoco");
  lake::commands::ExportOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [&] { return fmt::format("{}-{}", options.design.stem().string(), options.format); },
      [&](lake::Run& run) { return lake::commands::RunExport(options, run); });
}
