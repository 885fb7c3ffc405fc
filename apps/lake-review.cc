// lake-review: a local page to look at results: a trial to be corrected, a design to be explored, a comparison, a
// study.
#include <filesystem>

#include "lake/core/interrupt.h"
#include "lake/reviewing/run_review.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::reviewing::ReviewRunOptions options;
  return lake::RunTool(
      "lake-review",
      "In the browser: correct a trial, name a video's markers, explore a design, see two trials or a study's steps",
      "Example:\n  lake-review lake-out/human --open\n  lake-review lake-out/buildable --open",
      lake::OptionsOf(options), argc, argv, [&] {
        lake::CatchInterrupts();
        lake::reviewing::RunReview(options, std::filesystem::read_symlink("/proc/self/exe").parent_path());
      });
}
