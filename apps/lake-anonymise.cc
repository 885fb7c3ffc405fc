// lake-anonymise: a copy of a recording that shows no face.
#include "lake/commands/anonymise.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-anonymise", "A copy of a recording with the subject's head blurred, the leg as it was",
                        "lake-anonymise sit-to-stand.mp4 --trial lake-out/sit-to-stand -o shareable");
  lake::commands::AnonymiseRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [&] { return options.video.stem().string() + "-anonymised"; },
      [&](lake::Run& run) { return lake::commands::RunAnonymise(options, run); });
}
