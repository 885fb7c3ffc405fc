// lake-run: a whole study, from the recordings to a better exoskeleton and a report.
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/option_template.h"
#include "lake/gait/movement.h"
#include "lake/study/study.h"
#include "lake/study/study_file.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-run", "A whole study: both trials, misalignment, designs, simulation, one report",
                        "lake-run data/sts-study/study.yaml");
  std::filesystem::path file;
  std::vector<std::string> only;
  std::optional<std::filesystem::path> make_template;
  std::optional<lake::gait::MovementKind> movement;
  bool plan = false, keep_going = false;
  lake::OptionList options;
  options.AddOperand("study", file, "study.yaml");
  options.Add("plan", plan,
              "Print the steps with their inputs, outputs and resources, and what is to be done, as JSON; do nothing");
  options.Add("only", only, "Do this step alone, if it is to be done; those before it must have been done")
      .Value("STEP")
      .Repeats();
  options.Add("keep-going", keep_going, "Where a step fails, do all that does not need it before the study fails");
  lake::gait::DescribeMovement(movement, options);
  options
      .Add("template", make_template, "Write a study.yaml with every key, its default and its meaning; do nothing else")
      .Value("FILE");
  options.Check([&](const lake::OptionList&) {
    if (file.empty() && !make_template)
      throw lake::UsageError("the study's file is missing; --template FILE writes one to fill in");
    if (plan && !only.empty()) throw lake::UsageError("--plan: not with --only");
  });
  program.Add(std::move(options));
  std::optional<lake::study::StudyFile> study;
  return program.Main(
      argc, argv,
      [&] {
        if (make_template) return std::string("study");
        study = lake::study::ReadStudyFile(file);
        if (movement) study->SetMovement(*movement);
        return study->ResultName();
      },
      [&](lake::Run& run) {
        if (make_template) {
          lake::WriteTemplateFile(*make_template, lake::study::StudyTemplate());
          return lake::Json();
        }
        if (plan) {
          lake::study::CheckFiles(*study);
          fmt::print("{}\n", lake::study::PlanJson(lake::study::PlanStudy(*study, run.Folder())).dump(2));
        }
        if (!only.empty()) lake::study::RunStudySteps(*study, only, keep_going, run);
        return plan || !only.empty() ? lake::Json() : lake::study::RunStudyFile(*study, run, keep_going);
      });
}
