#include "lake/motion/saved_corrections.h"

#include <fmt/format.h>

#include "lake/core/counted.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"
#include "lake/core/shell_word.h"

namespace lake::motion {
namespace {

namespace fs = std::filesystem;

struct Saved {
  std::size_t rows = 0;
  bool is_applied = true;
};

// `role`: of the file among the inputs of the summary. A file without rows says the same as none.
Saved SavedIn(const fs::path& file, const std::string& role, const Json& summary) {
  if (!fs::is_regular_file(file)) return {};
  const std::size_t rows = CsvTable::Read(file).Rows();
  for (const Json& input : summary.value("inputs", Json::array()))
    if (input.value("role", "") == role) return {rows, input.value("sha256", "") == Sha256OfFile(file)};
  return {rows, rows == 0};
}

std::string CommandIn(const fs::path& folder) {
  const std::string page = fmt::format("lake review {} shows the command", ShellWord(folder.string()));
  const fs::path review = folder / kReviewFile;
  return fs::is_regular_file(review) ? ReadJsonFile(review).value("command", page) : page;
}

}  // namespace

std::string UnappliedCorrections(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  if (!fs::is_regular_file(file)) return "";
  const Json summary = ReadJsonFile(file);
  if (summary.value("program", "") != "lake-track") return "";
  std::size_t count = 0;
  bool are_applied = true;
  for (const auto& [name, role] : {std::pair{kSavedCorrections, "corrections"}, {kSavedEvents, "events"}}) {
    const Saved saved = SavedIn(folder / name, role, summary);
    if (saved.is_applied) continue;
    are_applied = false;
    count += saved.rows;
  }
  if (are_applied) return "";
  const std::string what = count == 0
                               ? "was tracked with corrections that were taken back since"
                               : fmt::format("was not tracked with the {} saved in it", Counted(count, "correction"));
  return fmt::format("{}: {}. To track it anew: {}", folder.empty() ? "." : folder.string(), what, CommandIn(folder));
}

}  // namespace lake::motion
