// Two clocks aligned: rises whose clocks are known, unrelated ones that must be refused, and people's recordings with
// force plates and an inertial sensor.
#include "lake/sync/align.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <map>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "message_of.h"
#include "places.h"
#include "recorded_rises.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kLeast_s = 0.002;  // what the project promises

TEST(AlignByMotion, FindsOffsetAndDriftOfTwoCameras) {
  int within = 0, count = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Rises rises(seed);
    Eigen::Matrix2d view;
    view << 0.7, 0.1, -0.05, -0.8;  // px, y down, seen from aside
    const Camera a{.rate_hz = seed % 2 ? 60.0 : 100.0}, b{.rate_hz = seed % 3 ? 30.0 : 240.0,
                                                          .view = view,
                                                          .from_s = 3.7,
                                                          .to_s = 26,
                                                          .offset_s = seed * 1.37 - 5,
                                                          .drift_ppm = 60.0 * seed - 250};
    const sync::Alignment found = sync::AlignByMotion(Record(rises, a, seed), Record(rises, b, seed + 100));
    // A's clock is the movement's: at B's first time the truth is offset + drift t.
    const double truth_s = b.offset_s + 1e-6 * b.drift_ppm * found.clock.from_s;
    EXPECT_NEAR(found.clock.offset_s, truth_s, kLeast_s) << seed;
    EXPECT_NEAR(found.clock.drift_ppm, b.drift_ppm, 4 * found.drift_sd_ppm + 5) << seed;
    EXPECT_LT(found.clock.sd_s, kLeast_s) << seed;
    ++count, within += std::abs(found.clock.offset_s - truth_s) < 2 * found.clock.sd_s ? 1 : 0;
  }
  EXPECT_GE(within, count - 1) << "of " << count << " within two SD";
}

TEST(AlignByMotion, TurnsRoundWithItsInputs) {
  const Rises rises(31);
  const sync::Movement a = Record(rises, {}, 1),
                       b = Record(rises, {.rate_hz = 50, .from_s = 4, .offset_s = 0.8, .drift_ppm = 120}, 2);
  const sync::Clock there = sync::AlignByMotion(a, b).clock, back = sync::AlignByMotion(b, a).clock;
  for (const double t : {4.0, 15.0, 28.0}) EXPECT_NEAR(back.FromB(there.FromB(t)), t, kLeast_s);
}

TEST(AlignByMotion, RefusesUnrelatedRises) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const sync::Movement a = Record(Rises(seed, 20), {.to_s = 20}, seed),
                         b = Record(Rises(seed + 500, 20), {.rate_hz = 50, .to_s = 20}, seed + 50);
    EXPECT_THAT(MessageOf([&] { sync::AlignByMotion(a, b); }), HasSubstr("camera and camera")) << seed;
  }
}

TEST(AlignByMotion, RefusesRestAndOtherKinds) {
  sync::Movement still = Record(Rises(3), {.noise = 0}, 1);
  still.values.rowwise() = Eigen::RowVectorXd::Constant(6, 3).eval();
  EXPECT_THROW(sync::AlignByMotion(still, Record(Rises(3), {}, 1)), Error);
  const sync::Movement forces{.kind = sync::MovementKind::kForces, .file = "plates.mot"},
      sensor{.kind = sync::MovementKind::kInertial, .file = "imu.csv"};
  EXPECT_THAT(MessageOf([&] { sync::AlignByMotion(forces, sensor); }), HasSubstr("show no common movement"));
}

sync::Movement Part(const sync::Movement& whole, double from_s, double to_s, double add_s = 0) {
  sync::Movement part = whole;
  part.time_s.clear();
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < whole.time_s.size(); ++i)
    if (whole.time_s[i] >= from_s && whole.time_s[i] <= to_s) {
      part.time_s.push_back(whole.time_s[i] + add_s);
      rows.push_back(static_cast<Eigen::Index>(i));
    }
  part.values = whole.values(rows, Eigen::all);
  return part;
}

// A person's leg in the plane that a camera sees, turned about the vertical.
sync::Movement SeenFrom(double turned_deg, const sync::Movement& space) {
  sync::Movement picture{.file = "camera", .time_s = space.time_s, .dimensions = 2, .up = 1};
  picture.values.resize(space.values.rows(), 8);
  const double c = std::cos(turned_deg * kPi / 180), s = std::sin(turned_deg * kPi / 180);
  for (const char* name : {"r_ankle", "r_knee", "R_HJC", "R_Shoulder"}) {
    const auto column = 3 * (std::ranges::find(space.names, name) - space.names.begin());
    const auto to = 2 * static_cast<Eigen::Index>(picture.names.size());
    picture.values.col(to) = c * space.values.col(column) + s * space.values.col(column + 2);
    picture.values.col(to + 1) = -space.values.col(column + 1);
    picture.names.emplace_back(name);
  }
  return picture;
}

