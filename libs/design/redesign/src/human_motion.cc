#include "lake/redesign/human_motion.h"

#include <algorithm>
#include <numbers>
#include <numeric>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::redesign {
namespace {

using Eigen::Vector2d;

constexpr double kRounding_mm = 1e-6;  // a stroke this far outside the used range is on its end

double WrapToHalfTurn(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

std::optional<linkage::UsedRange> UsedRangeOf(const DrivenLinks& linkage) {
  if (!linkage::SolvePose(linkage.links, linkage.d_min_mm)) return std::nullopt;
  return linkage::FindUsedRange(linkage.links, linkage.d_min_mm, linkage.d_max_mm,
                                RadiansFromDegrees(linkage.standing_deg));
}

// The vectors of spikes are taken from the line between the samples around them, at the ends from the next sample.
void BridgeSpikes(const std::vector<bool>& spike, std::vector<Vector2d>& vectors) {
  std::vector<std::size_t> quiet;
  for (std::size_t i = 0; i < vectors.size(); ++i)
    if (i >= spike.size() || !spike[i]) quiet.push_back(i);
  if (quiet.empty()) return;
  const std::vector<Vector2d> measured = vectors;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const auto after = std::ranges::lower_bound(quiet, i);
    const std::size_t to = after == quiet.end() ? quiet.back() : *after;
    const std::size_t from = after == quiet.begin() || to <= i ? to : *(after - 1);
    const double weight = to == from ? 0 : static_cast<double>(i - from) / static_cast<double>(to - from);
    vectors[i] = (1 - weight) * measured[from] + weight * measured[to];
  }
}

double RmsLength(const std::vector<Vector2d>& vectors) {
  return std::sqrt(compare::MeanSquare(vectors));
}

// The leg with this knee angle, ankle and lean as the human's.
Vector2d PredictHip(const HumanSample& human, double theta_rad) {
  const double leg_mm =
      std::hypot(human.shank_mm + human.thigh_mm * std::cos(theta_rad), human.thigh_mm * std::sin(theta_rad));
  return human.ankle + leg_mm * Vector2d(human.sin_lean, human.cos_lean);
}

}  // namespace

HumanMotion MakeHumanMotion(const compare::StsCurve& human) {
  HumanMotion motion;
  for (std::size_t i = 0; i < human.knee.size(); ++i) {
    const Vector2d ak = human.knee[i] - human.ankle[i], kh = human.hip[i] - human.knee[i], ah = ak + kh;
    if (!(ak.norm() > 0 && kh.norm() > 0 && ah.norm() > 0))
      throw Fail("the leg has no length at {} % of its motion", i);
    HumanSample sample{.ankle = human.ankle[i],
                       .knee = human.knee[i],
                       .shank_mm = ak.norm(),
                       .thigh_mm = kh.norm(),
                       .sin_lean = ah.x() / ah.norm(),
                       .cos_lean = ah.y() / ah.norm()};
    sample.knee_rad = WrapToHalfTurn(std::atan2(ak.x(), ak.y()) - std::atan2(kh.x(), kh.y()));
    motion.push_back(sample);
  }
  return motion;
}

HumanMotion Leaning(HumanMotion motion, const std::vector<double>& leg_rad) {
  for (std::size_t i = 0; i < leg_rad.size(); ++i) {
    const double c = std::cos(leg_rad[i]), s = std::sin(leg_rad[i]), sin_lean = motion[i].sin_lean;
    motion[i].sin_lean = sin_lean * c + motion[i].cos_lean * s;
    motion[i].cos_lean = motion[i].cos_lean * c - sin_lean * s;
  }
  return motion;
}

HumanMotion Thinned(const HumanMotion& motion, std::size_t step) {
  HumanMotion thinned;
  for (std::size_t i = 0; i < motion.size(); i += step) thinned.push_back(motion[i]);
  return thinned;
}

