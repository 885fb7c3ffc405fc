// What a trial's tables call measured is each frame's own measurement, and what is fitted again starts from it.
#include <gmock/gmock.h>

#include "lake/commands/gait.h"
#include "lake/core/atomic_file.h"
#include "lake/exchange/formats.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

// RMS of a column of kinematics.csv.
double RootMeanSquare(const CsvTable& table, const char* column) {
  double sum = 0;
  int count = 0;
  for (std::size_t row = 0; row < table.Rows(); ++row)
    if (const auto value = table.Number(row, table.Column(column))) sum += *value * *value, ++count;
  return RootMean(sum, count);
}

// Of the difference between two columns where both have a value.
double RootMeanSquare(const CsvTable& a, const char* of_a, const CsvTable& b, const char* of_b) {
  double sum = 0;
  int count = 0;
  for (std::size_t row = 0; row < a.Rows(); ++row) {
    const auto x = a.Number(row, a.Column(of_a)), y = b.Number(row, b.Column(of_b));
    if (x && y) sum += std::pow(*x - *y, 2), ++count;
  }
  return RootMean(sum, count);
}

void FitFolder(RenderedTrial& trial, const std::string& name, motion::MarkerValues values) {
  commands::GaitRunOptions options;
  options.trial = trial.folder / "trial";
  options.reading.values = values;
  Run run({"lake-gait", "test", Json::object(), trial.folder / name, true});
  run.WriteSummary(commands::RunGait(options, run));
}

TEST(Measured, IsWhatTheTablesHoldAndWhatFitsStartFrom) {
  synth::SceneOptions scene = CleanLeg(72277);
  scene.duration_s = 4;
  RenderedTrial trial(scene, {.crf = 23});
  trial.Track("trial", [](commands::TrackRunOptions& options) { options.exports = {"trc"}; });
  trial.Track("none", [](commands::TrackRunOptions& options) { options.fit.filter = gait::LegFilter::kNone; });
  const motion::MarkerRecording tracks = trial.Tracks(), unfiltered = trial.Tracks("none");
  const auto table = trial.folder / "trial" / "trajectory.csv";
  const motion::MarkerRecording measured = motion::ReadMarkerCsv(table),
                                estimated = motion::ReadMarkerCsv(table, motion::MarkerValues::kEstimated);
  const exchange::PointRecording exported = exchange::ReadPoints(trial.folder / "trial" / "video.trc");
  for (std::size_t m = 0; m < tracks.markers.size(); ++m)
    for (std::size_t i = 0; i < tracks.Frames(); ++i) {
      ASSERT_EQ(tracks.markers[m].samples[i].position, unfiltered.markers[m].samples[i].position);
      const Eigen::Vector2d raw = measured.markers[m].samples[i].position;
      ASSERT_NE(raw, estimated.markers[m].samples[i].position);
      ASSERT_LE((exported.points[m].positions[i].head<2>() - raw).norm(), 1e-4);  // TRC's digits
    }

  FitFolder(trial, "again", motion::MarkerValues::kMeasured);
  FitFolder(trial, "twice", motion::MarkerValues::kEstimated);
  const CsvTable once = CsvTable::Read(trial.folder / "trial" / "kinematics.csv"),
                 again = CsvTable::Read(trial.folder / "again" / "kinematics.csv"),
                 twice = CsvTable::Read(trial.folder / "twice" / "kinematics.csv");
  EXPECT_LE(RootMeanSquare(once, "knee_raw_deg", again, "knee_raw_deg"), 1e-9);
  // The weights differ only by how the lens turns a circle of 0.01 px into an ellipse.
  EXPECT_LE(RootMeanSquare(once, "knee_deg", again, "knee_deg"), 0.1 * RootMeanSquare(once, "knee_sigma_deg"));
  EXPECT_NEAR(RootMeanSquare(again, "knee_sigma_deg") / RootMeanSquare(once, "knee_sigma_deg"), 1, 0.1);
  EXPECT_GE(RootMeanSquare(again, "knee_raw_deg", again, "knee_deg"), 0.003) << "its raw angle is not raw";
  EXPECT_LE(RootMeanSquare(twice, "knee_raw_deg", once, "knee_deg"), 1e-6) << "asked for the fit's estimates";
}

// As a marker that was lost, and filled with its last place, comes from other programs.
TEST(FrozenMarkers, AreToldOf) {
  const TemporaryFolder folder;
  motion::MarkerRecording trial;
  trial.unit = motion::LengthUnit::kMm;
  trial.markers = {{"ankle", {}}, {"knee", {}}, {"hip", {}}};
  for (int i = 0; i < 300; ++i) {
    trial.frame.push_back(i);
    trial.time_s.push_back(i / 100.0);
    const double u = 0.5 - 0.5 * std::cos(i / 25.0), noise = 0.1 * std::sin(7.3 * i * i);
    trial.markers[0].samples.push_back({{0, 90}, 0, motion::SampleStatus::kDetected});
    trial.markers[1].samples.push_back({{40 * u, 520 + noise}, 0, motion::SampleStatus::kDetected});
    trial.markers[2].samples.push_back(
        {{40 * u - 400 * std::sin(1.5 * u), 520 + 400 * std::cos(1.5 * u)}, 0, motion::SampleStatus::kDetected});
  }
  motion::WriteMarkerCsv(folder / "trial.csv", trial);
  commands::GaitRunOptions options;
  options.trial = folder / "trial.csv";
  lake::Run run({"lake-gait", "test", Json::object(), folder / "gait", true});
  run.WriteSummary(commands::RunGait(options, run));
  EXPECT_THAT(ReadTextFile(folder / "gait" / "summary.json"),
              testing::HasSubstr("marker 'ankle' has the same coordinates to the last digit in all its 300 frames"));
}

}  // namespace
}  // namespace lake
