// lake-run: a whole study, from the recordings to a better exoskeleton and a report.
#include <optional>
#include <string>

#include "lake/pipeline/study.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-run", "A whole study: both trials, misalignment, designs, simulation, one report",
                        "lake-run data/sts-study/study.yaml");
  std::string file;
  program.Cli().add_option("study", file, "study.yaml")->required();
  std::optional<lake::StudyFile> study;
  return program.Main(
      argc, argv,
      [&] {
        study = lake::ReadStudyFile(file);
        return study->ResultName();
      },
      [&](lake::Run& run) { return lake::RunStudyFile(*study, run); }, lake::StudyText);
}
