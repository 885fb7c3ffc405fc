// Recordings of which the answer is plain: copies of one movement, and different recordings of movements that are
// alike.
#include <gtest/gtest.h>

#include <fstream>

#include "lake/core/error.h"
#include "lake/sync/align.h"
#include "message_of.h"
#include "recorded_rises.h"
#include "temporary_folder.h"

namespace lake {
namespace {

// The ankle's marker rests, so that it shows noise alone.
sync::Movement WithAnkle(sync::Movement movement, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  movement.names.insert(movement.names.begin(), "ankle");
  Eigen::MatrixXd values(movement.values.rows(), movement.values.cols() + 2);
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    values.row(i) << normal(random), normal(random), movement.values.row(i);
  movement.values = values;
  return movement;
}

sync::Movement FourMarkers(const Rises& rises, const Camera& camera, unsigned seed) {
  return WithAnkle(Record(rises, camera, seed), camera.noise, seed + 1000);
}

// Two copies of one movement, each with noise of 0.3 mm on the four usual markers, of which the ankle rests and shows
// its noise alone.
TEST(Copies, OfOneMovementWithTheirOwnNoiseAreAligned) {
  int held = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Rises rises(seed);
    const Camera a{.noise = 0.3}, b{.noise = 0.3, .from_s = 2, .offset_s = 1.25};
    const std::string refusal = MessageOf([&] {
      const sync::Clock clock =
          sync::AlignByMotion(FourMarkers(rises, a, seed), FourMarkers(rises, b, seed + 100)).clock;
      EXPECT_NEAR(clock.offset_s, 1.25, 0.002) << seed;
      held += std::abs(clock.offset_s - 1.25) < 2 * clock.sd_s;
    });
    EXPECT_EQ(refusal, "") << seed;
  }
  EXPECT_GE(held, 10);
}

// A file of three dimensions whose third one is 0 throughout.
TEST(Copies, APlanarFileFitsItself) {
  const TemporaryFolder folder;
  const auto file = folder / "planar.trc";
  const sync::Movement movement = Record(Rises(5), {}, 5);
  std::ofstream out(file);
  const auto frames = movement.values.rows();
  out << "PathFileType\t4\t(X/Y/Z)\tplanar.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
         "OrigDataStartFrame\tOrigNumFrames\n60\t60\t"
      << frames << "\t3\tmm\t60\t1\t" << frames << "\nFrame#\tTime\tknee\t\t\thip\t\t\twaist\t\t\n"
      << "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n\n";
  for (Eigen::Index i = 0; i < frames; ++i) {
    out << i + 1 << '\t' << static_cast<double>(i) / 60;
    for (Eigen::Index m = 0; m < 3; ++m)
      out << '\t' << movement.values(i, 2 * m) << '\t' << movement.values(i, 2 * m + 1) << "\t0";
    out << '\n';
  }
  out.close();
  const sync::Movement read = sync::ReadMovement(file);
  const sync::Alignment found = sync::AlignByMotion(read, read);
  EXPECT_NEAR(found.clock.offset_s, 0, 1e-3);
}

// A person rises once more, each move and rest three parts of a hundred longer or shorter. Some such pairs
// are accepted with an offset; right is to refuse all, as none has one.
TEST(Copies, ADifferentRecordingOfTheSamePersonIsNone) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const Rises rises(seed, 15);
    const sync::Movement first = Record(rises, {.to_s = 15}, seed),
                         again = Record(rises.Again(seed + 7, 0.03), {.to_s = 15}, seed + 50);
    EXPECT_THROW(sync::AlignByMotion(first, again), Error) << seed;
  }
}

// Recordings that share a third of their time have their offset, or an error.
TEST(Copies, ThatOverlapByAThirdHaveTheirOffsetOrNone) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Rises rises(seed, 50);
    const Camera a{.noise = 0.3}, b{.rate_hz = 50, .noise = 0.3, .from_s = 19.5, .to_s = 49.5, .offset_s = 3.1};
    try {
      const sync::Clock clock = sync::AlignByMotion(Record(rises, a, seed), Record(rises, b, seed + 100)).clock;
      EXPECT_NEAR(clock.FromB(25 - 3.1), 25, std::max(0.02, 4 * clock.sd_s)) << seed << ", SD " << clock.sd_s;
      EXPECT_LT(std::abs(clock.drift_ppm), 500) << seed;
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace lake