SegmentLengths SegmentsOf(const HumanMotion& motion) {
  SegmentLengths mean;
  for (const HumanSample& sample : motion) {
    mean.shank_mm += sample.shank_mm;
    mean.thigh_mm += sample.thigh_mm;
  }
  const auto samples = static_cast<double>(motion.size());
  return {mean.shank_mm / samples, mean.thigh_mm / samples};
}

DrivenLinks DrivenLinksOf(const linkage::Design& design, double standing_deg) {
  return {
      .links = design.links, .d_min_mm = design.d_min_mm, .standing_deg = standing_deg, .d_max_mm = design.d_max_mm};
}

std::optional<Prediction> Predict(const DrivenLinks& linkage, const Vector2d& placement_mm,
                                  const std::vector<double>& stroke_mm, const HumanMotion& human) {
  const std::optional<linkage::UsedRange> range = UsedRangeOf(linkage);
  if (!range) return std::nullopt;
  Prediction prediction;
  prediction.stroke_mm = stroke_mm;
  std::vector<Vector2d> human_knee, joint;
  std::vector<double> shank_mm;
  for (std::size_t i = 0; i < human.size(); ++i) {
    if (!range->stroke.Contains(stroke_mm[i], kRounding_mm)) return std::nullopt;
    const auto pose =
        linkage::SolvePose(linkage.links, std::clamp(stroke_mm[i], range->stroke.lower_mm, range->stroke.upper_mm));
    if (!pose) return std::nullopt;
    const HumanSample& sample = human[i];
    prediction.theta_rad.push_back(pose->theta_rad);
    prediction.exo.ankle.push_back(sample.ankle);
    prediction.exo.knee.push_back(PredictKnee(sample, pose->theta_rad, placement_mm.x(), placement_mm.y()));
    prediction.exo.leg_knee.push_back(PredictKnee(sample, pose->theta_rad, -sample.slip_mm.x(), -sample.slip_mm.y()));
    prediction.exo.hip.push_back(PredictHip(sample, pose->theta_rad));
    prediction.exo.knee_deg.push_back(DegreesFromRadians(pose->theta_rad));
    prediction.exo.knee_sigma_mm.push_back(0);
    prediction.angle_mismatch_deg =
        std::max(prediction.angle_mismatch_deg, std::abs(DegreesFromRadians(pose->theta_rad - sample.knee_rad)));
    human_knee.push_back(sample.knee);
    joint.push_back(placement_mm + sample.slip_mm);
    shank_mm.push_back(sample.shank_mm);
  }
  const std::vector<Vector2d> on_the_knee(human.size(), Vector2d::Zero());
  const auto rms = [&](const std::vector<Vector2d>& exo, const std::vector<Vector2d>& knee) {
    return MisalignmentRms{std::sqrt(compare::MeanSquaredMisalignment(exo, knee, shank_mm)),
                           std::sqrt(compare::MeanSquaredDistance(exo, knee))};
  };
  prediction.path = rms(prediction.exo.knee, human_knee);
  prediction.joint = rms(joint, on_the_knee);
  return prediction;
}

std::optional<std::vector<double>> StrokesForAngles(const DrivenLinks& linkage, const std::vector<double>& knee_rad) {
  const std::optional<linkage::UsedRange> range = UsedRangeOf(linkage);
  if (!range) return std::nullopt;
  std::vector<double> strokes;
  for (const double angle : knee_rad) {
    const double theta = std::clamp(angle, std::min(range->theta_at_upper_rad, range->theta_at_lower_rad),
                                    std::max(range->theta_at_upper_rad, range->theta_at_lower_rad));
    const double end = angle >= range->theta_at_lower_rad ? range->stroke.lower_mm : range->stroke.upper_mm;
    strokes.push_back(linkage::StrokeForAngle(linkage.links, *range, theta).value_or(end));
  }
  return strokes;
}

