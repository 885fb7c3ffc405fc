// lake-check: what a recording is worth, in seconds, before the subject goes home.
#include "lake/commands/check.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program(
      "lake-check",
      "What a recording of reflective markers is worth: in seconds, with what to change; exit 0 fit, 1 not",
      "lake-check sit-to-stand.mp4");
  lake::commands::CheckRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [&] { return options.video.stem().string() + "-check"; },
      [&](lake::Run& run) { return lake::commands::RunCheck(options, run); });
}
