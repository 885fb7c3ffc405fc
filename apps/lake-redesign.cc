// lake-redesign: the exoskeleton whose knee follows a person's, or several people's.
#include "lake/commands/optimize.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program(
      "lake-redesign",
      "The exoskeleton whose knee follows a person's, by the trials that lake-compare compared or a human trial alone; "
      "of several people, one design or some sizes for all.",
      "lake-redesign --comparison lake-out/comparison --worn worn.yaml --max-misalignment 3 --program free "
      "--duration 25 --fit-placement --pareto 12\n"
      "  lake-redesign --comparison sub-01/comparison sub-02/comparison sub-03/comparison --human-only "
      "--max-misalignment 3 --program free --duration 25 --fit-placement");
  lake::commands::OptimizeRunOptions options;
  program.Add(lake::OptionsOf(options.reoptimize.emplace())
                  .Without({"duration"})  // it stands among the problem's options
                  .WithUsual({"comparison", "human", "worn", "human-only", "max-misalignment", "penalty", "program",
                              "fit-placement", "across", "sizes", "pareto"}));
  program.Add(
      lake::OptionsOf(options).Without({"actuators", "round"}).WithUsual({"problem", "duration", "starts", "certify"}),
      "Limits and search, as for lake-optimize");
  return program.Main(
      argc, argv, [] { return std::string("redesign"); },
      [&](lake::Run& run) { return lake::commands::RunOptimize(options, run); });
}
