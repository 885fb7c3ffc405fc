#include "comparison_review.h"

#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/reviewing/tracked_folder.h"
#include "result_inputs.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

review::ComparedVideo ReadVideo(const fs::path& folder, const std::string& marker) {
  TrackedFolder tracked = ReadTrackedFolder(folder);
  review::ComparedVideo trial;
  trial.name = fs::path(tracked.options.video).filename().string();
  trial.marker = marker;
  trial.video = tracked.options.video;
  trial.reader = tracked.options.track.reader;
  trial.tracks = motion::ReadMarkerCsv(folder / "tracks.csv");
  trial.motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  return trial;
}

// Of a trial that was compared.
fs::path TrialFolder(const Json& summary, const std::string& role, const fs::path& folder) {
  if (!InputOf(summary, role + " motion"))
    throw Fail("{}: compares files without a video; lake review shows comparisons of two lake-track folders",
               folder.string());
  return FindInput(summary, role + " motion", folder).parent_path();
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
    const fs::path human = TrialFolder(summary, "human", folder), exo = TrialFolder(summary, "exo", folder);
    const Json& markers = summary.at("markers");
    const fs::path name = folder.has_filename() ? folder : folder.parent_path();
    return {name.filename().string(), ReadVideo(human, markers.at("human")), ReadVideo(exo, markers.at("exo")),
            CurvesOf(folder, summary)};
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake compare writes it ({})", (folder / "summary.json").string(), error.what());
  }
}

}  // namespace lake::reviewing
