#include "study_review.h"

#include <string>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/results_subject.h"
#include "lake/core/shell_word.h"
#include "lake/gait/movement.h"
#include "lake/study/study.h"
#include "result_inputs.h"
#include "run_program.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

fs::path StudyFileOf(const Json& summary, const fs::path& folder) {
  const fs::path named = summary.at("options").at("study").get<std::string>();
  for (const fs::path& told : SubjectsOf(folder))
    if (told.filename() == named.filename() && fs::exists(told)) return told;
  for (const fs::path& place : WithAbove(fs::absolute(folder)))
    if (fs::exists(place / named)) return place / named;
  if (fs::exists(named)) return named;
  throw Fail("{}: is not to be found; start lake review in the folder in which {} was made", named.string(),
             folder.string());
}

review::StudyWork StudyWorkOf(const fs::path& folder, const std::optional<gait::MovementKind>& movement,
                              const fs::path& programs) {
  const fs::path program = programs / "lake-run";
  review::StudyWork work;
  fs::path file;
  try {
    const Json summary = ReadSummary(folder / "summary.json");
    work.name = summary.at("name");
    file = StudyFileOf(summary, folder);
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake run writes it ({})", (folder / "summary.json").string(), error.what());
  }
  work.report = folder / "report.html";
  work.folder = folder;
  std::vector<std::string> words = {file.string(), "-o", folder.string()};
  if (movement) words.insert(words.end(), {"--movement", gait::NameOf(*movement)});
  work.command = "lake run";
  for (const std::string& word : words) work.command += " " + ShellWord(word);
  work.plan = [file, folder, movement, program] {
    study::StudyFile study = study::ReadStudyFile(file);
    if (movement) study.SetMovement(*movement);
    return study::PlanJson(study::PlanStudy(study, folder, steps::StepRunOptions::ThisProgram(program)));
  };
  work.run = [words, program](const std::string& step, const review::BackgroundJob::Control& control) {
    std::vector<std::string> asked = words;
    if (!step.empty()) asked.insert(asked.end(), {"--only", step});
    RunProgram(program, asked, control);
  };
  return work;
}

}  // namespace lake::reviewing