// What one camera sees of the movement in depth, the other does not.
TEST(AlignByMotion, BringsRealViewsFromDifferentSidesTogether) {
  const fs::path file = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!fs::exists(file)) GTEST_SKIP() << file.string() << " is not here";
  const sync::Movement space = sync::ReadMovement(file);
  for (const double turned_deg : {0.0, 20.0, 45.0})
    for (const double from_s : {0.0, 1.2, 2.4}) {
      const sync::Clock clock = sync::AlignByMotion(Part(SeenFrom(0, space), 0, 7.5),
                                                    Part(SeenFrom(turned_deg, space), from_s, from_s + 6, -0.777))
                                    .clock;
      EXPECT_NEAR(clock.offset_s, 0.777, std::max(0.001, 3 * clock.sd_s)) << turned_deg << " deg, from " << from_s;
      EXPECT_NEAR(clock.offset_s, 0.777, 0.005) << turned_deg << " deg, from " << from_s;
    }
}

// The plates' clock is the markers'.
TEST(AlignByMotion, BringsPlatesToTheMarkers) {
  const fs::path folder = SharedData() / "sts_force_plates";
  if (!fs::exists(folder)) GTEST_SKIP() << folder.string() << " is not here";
  const sync::Movement markers = sync::ReadMovement(folder / "STS1.trc"),
                       plates = sync::ReadMovement(folder / "STS1_grf.mot");
  constexpr double kNear_s = 0.01;
  const sync::Clock clock = sync::AlignByMotion(markers, plates).clock;
  EXPECT_NEAR(clock.offset_s, 0, kNear_s);
  EXPECT_LT(std::abs(clock.offset_s), 3 * clock.sd_s);
  for (const auto& [from_s, to_s] : {std::pair{0, 8}, {5, 14}, {3, 11}})
    EXPECT_NEAR(sync::AlignByMotion(markers, Part(plates, from_s, to_s, -1.234)).clock.offset_s, 1.234, kNear_s);
  // Other rises of the same person are another movement.
  EXPECT_THROW(sync::AlignByMotion(Part(markers, 0, 6.8), Part(plates, 7, 14)), Error);
  EXPECT_THROW(sync::AlignByMotion(Part(markers, 7, 14), Part(plates, 0, 6.8)), Error);
  EXPECT_THROW(sync::AlignByMotion(Part(markers, 0, 6.8), Part(markers, 7, 14)), Error);
}

TEST(AlignByMotion, RefusesOtherPeople) {
  const fs::path other = SharedData() / "opencap_sts/sts_default_markers.trc",
                 folder = SharedData() / "sts_force_plates";
  if (!fs::exists(other)) GTEST_SKIP() << other.string() << " is not here";
  const sync::Movement markers = sync::ReadMovement(other);
  EXPECT_THROW(sync::AlignByMotion(markers, sync::ReadMovement(folder / "STS1.trc")), Error);
  EXPECT_THROW(sync::AlignByMotion(markers, sync::ReadMovement(folder / "STS1_grf.mot")), Error);
  EXPECT_THROW(sync::AlignByMotion(Part(markers, 0, 4.4), Part(markers, 4.5, 9)), Error);
}

// frame, s, x px, y px; tab, decimal comma. In the picture's plane, as the map takes its scale.
sync::Movement ThighOfVideo(const fs::path& folder) {
  std::map<int, std::array<double, 5>> rows;  // time, then both markers
  for (const auto& [name, column] : {std::pair{"knee.txt", 1}, {"thigh.txt", 3}}) {
    std::ifstream file(folder / name);
    for (std::string line; std::getline(file, line);) {
      std::ranges::replace(line, ',', '.');
      const std::vector<std::string> cells = SplitText(line, '\t');
      auto& row = rows.try_emplace(std::stoi(cells.at(0)), std::array{0.0, kNaN, kNaN, kNaN, kNaN}).first->second;
      row[0] = ParseNumber(cells.at(1)).value();
      for (std::size_t k = 0; k < 2; ++k)
        row[static_cast<std::size_t>(column) + k] = ParseNumber(cells.at(2 + k)).value();
    }
  }
  sync::Movement movement{.file = folder, .names = {"knee", "thigh"}, .dimensions = 2, .up = 0};
  movement.values.resize(static_cast<Eigen::Index>(rows.size()), 4);
  for (const auto& [frame, row] : rows) {
    movement.values.row(static_cast<Eigen::Index>(movement.time_s.size())) << row[1], row[2], row[3], row[4];
    movement.time_s.push_back(row[0]);
  }
  return movement;
}

