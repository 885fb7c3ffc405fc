// One run of one program: its folder of results, its inputs, its warnings and its summary.
//
// A folder holds the results of one run of a program. A list beside them (.PROGRAM.lake-files.json) names the run and
// its files, so that the program's next run there replaces exactly these. A run writes into a hidden folder there and
// takes the place of the last one's results when its own are complete; until then these stay as they are. Where it
// fails, what it wrote goes to the folder "failed" beside them, or into the place where there are none.
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
  // Of a run that did not publish its results: keeps what it wrote as that of a failed run. Removes the folder of one
  // that wrote nothing.
  ~Run();

  bool Quiet() const { return info_.quiet; }

  // Call it once the input has been checked and before long work. Locks the folder and reserves these names for
  // results. The first Result() calls Begin() if nothing did before. Throws Error, and nothing is changed: another run
  // is at work in the folder; it holds another program's results, a file of such a name that this program did not write
  // or, as a default folder, another subject's results; it is not writable.
  void Begin(const std::vector<std::string>& names = {});

  // Puts the results in the place of those of the program's last run there, the summary last; of those, files that this
  // run read and did not write stay. Later results are written in their place at once. Throws Error if a file cannot be
  // replaced.
  void Publish();

  // Locks the folder and changes nothing in it, for a run that goes on with what is there. Throws Error: another run is
  // at work in it; it is not writable.
  void TakeFolder();

  // Where to write a result ("tracks.csv", "predicted/comparison.json") until it is published; creates the folder.
  // Throws as Begin().
  std::filesystem::path Result(const std::string& name);

  // The folder that Result() writes into.
  std::filesystem::path Place() const;

  // The folder of the results once they are published, and, of a run that has begun, that of what it leaves if it
  // fails.
  const std::filesystem::path& Folder() const { return info_.out; }
  std::filesystem::path FolderIfFailed() const;

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

  // The head, then the given results; written as summary.json, published with all others, and returned.
  Json WriteSummary(const Json& results);

  // Instead, of a run that failed for this reason, which stands as `failed` in the summary.
  void WriteFailedSummary(const Json& results, const std::string& reason);

 private:
  void TakeOver();
  void CheckIsFree(const std::string& name) const;
  bool IsReadHere(const std::string& name) const;
  Json MakeSummary(const Json& results) const;
  std::vector<std::string> Written() const;
  void Exchange(bool is_complete);
  void SetAside();
  void Abandon();
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
  bool is_published_ = false;
  std::set<std::string> files_;
  std::unique_ptr<ResultsList> old_;  // of the program's last run there
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
