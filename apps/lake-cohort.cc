// lake-cohort: the studies of many people, and what they say as a group.
#include "lake/cohort/run_cohort.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-cohort", "The studies of many people, and what they say as a group",
                        "lake-cohort my-cohort my-cohort/derivatives/lake group --cores 4");
  lake::cohort::CohortRunOptions options;
  lake::OptionList source;
  source.AddOperand("folder", options.source, "The cohort: participants.tsv, cohort.yaml, sourcedata/")
      .IsPath(lake::Option::Path::kFolder);
  program.Add(std::move(source));
  program.TakeOutByPlace();
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [] { return std::string("cohort"); },
      [&](lake::Run& run) { return lake::cohort::RunCohort(options, run); });
}
