// lake-sync: the clocks of two recordings of one movement, aligned.
#include "lake/commands/sync.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-sync", "The clocks of two recordings of one movement, aligned by the movement itself",
                        "lake-sync human/ forces.mot -o sync");
  lake::commands::SyncRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [&] { return options.a.stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunSync(options, run); });
}
