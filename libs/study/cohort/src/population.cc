#include "population.h"

#include <algorithm>

#include "lake/commands/optimize.h"
#include "lake/core/error.h"
#include "lake/steps/study_steps.h"
#include "workflow.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

// Each participant's first recordings whose comparison has been done, with the design that was worn.
void AddPeople(const Cohort& cohort, const Json& workflow, const fs::path& out,
               commands::ReoptimizeRunOptions& options) {
  for (const Recordings& recordings : cohort.recordings) {
    const bool is_there = std::ranges::find(options.people, recordings.participant) != options.people.end();
    if (is_there || !workflow["recordings"].contains(recordings.Name()) ||
        !IsDone(out, recordings.Name(), "comparison"))
      continue;
    const fs::path folder = workflow["recordings"][recordings.Name()]["folder"].get<std::string>();
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

steps::StudyStep PopulationStep(const Cohort& cohort, const Json& workflow, const fs::path& out) {
  commands::OptimizeRunOptions options;
  options.problem = cohort.population->design.problem;
  options.study = cohort.population->search;
  commands::ReoptimizeRunOptions& reoptimize = options.reoptimize.emplace(cohort.population->options);
  AddPeople(cohort, workflow, out, reoptimize);
  if (reoptimize.people.size() < 2)
    throw Fail("a design for many needs the comparisons of two participants at least, and there is {}",
               reoptimize.people.empty() ? "none" : "one");
  steps::StudyStep step{kPopulationStep,
                        "the design for all participants",
                        "lake-optimize",
                        out / "group" / kPopulationStep,
                        {},
                        {},
                        {{"population", cohort.population->said}, {"people", reoptimize.people}},
                        static_cast<double>(reoptimize.people.size()),
                        {}};
  for (const fs::path& comparison : reoptimize.comparisons) step.inputs.push_back(comparison / "comparison.json");
  step.inputs.insert(step.inputs.end(), reoptimize.worn.begin(), reoptimize.worn.end());
  if (cohort.population->design.file) options.problem_file = *cohort.population->design.file;
  if (!options.problem_file.empty()) step.inputs.push_back(options.problem_file);
  if (reoptimize.sizes && cohort.has_heights) reoptimize.participants = cohort.folder / "participants.tsv";
  if (!reoptimize.participants.empty()) step.inputs.push_back(reoptimize.participants);
  step.work = [options](Run& run) {
    commands::OptimizeRunOptions work = options;
    work.study.quiet = work.study.optimize.quiet = run.Quiet();
    run.WriteSummary(commands::RunOptimize(work, run));
  };
  return step;
}

}  // namespace

void RunPopulation(const Cohort& cohort, const Json& workflow, const fs::path& out, const Run& run) {
  steps::StepRunOptions options;
  options.command = run.Head()["command"], options.quiet = run.Quiet();
  options.subject = {(cohort.folder / "cohort.yaml").string()};
  steps::RunStep({PopulationStep(cohort, workflow, out)}, kPopulationStep, options);
}

}  // namespace lake::cohort
