#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/synth/marker_motion.h"
#include "lake/synth/sts_motion.h"
#include "message_of.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

struct Angles {
  double shank, thigh, trunk, knee;
};

double FromVertical(const Vector2d& v, motion::Facing facing) {
  return DegreesFromRadians(std::atan2(facing == motion::Facing::kRight ? v.x() : -v.x(), v.y()));
}

Angles AnglesAt(const synth::StsMotion& motion, double t) {
  const auto m = motion.At(t);
  const motion::Facing facing = motion.FacingInImage();
  return {FromVertical(m[1] - m[0], facing), FromVertical(m[2] - m[1], facing), FromVertical(m[3] - m[2], facing),
          synth::KneeAngleDeg(m[0], m[1], m[2], facing)};
}

TEST(MinimumJerk, StartsAndEndsAtRestWithoutAcceleration) {
  constexpr double h = 1e-4;
  for (const double end : {0.0, 1.0}) {
    const double inward = end == 0 ? h : -h;
    const double from = synth::MinimumJerk(end), one = synth::MinimumJerk(end + inward),
                 two = synth::MinimumJerk(end + 2 * inward);
    EXPECT_EQ(from, end);
    EXPECT_NEAR((one - from) / h, 0, 1e-6);                  // 10 h² is left
    EXPECT_NEAR((two - 2 * one + from) / (h * h), 0, 0.01);  // 60 h is left
  }
  EXPECT_NEAR((synth::MinimumJerk(0.5 + h) - synth::MinimumJerk(0.5 - h)) / (2 * h), 1.875,
              1e-6);  // peak speed, Flash & Hogan
  EXPECT_EQ(synth::MinimumJerk(-3), 0);
  EXPECT_EQ(synth::MinimumJerk(7), 1);
}

TEST(KneeAngle, IsThePapersFormulaWithASign) {
  const Vector2d ankle(10, 0), knee(12, 400), hip(-380, 440);
  const Vector2d ak = knee - ankle, kh = hip - knee;
  const double paper = DegreesFromRadians(std::acos(ak.dot(kh) / (ak.norm() * kh.norm())));
  EXPECT_NEAR(synth::KneeAngleDeg(ankle, knee, hip, motion::Facing::kRight), paper, 1e-9);
  EXPECT_NEAR(synth::KneeAngleDeg(ankle, knee, hip, motion::Facing::kLeft), -paper, 1e-9);
}

class StsMotionOfSeed : public ::testing::TestWithParam<int> {
 protected:
  synth::StsMotion Make(synth::StsMotionOptions options = {}) const {
    options.seed = static_cast<std::uint64_t>(GetParam());
    options.repetitions = 3;
    return synth::StsMotion(options);
  }
};

TEST_P(StsMotionOfSeed, MovesLikeAPerson) {
  const synth::StsMotion motion = Make();
  int rises = 0;
  for (const synth::StsPhase& phase : motion.Phases()) {
    const double length = phase.end_s - phase.start_s;
    if (phase.kind == synth::StsPhase::Kind::kRise || phase.kind == synth::StsPhase::Kind::kDescent) {
      rises += phase.kind == synth::StsPhase::Kind::kRise;
      EXPECT_GE(length, 1.7);
      EXPECT_LE(length, 2.3);
      double peak_shank = 0, peak_trunk = 0;
      for (double t = phase.start_s; t < phase.end_s; t += 0.005) {
        peak_shank = std::max(peak_shank, AnglesAt(motion, t).shank);
        peak_trunk = std::max(peak_trunk, AnglesAt(motion, t).trunk);
      }
      EXPECT_GT(peak_shank, 10);
      EXPECT_LT(peak_shank, 25);
      EXPECT_GT(peak_trunk, 34);
      EXPECT_LT(peak_trunk, 45);
      continue;
    }
    const Angles rest = AnglesAt(motion, 0.5 * (phase.start_s + phase.end_s));
    EXPECT_GE(length, 0.5);
    EXPECT_LE(length, 1.5);
    EXPECT_NEAR(rest.knee, rest.shank - rest.thigh, 1e-9);
    if (phase.kind == synth::StsPhase::Kind::kSeated) {
      EXPECT_GT(rest.knee, 85);
      EXPECT_LT(rest.knee, 100);
    } else {
      EXPECT_GT(rest.knee, 3);
      EXPECT_LT(rest.knee, 8);
    }
  }
  EXPECT_EQ(rises, 3);
}

TEST_P(StsMotionOfSeed, SegmentsAreRigidAndTheAnkleIsNearlyStill) {
  const synth::StsMotion motion = Make();
  for (double t = 0; t < motion.DurationS(); t += 0.01) {
    const auto m = motion.At(t);
    EXPECT_NEAR((m[1] - m[0]).norm(), 400, 1e-9);
    EXPECT_NEAR((m[2] - m[1]).norm(), 410, 1e-9);
    EXPECT_NEAR((m[3] - m[2]).norm(), 200, 1e-9);
    EXPECT_LT(m[0].norm(), 0.2 * std::sqrt(2.0) + 1e-9);
  }
}

