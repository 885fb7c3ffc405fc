#include "comparison_review.h"

#include <array>
#include <utility>

#include "lake/commands/compare.h"
#include "lake/compare/registration.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/json_or_null.h"
#include "lake/reviewing/tracked_folder.h"
#include "result_inputs.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

// Each rise at 0 to 100 %, as it was compared: the compared joint in the leg frame, mm, and the knee angle.
Json RisesOf(const fs::path& folder, const std::string& marker, const Eigen::Vector2d& marker_at_mm) {
  Run reading({"lake-review", "", Json::object(), folder, true});
  compare::RegistrationOptions registration;
  registration.knee = marker;
  registration.marker_at_mm = marker_at_mm;
  const compare::RegisteredTrial trial =
      compare::RegisterTrial(commands::ReadTrialTables(folder, {}, marker, reading), registration);
  Json rises = Json::array();
  for (const compare::StsCurve& curve : trial.repetitions) {
    Json rise = {{"repetition", curve.repetition}, {"knee_deg", curve.knee_deg}};
    for (const Eigen::Vector2d& knee : curve.knee) {
      rise["x"].push_back(knee.x());
      rise["y"].push_back(knee.y());
    }
    rises.push_back(std::move(rise));
  }
  return rises;
}

review::ComparedVideo ReadVideo(const fs::path& folder, const std::string& marker,
                                const Eigen::Vector2d& marker_at_mm) {
  TrackedFolder tracked = ReadTrackedFolder(folder);
  review::ComparedVideo trial;
  trial.name = fs::path(tracked.options.video).filename().string();
  trial.marker = marker;
  trial.video = tracked.options.video;
  trial.reader = tracked.options.track.reader;
  trial.tracks = motion::ReadMarkerCsv(folder / "tracks.csv");
  trial.motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  trial.rises = RisesOf(folder, marker, marker_at_mm);
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
      values.push_back(ValueOrNull(number));
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
    const auto joint_at_mm = summary.value("joint_at_mm", std::array<double, 2>{0, 0});  // of older comparisons: none
    return {name.filename().string(), ReadVideo(human, markers.at("human"), Eigen::Vector2d::Zero()),
            ReadVideo(exo, markers.at("exo"), {joint_at_mm[0], joint_at_mm[1]}), CurvesOf(folder, summary)};
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake compare writes it ({})", (folder / "summary.json").string(), error.what());
  }
}

}  // namespace lake::reviewing
