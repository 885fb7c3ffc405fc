#include "population.h"

#include <algorithm>

#include "lake/commands/optimize.h"
#include "lake/core/error.h"
#include "lake/steps/study_steps.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

// Each participant's first recordings whose comparison has been done, with the design that was worn.
void AddPeople(const Cohort& cohort, const Workflow& workflow, const StepsDone& done,
               commands::ReoptimizeRunOptions& options) {
  for (const Recordings& recordings : cohort.recordings) {
    const bool is_there = std::ranges::find(options.people, recordings.participant) != options.people.end();
    const auto steps = done.find(recordings.Name());
    if (is_there || steps == done.end() || !steps->second.contains("comparison")) continue;
    const fs::path& folder = workflow.Find(recordings.Name())->folder;
    options.people.push_back(recordings.participant);
    options.comparisons.push_back(folder / "comparison");
    if (options.human_only) continue;
    const auto worn = study::ReadStudyFile(folder / "study.yaml").worn;
    if (!worn)
      throw Fail(
          "cohort.yaml: 'population' uses the exo trials: name the design that was worn with study: {{design: {{worn: "
          "FILE}}}}, or leave them out with population: {{human_only: true}}");
    options.worn.push_back(*worn);
  }
}

steps::StudyStep PopulationStep(const Cohort& cohort, const Workflow& workflow, const StepsDone& done) {
  commands::OptimizeRunOptions options;
  options.problem = cohort.population->design.problem;
  options.study = cohort.population->search;
  if (cohort.population->design.file) options.problem_file = *cohort.population->design.file;
  commands::ReoptimizeRunOptions& reoptimize = options.reoptimize.emplace(cohort.population->options);
  if (reoptimize.sizes && cohort.has_heights) reoptimize.participants = cohort.folder / "participants.tsv";
  AddPeople(cohort, workflow, done, reoptimize);
  if (reoptimize.people.size() < 2)
    throw Fail("a design for many needs the comparisons of two participants at least, and there is {}",
               reoptimize.people.empty() ? "none" : "one");
  steps::StudyStep step{.name = kPopulationStep,
                        .what = "the design for all participants",
                        .program = "lake-optimize",
                        .folder = workflow.out / "group" / kPopulationStep,
                        .options = {{"population", cohort.population->section.text}, {"people", reoptimize.people}},
                        .expected = {.seconds = static_cast<double>(reoptimize.people.size())}};
  for (const InputFile& input : InputsOf(options)) step.inputs.push_back(input.path);
  step.work = [options](Run& run) {
    commands::OptimizeRunOptions work = options;
    work.study.quiet = work.study.optimize.quiet = run.Quiet();
    run.WriteSummary(commands::RunOptimize(work, run));
  };
  return step;
}

}  // namespace

void RunPopulation(const Cohort& cohort, const Workflow& workflow, const StepsDone& done, const Run& run) {
  steps::RunSteps(
      {PopulationStep(cohort, workflow, done)},
      {.command = run.Head()["command"], .quiet = run.Quiet(), .subject = {(cohort.folder / "cohort.yaml").string()}});
}

}  // namespace lake::cohort