TEST_P(StsMotionOfSeed, IsSmoothAcrossPhases) {
  const synth::StsMotion motion = Make();
  constexpr double h = 1e-3;
  // Accelerations stay below 20 m/s² and jerk below 500 m/s³ (a jump of acceleration would give 1000 m/s³ and more
  // here).
  Vector2d last = Vector2d::Zero();
  for (double t = 2 * h; t < motion.DurationS() - h; t += h) {
    const Vector2d acceleration = (motion.At(t + h)[2] - 2 * motion.At(t)[2] + motion.At(t - h)[2]) / (h * h);
    ASSERT_LT(acceleration.norm(), 20e3) << t;
    if (t > 3 * h) {
      ASSERT_LT((acceleration - last).norm() / h, 500e3) << t;
    }
    last = acceleration;
  }
}

TEST_P(StsMotionOfSeed, FacingLeftIsTheMirrorImage) {
  synth::StsMotionOptions options;
  options.skin_mm = 8;
  options.exo_knee_mm = Vector2d(20, 30);
  const synth::StsMotion right = Make(options);
  options.facing = motion::Facing::kLeft;
  const synth::StsMotion left = Make(options);
  for (double t = 0; t < right.DurationS(); t += 0.1) {
    const auto r = right.At(t), l = left.At(t);
    for (std::size_t m = 0; m < r.size(); ++m) EXPECT_EQ(l[m], Vector2d(-r[m].x(), r[m].y()));
    EXPECT_NEAR(synth::KneeAngleDeg(r[0], r[1], r[2], motion::Facing::kRight),
                synth::KneeAngleDeg(l[0], l[1], l[2], motion::Facing::kLeft), 1e-9);
  }
}

TEST_P(StsMotionOfSeed, ExoKneeStaysWhereItIsPutInTheShank) {
  synth::StsMotionOptions options;
  options.exo_knee_mm = Vector2d(-22, 31);
  const synth::StsMotion motion = Make(options);
  ASSERT_EQ(motion.Names().back(), "exo_knee");
  for (double t = 0; t < motion.DurationS(); t += 0.05) {
    const auto m = motion.At(t);
    const Vector2d y = (m[1] - m[0]).normalized(), x(y.y(), -y.x()), offset = m[4] - m[1];
    EXPECT_NEAR(offset.dot(x), -22, 1e-9);
    EXPECT_NEAR(offset.dot(y), 31, 1e-9);
  }
}

TEST_P(StsMotionOfSeed, PaceAndWarpChangeTimingAlone) {
  synth::StsMotionOptions options;
  options.ankle_sway_mm = options.body_sway_deg = 0;
  const synth::StsMotion human = Make(options);
  options.pace = 1.3;
  options.time_warp = 0.05;
  const synth::StsMotion exo = Make(options);
  for (std::size_t i = 0; i < human.Phases().size(); ++i) {
    const synth::StsPhase &h = human.Phases()[i], &e = exo.Phases()[i];
    if (h.kind != synth::StsPhase::Kind::kRise) continue;
    EXPECT_NEAR(e.end_s - e.start_s, 1.3 * (h.end_s - h.start_s), 1e-9);
    for (double s = 0; s <= 1; s += 0.05) {
      const double warped = s + 0.05 * std::sin(std::numbers::pi * s);
      const Vector2d human_knee = human.At(h.start_s + warped * (h.end_s - h.start_s))[1];
      EXPECT_LT((exo.At(e.start_s + s * (e.end_s - e.start_s))[1] - human_knee).norm(), 1e-9);
    }
  }
}

TEST_P(StsMotionOfSeed, SkinSlidesByAboutWhatIsAsked) {
  synth::StsMotionOptions options;
  options.skin_mm = 12;
  const synth::StsMotion motion = Make(options);
  double shortest = 1e9, longest = 0;
  for (double t = 0; t < motion.DurationS(); t += 0.02) {
    const auto m = motion.At(t);
    shortest = std::min(shortest, (m[2] - m[1]).norm());
    longest = std::max(longest, (m[2] - m[1]).norm());
  }
  EXPECT_GT(longest - shortest, 3);
  EXPECT_LT(longest - shortest, 24);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StsMotionOfSeed, ::testing::Values(1, 2, 3, 17, 40077));

