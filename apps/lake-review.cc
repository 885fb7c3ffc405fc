// lake-review: a local page to look at a trial and put right what was tracked wrongly.
#include <filesystem>

#include "lake/commands/review.h"
#include "lake/core/interrupt.h"
#include "program.h"

int main(int argc, char** argv) {
  CLI::App cli("Look at a tracked trial in the browser and correct it; or name a video's markers by clicks",
               "lake-review");
  cli.footer("Example:\n  lake-review lake-out/human --open");
  lake::commands::ReviewRunOptions options;
  const lake::SharedOptions given = lake::AddOptions(cli, lake::OptionsOf(options));
  return lake::ParseAndRun(cli, argc, argv, [&] {
    lake::CatchInterrupts();
    given->Apply();
    lake::commands::RunReview(options, std::filesystem::read_symlink("/proc/self/exe").parent_path());
    return 0;
  });
}
