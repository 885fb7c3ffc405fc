#include "review_comparison.h"

#include <utility>
#include <vector>

#include "lake/commands/tracked_folder.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "result_inputs.h"

namespace lake::commands {

namespace fs = std::filesystem;

namespace {

review::ComparedVideo ReadVideo(const fs::path& folder, const std::string& marker) {
  TrackedFolder tracked = ReadTrackedFolder(folder);
  review::ComparedVideo trial;
  trial.name = fs::path(tracked.options.video).filename().string(), trial.marker = marker;
  trial.video = tracked.options.video, trial.reader = tracked.options.track.reader;
  trial.tracks = motion::ReadMarkerCsv(folder / "tracks.csv");
  trial.motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  return trial;
}

// The human's, then the exoskeleton's; once where both markers are in one recording.
std::vector<fs::path> TrialFolders(const Json& inputs, const fs::path& folder) {
  std::vector<fs::path> folders;
  for (const Json& input : inputs)
    if (fs::path(input.at("path").get<std::string>()).filename() == "kinematics.csv")
      folders.push_back(FindInput(input, folder).parent_path());
  if (folders.size() == 1) folders.push_back(folders.front());
  if (folders.size() != 2)
    throw Fail("{}: compares files without a video; lake review shows comparisons of two lake-track folders",
               folder.string());
  return folders;
}

Json CurvesOf(const fs::path& folder, const Json& summary) {
  const CsvTable table = CsvTable::Read(folder / "misalignment.csv");
  Json curves = Json::object();
  for (const char* name : {"percent", "distance_mm", "human_knee_deg", "exo_knee_deg", "spike"}) {
    const std::size_t column = table.Column(name);
    Json& values = curves[name] = Json::array();
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      const auto number = table.Number(row, column);
      values.push_back(number ? Json(*number) : Json());
    }
  }
  const Json& parts = summary.at("decomposition");
  curves["rms_mm"] = summary.at("metrics").at("rms_mm");
  for (const char* part : {"placement", "timing", "shape"}) curves["parts"][part] = parts.at(part).at("fraction");
  return curves;
}

}  // namespace

review::ComparedPair ReadComparedPair(const fs::path& folder) {
  const Json summary = ReadSummary(folder / "summary.json");
  try {
    const std::vector<fs::path> trials = TrialFolders(summary.at("inputs"), folder);
    const Json& markers = summary.at("markers");
    const fs::path name = folder.has_filename() ? folder : folder.parent_path();
    return {name.filename().string(), ReadVideo(trials.front(), markers.at("human")),
            ReadVideo(trials.back(), markers.at("exo")), CurvesOf(folder, summary)};
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake compare writes it ({})", (folder / "summary.json").string(), error.what());
  }
}

}  // namespace lake::commands
