// lake-run: a whole study, from the recordings to a better exoskeleton and a report.
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/error.h"
#include "lake/study/study.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-run", "A whole study: both trials, misalignment, designs, simulation, one report",
                        "lake-run data/sts-study/study.yaml");
  std::filesystem::path file;
  std::vector<std::string> only;
  bool plan = false, keep_going = false;
  lake::OptionList options;
  options.AddOperand("study", file, "study.yaml").Required();
  options.Add("plan", plan,
              "Print the steps with their inputs, outputs and resources, and what is to be done, as JSON; do nothing");
  options.Add("only", only, "Do this step alone, if it is to be done; those before it must have been done")
      .Value("STEP")
      .Repeats();
  options.Add("keep-going", keep_going, "Where a step fails, do all that does not need it before the study fails");
  options.Check([&](const lake::OptionList&) {
    if (plan && !only.empty()) throw lake::UsageError("--plan: not with --only");
  });
  program.Add(std::move(options));
  std::optional<lake::study::StudyFile> study;
  return program.Main(
      argc, argv,
      [&] {
        study = lake::study::ReadStudyFile(file);
        return study->ResultName();
      },
      [&](lake::Run& run) {
        if (plan) fmt::print("{}\n", lake::study::PlanJson(lake::study::PlanStudy(*study, run.Folder())).dump(2));
        if (!only.empty()) lake::study::RunStudySteps(*study, only, keep_going, run);
        return plan || !only.empty() ? lake::Json() : lake::study::RunStudyFile(*study, run, keep_going);
      });
}