// What the clocks' truth is nobody knows; that two parts of one recording say the same can be known.
TEST(AlignByMotion, BringsASensorToAVideo) {
  const fs::path data = SharedData() / "sts_markers_imu/data";
  if (!fs::exists(data)) GTEST_SKIP() << data.string() << " is not here";
  std::vector<sync::Movement> videos, sensors;
  for (const char* person : {"participant1", "participant2"}) {
    videos.push_back(ThighOfVideo(data / "video" / person));
    sensors.push_back(sync::ReadMovement(data / "NGIMU" / person / "NGIMU - 002D50FB" / "sensors.csv"));
    EXPECT_EQ(sensors.back().names.size(), 3u);
    const double middle_s = (videos.back().time_s.front() + videos.back().time_s.back()) / 2;
    const sync::Alignment first = sync::AlignByMotion(Part(videos.back(), 0, middle_s), sensors.back()),
                          second = sync::AlignByMotion(Part(videos.back(), middle_s, 1e9), sensors.back());
    const double at_s = middle_s - first.clock.offset_s;  // where both end
    EXPECT_NEAR(first.clock.FromB(at_s), second.clock.FromB(at_s), 0.01) << person;
    EXPECT_LT(std::abs(first.clock.FromB(at_s) - second.clock.FromB(at_s)),
              3 * std::hypot(first.clock.sd_s, second.clock.sd_s));
  }
  EXPECT_THROW(sync::AlignByMotion(videos[0], sensors[1]), Error);
  EXPECT_THROW(sync::AlignByMotion(videos[1], sensors[0]), Error);
  EXPECT_THROW(sync::AlignByMotion(sensors[0], sensors[1]), Error);
}

sync::Movement Sampled(double from_s, double to_s, double rate_hz) {
  sync::Movement movement{.file = "file"};
  for (double t = from_s; t < to_s; t += 1 / rate_hz) movement.time_s.push_back(t);
  return movement;
}

sync::Alignment BySignal(const std::vector<double>& in_a, const std::vector<double>& in_b, const sync::Movement& a,
                         const sync::Movement& b, const sync::AlignOptions& options = {}) {
  return sync::AlignBySignal(sync::SampledSignal(in_a, a), sync::SampledSignal(in_b, b), a, b, options);
}

TEST(AlignBySignal, FitsRisesToOneAnother) {
  const sync::Movement a = Sampled(0, 60, 50), b = Sampled(100, 160, 1000);
  const sync::Alignment once = BySignal({12.01}, {108.5}, a, b);
  EXPECT_NEAR(once.clock.FromB(108.5), 12.01, 1e-9);
  EXPECT_NEAR(once.clock.sd_s, 0.0161, 0.001) << "a frame's 20 ms over √12, and 300 ppm over 51 s";
  // Three flashes at unlike intervals, of which A misses one and B's clock runs 200 ppm slow.
  std::vector<double> in_a, in_b;
  for (const double t : {3.0, 17.0, 52.0}) in_b.push_back(100 + t), in_a.push_back(4.2 + t * (1 + 200e-6));
  in_a.erase(in_a.begin() + 1);
  const sync::Alignment several = BySignal(in_a, in_b, a, b, {.drift_sd_ppm = 1e4});
  EXPECT_NEAR(several.clock.drift_ppm, 200, 1);
  EXPECT_NEAR(several.clock.FromB(117), 4.2 + 17 * (1 + 200e-6), 1e-4);
}

TEST(AlignBySignal, RefusesWhatFitsNowhereOrAnywhere) {
  const sync::Movement a = Sampled(0, 60, 100), b = a;
  const auto said = [&](const std::vector<double>& in_a, const std::vector<double>& in_b) -> std::string {
    return MessageOf([&] { BySignal(in_a, in_b, a, b); });
  };
  EXPECT_THAT(said({1, 2, 3, 4}, {5, 6, 7}), HasSubstr("fits at several offsets"));
  EXPECT_THAT(said({1}, {5, 6}), HasSubstr("fits at several offsets"));
  EXPECT_THAT(said({1, 2}, {5, 7.7}), testing::AnyOf(HasSubstr("no two of the intervals"), HasSubstr("several")));
}

}  // namespace
}  // namespace lake
