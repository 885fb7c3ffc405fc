// A recorded motion, rendered: its truth is the recording.
#include <filesystem>
#include <fstream>
#include <sstream>

#include "lake/core/csv.h"
#include "lake/synth/scene.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// Right leg of a TRC file in its x–y plane: ankle, knee, hip and the middle of the pelvis' front and back as waist. mm.
MotionTable ReadRightLeg(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < 4; ++i) std::getline(file, line);  // the fourth line holds the names
  std::map<std::string, std::size_t> column;
  std::istringstream names(line);
  std::size_t index = 0;
  for (std::string cell; std::getline(names, cell, '\t'); ++index) column[cell] = index;
  MotionTable table{{}, {"ankle", "knee", "hip", "waist"}, std::vector<std::vector<Eigen::Vector2d>>(4)};
  while (std::getline(file, line)) {
    std::vector<std::optional<double>> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '\t');) cells.push_back(ParseNumber(cell));
    if (cells.size() < 6 || !cells[1]) continue;
    const auto at = [&](const char* name) {
      return Eigen::Vector2d(*cells.at(column.at(name)), *cells.at(column.at(name) + 1));
    };
    table.time_s.push_back(*cells[1]);
    table.positions[0].push_back(at("r_ankle"));
    table.positions[1].push_back(at("r_knee"));
    table.positions[2].push_back(at("R_HJC"));
    table.positions[3].push_back(0.5 * (at("r.ASIS") + at("r.PSIS")));
  }
  return table;
}

TEST(RealMotion, RendersWithTheRecordingsOwnAnglesAndFiveStandUps) {
  const fs::path folder = fs::path(LAKE_SHARED_DATA) / "opencap_sts";
  fs::path trc;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".trc") trc = entry.path();
  if (trc.empty()) GTEST_SKIP() << "no recording at " << folder;
  const MotionTable table = ReadRightLeg(trc);
  ASSERT_EQ(table.time_s.size(), 861u);
  for (const bool mirror : {false, true}) {
    SceneOptions options = CleanScene(1);
    options.duration_s = 0;
    options.frame_rate_hz = 100;  // as recorded, so that frames meet rows
    const Scene scene(options, MakeTableMotion(table, mirror));
    EXPECT_EQ(scene.Motion().FacingInImage(), mirror ? Facing::kLeft : Facing::kRight);
    ASSERT_EQ(scene.Frames(), 860);
    std::vector<double> falls_through_35;
    double lowest = 1e9, highest = -1e9, last = 0;
    for (int frame = 0; frame < scene.Frames(); ++frame) {
      const FrameTruth truth = scene.Truth(frame);
      const auto& p = table.positions;
      EXPECT_NEAR(truth.knee_deg, KneeAngleDeg(p[0][frame], p[1][frame], p[2][frame], Facing::kRight), 1e-6);
      for (const MarkerTruth& marker : truth.markers) EXPECT_TRUE(marker.visible) << frame;
      lowest = std::min(lowest, truth.knee_deg), highest = std::max(highest, truth.knee_deg);
      if (frame > 0 && last > 35 && truth.knee_deg <= 35) falls_through_35.push_back(table.time_s[frame]);
      last = truth.knee_deg;
    }
    EXPECT_NEAR(lowest, 4.2, 0.1);  // the data's README: 4.2..95.7° in the x–y plane
    EXPECT_NEAR(highest, 95.7, 0.1);
    const double listed[] = {0.76, 2.44, 4.09, 5.61, 7.24};  // of the 3-D angle, ±0.05 s
    ASSERT_EQ(falls_through_35.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(falls_through_35[i], listed[i], 0.1);
  }
}

}  // namespace
}  // namespace lake