TEST(StsMotion, MayBeginUpright) {
  synth::StsMotionOptions options;
  options.start_standing = true;
  const synth::StsMotion motion(options);
  EXPECT_EQ(motion.Phases().front().kind, synth::StsPhase::Kind::kStanding);
  EXPECT_EQ(motion.Phases().back().kind, synth::StsPhase::Kind::kStanding);
  EXPECT_LT(AnglesAt(motion, 0).knee, 10);
}

TEST(StsMotion, SaysWhichOptionIsWrong) {
  const auto message = [](auto change) {
    synth::StsMotionOptions options;
    change(options);
    return MessageOf<UsageError>([&] { synth::StsMotion motion(options); });
  };
  EXPECT_THAT(message([](auto& o) { o.repetitions = 0; }), HasSubstr("0 repetitions"));
  EXPECT_THAT(message([](auto& o) { o.thigh_mm = -1; }), HasSubstr("segment lengths"));
  EXPECT_THAT(message([](auto& o) { o.rise_s = 0; }), HasSubstr("durations"));
  EXPECT_THAT(message([](auto& o) { o.max_rest_s = 0.1; }), HasSubstr("rests"));
  EXPECT_THAT(message([](auto& o) { o.time_warp = 0.4; }), HasSubstr("time would turn back"));
}

synth::MotionTable CircleTable(double hz, double duration_s) {
  synth::MotionTable table;
  table.names = {"ball"};
  table.positions.resize(1);
  for (int i = 0; i <= duration_s * hz; ++i) {
    const double t = i / hz;
    table.time_s.push_back(5 + t);
    table.positions[0].emplace_back(200 * std::cos(3 * t), 200 * std::sin(3 * t));
  }
  return table;
}

TEST(TableMotion, PassesThroughItsRowsAndIsSmoothBetween) {
  const synth::MotionTable table = CircleTable(100, 2);
  const auto motion = synth::MakeTableMotion(table);
  EXPECT_NEAR(motion->DurationS(), 2, 1e-12);
  for (std::size_t i = 0; i < table.time_s.size(); ++i)
    EXPECT_LT((motion->At(table.time_s[i] - 5)[0] - table.positions[0][i]).norm(), 1e-9);
  // A cubic spline's error away from the ends is 5/384 h⁴ |x⁗|: 5/384 · 1e-8 · 200 · 81 mm = 2e-6 mm.
  for (double t = 0.3; t < 1.7; t += 0.0037)
    EXPECT_LT((motion->At(t)[0] - Vector2d(200 * std::cos(3 * t), 200 * std::sin(3 * t))).norm(), 1e-5);
  EXPECT_EQ(motion->At(-1), motion->At(0));
  EXPECT_EQ(motion->At(9), motion->At(2));
}

TEST(TableMotion, KnowsWhereThePersonFaces) {
  synth::StsMotionOptions options;
  for (const motion::Facing facing : {motion::Facing::kLeft, motion::Facing::kRight}) {
    options.facing = facing;
    const synth::StsMotion sts(options);
    synth::MotionTable table{{}, sts.Names(), std::vector<std::vector<Vector2d>>(4), {}};
    for (double t = 0; t < sts.DurationS(); t += 0.02) {
      table.time_s.push_back(t);
      for (int m = 0; m < 4; ++m) table.positions[m].push_back(sts.At(t)[m]);
    }
    EXPECT_EQ(synth::MakeTableMotion(table)->FacingInImage(), facing);
    EXPECT_NE(synth::MakeTableMotion(table, true)->FacingInImage(), facing);
  }
}

class MotionTableFile : public ::testing::Test {
 protected:
  std::string ErrorOf(const std::string& text) {
    const auto path = std::filesystem::path(::testing::TempDir()) / "motion_table_test.csv";
    std::ofstream(path) << text;
    return MessageOf([&] { synth::MakeTableMotion(synth::ReadMotionTable(path)); });
  }
};

TEST_F(MotionTableFile, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(ErrorOf("time_s,a_x_mm,a_y_mm\n0,1,2\n1,1,2\n2,3,4\n"), "");
  EXPECT_THAT(ErrorOf("time_s,a\n0,1\n"), HasSubstr("no column M_x_mm"));
  EXPECT_THAT(ErrorOf("time_s,a_x_mm,a_y_mm\n0,1,2\n1,1,2\n"), HasSubstr("at least 3"));
  EXPECT_THAT(ErrorOf("time_s,a_x_mm,a_y_mm\n0,1,2\n1,,2\n2,1,1\n"), HasSubstr(":3"));
  EXPECT_THAT(ErrorOf("time_s,a_x_mm,a_y_mm\n0,1,2\n0,1,2\n2,1,1\n"), HasSubstr(":3: time_s 0 does not come after 0"));
  EXPECT_THAT(ErrorOf("time_s,a_x_mm,b_y_mm\n0,1,2\n1,1,2\n2,1,1\n"), HasSubstr("a_y_mm"));
}

}  // namespace
}  // namespace lake
