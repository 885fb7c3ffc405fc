// lake-symmetry: what differs between both legs of one person.
#include "lake/commands/symmetry.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-symmetry", "What differs between both legs of one person, rise by rise",
                        "lake-symmetry sts.trc --map knee=L_knee,… --right-map knee=R_knee,… --forces grf.mot");
  lake::commands::SymmetryRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [] { return std::string("symmetry"); },
      [&](lake::Run& run) { return lake::commands::RunSymmetry(options, run); });
}
