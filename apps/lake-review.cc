// lake-review: a local page to look at results: a trial to be corrected, a design to be explored, a comparison, a
// study.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "lake/commands/review.h"
#include "lake/core/interrupt.h"
#include "program.h"

int main(int argc, char** argv) {
  CLI::App cli(
      "In the browser: correct a trial, name a video's markers, explore a design, see two trials or a study's steps",
      "lake-review");
  cli.footer("Example:\n  lake-review lake-out/human --open\n  lake-review lake-out/buildable --open");
  lake::commands::ReviewRunOptions options;
  const lake::SharedOptions given = lake::AddOptions(cli, lake::OptionsOf(options));
  return lake::ParseAndRun(cli, argc, argv, [&] {
    lake::CatchInterrupts();
    given->Apply();
    lake::commands::RunReview(options, std::filesystem::read_symlink("/proc/self/exe").parent_path());
    return 0;
  });
}
