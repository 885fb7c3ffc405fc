#include "review_study.h"

#include <utility>
#include <vector>

#include "lake/core/child_program.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/json.h"
#include "lake/core/shell_word.h"
#include "result_inputs.h"

namespace lake::commands {

namespace fs = std::filesystem;

fs::path StudyFileOf(const Json& summary, const fs::path& folder) {
  const fs::path named = summary.at("options").at("study").get<std::string>();
  for (fs::path place = fs::absolute(folder).lexically_normal(); place.has_relative_path(); place = place.parent_path())
    if (fs::exists(place / named)) return place / named;
  if (fs::exists(named)) return named;
  throw Fail("{}: is not to be found; start lake review in the folder in which {} was made", named.string(),
             folder.string());
}

namespace {

Json PlanOf(const fs::path& program, const std::vector<std::string>& words) {
  std::vector<std::string> asked = words;
  asked.push_back("--plan");
  const ChildEnd end = RunChild(
      program, asked, [](const std::string&) {}, ThrowIfInterrupted);
  if (end.code != 0) throw Fail("lake-run ended with code {}: {}", end.code, end.last_line);
  Json plan = Json::parse(end.output, nullptr, false);
  if (plan.is_discarded()) throw Fail("lake-run --plan wrote what is no plan: {}", end.output);
  return plan;
}

}  // namespace

review::StudyWork StudyWorkOf(const fs::path& folder, const fs::path& programs) {
  const fs::path program = programs / "lake-run";
  review::StudyWork work;
  std::vector<std::string> words;
  try {
    const Json summary = ReadSummary(folder / "summary.json");
    work.name = summary.at("name");
    words = {StudyFileOf(summary, folder).string(), "-o", folder.string()};
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake run writes it ({})", (folder / "summary.json").string(), error.what());
  }
  work.report = folder / "report.html";
  work.command = "lake run";
  for (const std::string& word : words) work.command += fmt::format(" {}", ShellWord(word));
  work.plan = [program, words] { return PlanOf(program, words); };
  work.run = [program, words](const std::string& step, const review::BackgroundJob::Control& control) {
    std::vector<std::string> asked = words;
    if (!step.empty()) asked.insert(asked.end(), {"--only", step});
    const ChildEnd end = RunChild(program, asked, control.say, control.throw_if_stopped);
    if (end.code != 0) throw Fail("lake-run ended with code {}: {}", end.code, end.last_line);
  };
  return work;
}

}  // namespace lake::commands
