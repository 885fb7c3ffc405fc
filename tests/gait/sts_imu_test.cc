// Two people's sit-to-stands: knee and thigh markers in a video without intrinsics and without an ankle, and a
// thigh-worn IMU.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "lake/camera/homography.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/gait/butterworth.h"
#include "lake/gait/leg_angles.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

constexpr double kRateHz = 50, kCutoffHz = 1;

struct Row {
  double frame, time_s;
  Eigen::Vector2d pixel;
};

// frame, s, x px, y px; tab, decimal comma.
std::vector<Row> ReadRows(const fs::path& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', '.');
    std::vector<double> numbers;
    for (const std::string& cell : SplitText(line, '\t')) numbers.push_back(ParseNumber(cell).value());
    rows.push_back({numbers.at(0), numbers.at(1), {numbers.at(2), numbers.at(3)}});
  }
  return rows;
}

struct Signal {
  std::vector<double> time_s, value;
};

Signal Resample(const Signal& signal) {
  Signal uniform;
  std::size_t i = 0;
  for (double t = signal.time_s.front(); t < signal.time_s.back(); t += 1 / kRateHz) {
    while (signal.time_s[i + 1] < t) ++i;
    const double u = (t - signal.time_s[i]) / (signal.time_s[i + 1] - signal.time_s[i]);
    uniform.time_s.push_back(t), uniform.value.push_back(std::lerp(signal.value[i], signal.value[i + 1], u));
  }
  return uniform;
}

Signal LowPass(Signal signal) {
  signal.value = gait::ZeroPhaseButterworth(signal.value, kRateHz, kCutoffHz);
  return signal;
}

// Backward lean of the thigh from the vertical: 0° standing, 90° seated. The picture lies sideways: the plane's second
// axis, along the picture's x, is up.
Signal ThighOfVideo(const fs::path& folder) {
  const std::vector<Row> corners = ReadRows(folder / "calib.txt");
  const Eigen::Vector2d corners_mm[] = {{0, 0}, {0, 740}, {590, 0}, {590, 740}};
  std::vector<camera::PlaneCorrespondence> points;
  for (std::size_t i = 0; i < 4; ++i) points.push_back({corners.at(i).pixel, corners_mm[i]});
  const camera::HomographyFit plane = camera::PlaneHomography(points);
  std::map<double, Row> thigh;
  for (const Row& row : ReadRows(folder / "thigh.txt")) thigh[row.frame] = row;
  Signal signal;
  for (const Row& knee : ReadRows(folder / "knee.txt")) {
    if (!thigh.contains(knee.frame)) continue;
    const Eigen::Vector2d kh =
        camera::ApplyHomography(plane, thigh[knee.frame].pixel) - camera::ApplyHomography(plane, knee.pixel);
    signal.time_s.push_back(knee.time_s);
    signal.value.push_back(gait::SegmentAngleDeg({-kh.x(), kh.y()}));
  }
  return Resample(signal);
}

// The same from gravity in the sensor, its x down the thigh and its z to the front, after the low-pass.
Signal ThighOfImu(const fs::path& folder) {
  const CsvTable table = CsvTable::Read(folder / "sensors.csv");
  Signal along, front;
  const std::size_t time = table.Column("Time (s)"), x = table.Column("Accelerometer X (g)"),
                    z = table.Column("Accelerometer Z (g)");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    along.time_s.push_back(table.RequiredNumber(row, time)), along.value.push_back(table.RequiredNumber(row, x));
    front.value.push_back(table.RequiredNumber(row, z));
  }
  front.time_s = along.time_s;
  along = LowPass(Resample(along)), front = LowPass(Resample(front));
  for (std::size_t i = 0; i < along.value.size(); ++i)
    along.value[i] = DegreesFromRadians(std::atan2(front.value[i], -along.value[i]));
  return along;
}

struct Agreement {
  double correlation = 0, rmse_deg = 0;
};

// At the best lag, as the clocks are not the same. The marker line and the sensor sit on the thigh at a fixed angle to
// each other, which is taken off.
Agreement Compare(const Signal& video, const Signal& imu) {
  Agreement best;
  const std::size_t n = video.value.size();
  const double mean_v = Mean(video.value), sd_v = StandardDeviation(video.value);
  for (std::size_t lag = 0; lag + n <= imu.value.size(); ++lag) {
    const std::vector<double> part(imu.value.begin() + static_cast<std::ptrdiff_t>(lag),
                                   imu.value.begin() + static_cast<std::ptrdiff_t>(lag + n));
    const double mean_i = Mean(part), sd_i = StandardDeviation(part);
    double product = 0, square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      product += (video.value[i] - mean_v) * (part[i] - mean_i);
      square += std::pow(video.value[i] - mean_v - part[i] + mean_i, 2);
    }
    const double correlation = product / (static_cast<double>(n - 1) * sd_v * sd_i);
    if (correlation > best.correlation) best = {correlation, std::sqrt(square / static_cast<double>(n))};
  }
  return best;
}

class ThighMarkersAndImu : public testing::TestWithParam<const char*> {};

TEST_P(ThighMarkersAndImu, Agree) {
  const fs::path data = SharedData() / "sts_markers_imu/data";
  if (!fs::exists(data)) GTEST_SKIP() << data.string() << " is not here";
  const Signal video = LowPass(ThighOfVideo(data / "video" / GetParam()));
  const Signal imu = ThighOfImu(data / "NGIMU" / GetParam() / "NGIMU - 002D50FB");
  const Agreement agreement = Compare(video, imu);
  EXPECT_GE(agreement.correlation, 0.99);
  EXPECT_LE(agreement.rmse_deg, 4);
  RecordProperty("rmse_deg", std::to_string(agreement.rmse_deg));
}

INSTANTIATE_TEST_SUITE_P(, ThighMarkersAndImu, testing::Values("participant1", "participant2"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace lake