std::optional<std::vector<double>> TrackingStrokes(const DrivenLinks& linkage, const HumanMotion& human) {
  std::vector<double> knee_rad;
  for (const HumanSample& sample : human) knee_rad.push_back(sample.knee_rad);
  return StrokesForAngles(linkage, knee_rad);
}

double TrackingTime(const std::vector<double>& tracking_stroke_mm, double max_speed_mm_s) {
  double largest_mm = 0;
  for (std::size_t i = 1; i < tracking_stroke_mm.size(); ++i)
    largest_mm = std::max(largest_mm, std::abs(tracking_stroke_mm[i] - tracking_stroke_mm[i - 1]));
  return static_cast<double>(tracking_stroke_mm.size() - 1) * largest_mm / max_speed_mm_s;
}

double TrackedShare(const std::vector<double>& tracking_stroke_mm, double max_speed_mm_s, double duration_s) {
  const auto steps = static_cast<double>(tracking_stroke_mm.size() - 1);
  int within = 0;
  for (std::size_t i = 1; i < tracking_stroke_mm.size(); ++i)
    if (std::abs(tracking_stroke_mm[i] - tracking_stroke_mm[i - 1]) <= max_speed_mm_s * duration_s / steps) ++within;
  return within / steps;
}

std::optional<std::vector<double>> ProgramStrokes(const linkage::Design& design, double standing_deg,
                                                  const HumanMotion& human) {
  std::vector<linkage::StrokeProgram::Knot> knots;
  if (design.program && design.program->kind == linkage::StrokeProgram::Kind::kFree) {
    knots = design.program->knots;
  } else {
    const auto tracking = TrackingStrokes(DrivenLinksOf(design, standing_deg), human);
    if (!tracking) return std::nullopt;
    knots = {{0, tracking->front()}, {1, tracking->back()}};
  }
  std::vector<double> strokes;
  for (std::size_t i = 0; i < human.size(); ++i)
    strokes.push_back(
        linkage::StrokeAt(knots, std::lerp(knots.front().time_s, knots.back().time_s, PercentOf(i, human) / 100)));
  return strokes;
}

std::optional<MountSlip> SetSlip(const compare::StsCurve& exo, const std::vector<bool>& spike,
                                 const Vector2d& worn_placement_mm, HumanMotion& human) {
  for (HumanSample& sample : human) sample.slip_mm.setZero();
  if (exo.leg_knee.empty()) return std::nullopt;
  compare::StsCurve own_leg = exo;
  own_leg.knee = exo.leg_knee;
  const HumanMotion own = MakeHumanMotion(own_leg);
  std::vector<Vector2d> mount;
  for (std::size_t i = 0; i < own.size(); ++i)
    mount.push_back(compare::ShankAxes(own_leg, i).transpose() * (exo.knee[i] - own[i].knee));
  BridgeSpikes(spike, mount);
  std::vector<Vector2d> slip, pace, lean;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto joint = [&](const HumanSample& leg, double knee_rad) {
      HumanSample sample = leg;
      sample.slip_mm = mount[i];
      return PredictKnee(sample, knee_rad, 0.0, 0.0);
    };
    slip.push_back(mount[i] - worn_placement_mm);
    pace.push_back(joint(human[i], own[i].knee_rad) - joint(human[i], human[i].knee_rad));
    lean.push_back(joint(own[i], own[i].knee_rad) - joint(human[i], own[i].knee_rad));
    human[i].slip_mm = slip.back();
  }
  const Vector2d sum = std::accumulate(mount.begin(), mount.end(), Vector2d(Vector2d::Zero()));
  return MountSlip{.slip_mm = RmsLength(slip),
                   .mount_mm = RmsLength(mount),
                   .placement_mm = sum / static_cast<double>(mount.size()),
                   .pace_mm = RmsLength(pace),
                   .lean_mm = RmsLength(lean)};
}

}  // namespace lake::redesign
