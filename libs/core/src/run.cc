#include "lake/core/run.h"

#include <unistd.h>

#include <cstdio>

#include "lake/core/error.h"
#include "lake/core/provenance.h"

namespace lake {
namespace fs = std::filesystem;

Run::Run(Info info) : info_(std::move(info)) {}

fs::path Run::Result(const std::string& name) {
  std::error_code error;
  fs::create_directories(info_.out, error);
  if (error) throw Fail("{}: the output folder cannot be made: {}", info_.out.string(), error.message());
  if (access(info_.out.c_str(), W_OK | X_OK) != 0)
    throw Fail("{}: the output folder is not writable; choose another with -o", info_.out.string());
  return info_.out / name;
}

void Run::Warn(const std::string& text) {
  warnings_.push_back(text);
  fmt::print(stderr, "{}: warning: {}\n", info_.program, text);
}

void Run::AddInput(const fs::path& path) {
  inputs_.push_back({{"path", path.string()}, {"sha256", Sha256OfFile(path)}});
}

Json Run::Head() const {
  return {{"program", info_.program}, {"version", Version()},     {"commit", Commit()}, {"tree", SourceTree()},
          {"command", info_.command}, {"options", info_.options}, {"inputs", inputs_},  {"warnings", warnings_}};
}

Json Run::WriteSummary(const Json& results) {
  Json summary = Head();
  summary.update(results);
  WriteJsonFile(Result("summary.json"), summary);
  return summary;
}

}  // namespace lake
