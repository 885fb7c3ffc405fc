// lake-run: a whole study, from the recordings to a better exoskeleton and a report.
#include <optional>
#include <string>

#include "lake/study/study.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-run", "A whole study: both trials, misalignment, designs, simulation, one report",
                        "lake-run data/sts-study/study.yaml");
  std::string file;
  program.Cli().add_option("study", file, "study.yaml")->required();
  std::optional<lake::study::StudyFile> study;
  return program.Main(
      argc, argv,
      [&] {
        study = lake::study::ReadStudyFile(file);
        return study->ResultName();
      },
      [&](lake::Run& run) { return lake::study::RunStudyFile(*study, run); }, lake::study::StudyText);
}
