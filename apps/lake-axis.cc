// lake-axis: the axis about which shank and thigh turn, from two or more markers on each.
#include "lake/commands/axis.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-axis", "The axis about which shank and thigh turn, from two or more markers on each",
                        "lake-axis walking.trc --segment shank=S1,S2,S3 --segment thigh=T1,T2,T3 -o axis");
  lake::commands::AxisRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [&] { return options.trial.stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunAxis(options, run); });
}
