// lake-compare: the misalignment between a human's and an exoskeleton's knee in sit-to-stand or walking.
#include "lake/commands/compare.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-compare",
                        "The misalignment between a human's and an exoskeleton's knee in sit-to-stand or walking",
                        "lake-compare track/human track/exo --human-knee knee --exo-knee exo_knee -o comparison");
  lake::commands::CompareRunOptions options;
  program.Add(lake::OptionsOf(options).WithUsual({"exo-map", "map", "human-knee", "exo-knee", "joint-at", "movement",
                                                  "knee-from", "worn", "camera", "scale", "depth", "height", "mass"}));
  return program.Main(
      argc, argv, [] { return std::string("comparison"); },
      [&](lake::Run& run) { return lake::commands::RunCompare(options, run); });
}
