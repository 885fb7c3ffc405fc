// One run of one program: its folder of results, its inputs, its warnings and its summary.
//
// A folder holds the results of one run of a program. A list beside them (.PROGRAM.lake-files.json) names the run and
// its files, so that the program's next run there removes exactly these.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/progress.h"

namespace lake {

class FolderLock;
struct ResultsList;

// A file or folder that a program's options name, and its role there: "camera".
struct InputFile {
  std::filesystem::path path;
  std::string role;
  bool is_alternative = false;  // read only where the one before it is absent
};

class Run {
 public:
  struct Info {
    std::string program;            // lake-track
    std::string command;            // the whole command line
    Json options = Json::object();  // the effective options
    std::filesystem::path out;      // folder for the results; created when the run begins
    bool quiet = false;
    std::vector<std::string> subject = {};  // what the results are of: files as the user named them, absolute
    bool default_folder = false;            // `out` was not given: results of another subject there are not replaced
    std::string step = {};                  // the step of a study that this run is; empty: a run by itself
    std::vector<std::string> given = {};    // those of `options` that a command line gave, by their names
  };
  explicit Run(Info info);
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  // Removes the list and the folder of a run that wrote no result.
  ~Run();

  bool Quiet() const { return info_.quiet; }

  // Call it once the input has been checked and before long work. Locks the folder, removes the results of the
  // program's last run there, the summary first, and reserves these names for results. Files that this run reads stay
  // until the new result replaces them. The first Result() calls Begin() if nothing did before. Throws Error, and
  // nothing is changed: another run is at work in the folder; it holds another program's results, a file of such a name
  // that this program did not write or, as a default folder, another subject's results; it is not writable.
  void Begin(const std::vector<std::string>& names = {});

  // Locks the folder and changes nothing in it, for a run that goes on with what is there. Throws Error: another run is
  // at work in it; it is not writable.
  void TakeFolder();

  // The full path of a result ("tracks.csv", "predicted/comparison.json"); creates the folder. Throws as Begin().
  std::filesystem::path Result(const std::string& name);
  const std::filesystem::path& Folder() const { return info_.out; }

  // Leaves the folder to another program, whose results stand beside this one's; this run goes on in its own files.
  void ReleaseFolder() { lock_.reset(); }

  // The results that were written so far.
  std::vector<std::filesystem::path> Results() const;

  // Writes a warning to stderr, also when quiet, and keeps it for the summary.
  void Warn(const std::string& text);
  template <typename... Args>
  requires(sizeof...(Args) > 0) void Warn(fmt::format_string<Args...> format, Args&&... args) {
    Warn(fmt::format(format, std::forward<Args>(args)...));
  }
  const std::vector<std::string>& Warnings() const { return warnings_; }

  // Lines for the person at the terminal: the main numbers. The program prints them once its results are written.
  void Report(const std::string& lines) { report_ += lines; }
  template <typename... Args>
  requires(sizeof...(Args) > 0) void Report(fmt::format_string<Args...> format, Args&&... args) {
    Report(fmt::format(format, std::forward<Args>(args)...));
  }
  const std::string& ReportText() const { return report_; }

  // What was judged does not hold: the results are written as ever, but the program exits with 1.
  void Reject() { is_rejected_ = true; }
  bool IsRejected() const { return is_rejected_; }

  // Records the files that are read, with their content hashes. Missing files are left to their readers to report.
  void AddInput(const std::filesystem::path& path, const std::string& role);
  void AddInputs(const std::vector<InputFile>& inputs);

  // The first entries of a summary, as known so far: program, version, command, options, the options given, inputs
  // (path, sha256, role), warnings.
  Json Head() const;

  // The head, then the given results; written as summary.json and returned.
  Json WriteSummary(const Json& results);

 private:
  void Retire(ResultsList old);
  void CheckIsFree(const std::string& name) const;
  void WriteList() const;
  std::string SubjectText() const;

  Info info_;
  std::vector<std::string> warnings_;
  std::string report_;
  Json inputs_ = Json::array();
  std::shared_ptr<FolderLock> lock_;  // held from TakeFolder() or Begin() on
  bool begun_ = false;
  bool is_rejected_ = false;
  bool made_folder_ = false;
  bool older_version_ = false;  // results of this program without a list that can be read
  std::set<std::string> files_;
};

// A file among the results in a folder; nullopt if there is none of that name. In a folder without a list of results
// any file will do. Throws Error for one that does not belong to the results listed there, and where the run that left
// it did not finish.
std::optional<std::filesystem::path> FindResult(const std::filesystem::path& folder, const std::string& name);

// The results that the lists in a folder name and that are there.
std::vector<std::string> ResultsIn(const std::filesystem::path& folder);

// Removes what this step of a study left in the folder, if the folder's results are that step's.
void RetireStep(const std::filesystem::path& folder, const std::string& step);

}  // namespace lake
