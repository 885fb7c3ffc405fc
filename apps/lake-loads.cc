// lake-loads: the moments at ankle, knee and hip over the rise from a chair, or over the stance of a walk.
#include "lake/commands/loads.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program(
      "lake-loads",
      "The moments at ankle, knee and hip over the rise from a chair or, with force plates, a walk's stance",
      "lake-loads lake-out/human --mass 70 --height 1750 -o loads");
  lake::commands::LoadsRunOptions options;
  program.Add(lake::OptionsOf(options).WithUsual({"map", "camera", "scale", "movement", "events", "mass", "height",
                                                  "sex", "share", "forces", "plates", "sync", "leg"}));
  return program.Main(
      argc, argv, [&] { return options.trial.stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunLoads(options, run); });
}
