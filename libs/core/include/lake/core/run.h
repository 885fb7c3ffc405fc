// One run of one program: where its results go, what it read, what it warned of, and the summary that says so.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/progress.h"

namespace lake {

class Run {
 public:
  struct Info {
    std::string program;            // lake-track
    std::string command;            // the whole command line
    Json options = Json::object();  // the effective options
    std::filesystem::path out;      // folder for the results; created when the first result is written
    bool quiet = false;
  };
  explicit Run(Info info);

  bool Quiet() const { return info_.quiet; }

  // The full path of a result; creates the folder. Throws Error if that cannot be done or it is not writable.
  std::filesystem::path Result(const std::string& name);
  const std::filesystem::path& Folder() const { return info_.out; }

  // Says it on stderr (also when quiet: it is part of the result) and keeps it for the summary.
  void Warn(const std::string& text);
  const std::vector<std::string>& Warnings() const { return warnings_; }

  // Records a file that was read, with its content hash.
  void AddInput(const std::filesystem::path& path);

  // What made the results, as a summary begins: program, version, command, options, inputs, warnings, as known so far.
  Json Head() const;

  // The head, then the given results; written as summary.json and returned.
  Json WriteSummary(const Json& results);

 private:
  Info info_;
  std::vector<std::string> warnings_;
  Json inputs_ = Json::array();
};

}  // namespace lake
