#include "lake/loads/loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "balance.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/gait/butterworth.h"
#include "lake/loads/clock_offset.h"
#include "loads_model.h"

namespace lake::loads {
namespace {

using Eigen::Vector2d;

constexpr double kLow = 0.025, kHigh = 0.975;

std::vector<Rise> RisesOf(const std::vector<motion::StsEvent>& events) {
  std::map<int, std::map<motion::StsEventKind, double>> times, deviations;
  for (const motion::StsEvent& event : events) {
    times[event.repetition][event.kind] = event.time_s;
    deviations[event.repetition][event.kind] = std::isfinite(event.sd_s) ? event.sd_s : 0;
  }
  std::vector<Rise> rises;
  for (const auto& [repetition, at] : times) {
    using enum motion::StsEventKind;
    if (!at.contains(kOnset) || !at.contains(kSeatOff) || !at.contains(kStanding)) continue;
    Rise rise{.repetition = repetition,
              .onset_s = at.at(kOnset),
              .seat_off_s = at.at(kSeatOff),
              .standing_s = at.at(kStanding),
              .descent_s = {},
              .seated_s = {},
              .onset_sd_s = deviations[repetition][kOnset],
              .seat_off_sd_s = deviations[repetition][kSeatOff],
              .standing_sd_s = deviations[repetition][kStanding]};
    if (at.contains(kDescent)) rise.descent_s = at.at(kDescent);
    if (at.contains(kSeated)) rise.seated_s = at.at(kSeated);
    rises.push_back(rise);
  }
  if (rises.empty())
    throw Fail(
        "loads: no rise from a seat in the recording: there is no seat-off with a standing after it; the moments are "
        "worked out from there on");
  return rises;
}

// The rise from where the seat has let go until a second after standing, and the way down until the seat is touched.
std::vector<Window> WindowsOf(const std::vector<Rise>& rises, const std::vector<double>& time_s,
                              const LoadsOptions& options) {
  constexpr double kStanding_s = 1;
  std::vector<Window> windows;
  for (std::size_t r = 0; r < rises.size(); ++r) {
    const Rise& rise = rises[r];
    const double next_s = r + 1 < rises.size() ? rises[r + 1].onset_s : time_s.back() + 1;
    double end_s = std::min(rise.standing_s + kStanding_s, next_s);
    const double down_s = rise.seated_s ? *rise.seated_s - options.seat_contact_s : next_s;
    if (rise.descent_s && *rise.descent_s <= end_s) end_s = down_s;
    windows.push_back({FrameFrom(time_s, rise.seat_off_s + options.seat_release_s), FrameFrom(time_s, end_s)});
    if (rise.descent_s && *rise.descent_s > end_s)
      windows.push_back({FrameFrom(time_s, *rise.descent_s), FrameFrom(time_s, down_s)});
  }
  return windows;
}

// The forces at the frames' times, low-passed as the positions are; nullopt where there are none.
std::vector<std::optional<Wrench>> ForcesAtFrames(const GroundForces& forces, const std::vector<double>& time_s,
                                                  double cutoff_hz) {
  std::array<std::vector<double>, 3> parts;
  for (const Wrench& wrench : forces.wrench) {
    parts[0].push_back(wrench.force_n.x());
    parts[1].push_back(wrench.force_n.y());
    parts[2].push_back(wrench.moment_nm);
  }
  for (std::vector<double>& part : parts) part = gait::ZeroPhaseButterworthAtTimes(part, forces.time_s, cutoff_hz);
  std::vector<std::optional<Wrench>> at_frames;
  for (const double at_s : time_s) {
    at_frames.emplace_back();
    if (at_s < forces.time_s.front() || at_s > forces.time_s.back()) continue;
    const Between b = Locate(forces.time_s, at_s);
    const auto value = [&](std::size_t i) { return std::lerp(parts[i][b.before], parts[i][b.before + 1], b.part); };
    at_frames.back() = Wrench{{value(0), value(1)}, value(2)};
  }
  return at_frames;
}

// Of the leg with what it bears of the trunk.
double MassKg(const LegBody& body) {
  return body.foot.mass_kg + body.shank.mass_kg + body.thigh.mass_kg + body.trunk.mass_kg;
}

LegLoads LoadsAt(const Model& model, std::size_t frame) {
  const LegPoints& points = model.path.frames[frame];
  return model.trunk ? LoadsFromTrunk(points, model.body, model.trunk->At(model.path, frame))
                     : LoadsFromGround(points, model.body, *model.ground[frame]);
}

LegLoads Mix(const LegLoads& a, const LegLoads& b, double part) {
  return {.moments = {std::lerp(a.moments.ankle_nm, b.moments.ankle_nm, part),
                      std::lerp(a.moments.knee_nm, b.moments.knee_nm, part),
                      std::lerp(a.moments.hip_nm, b.moments.hip_nm, part)},
          .ground_force_n = (1 - part) * a.ground_force_n + part * b.ground_force_n,
          .zmp_m = std::lerp(a.zmp_m, b.zmp_m, part)};
}

bool IsKnown(const Model& model, std::size_t frame) {
  return model.path.known[frame] && (model.trunk || model.ground[frame]);
}

std::optional<LegLoads> LoadsAtTime(const Model& model, double at_s) {
  const Between b = Locate(model.path.time_s, at_s);
  if (!IsKnown(model, b.before) || !IsKnown(model, b.before + 1)) return std::nullopt;
  return Mix(LoadsAt(model, b.before), LoadsAt(model, b.before + 1), b.part);
}

// The knee's moments of one rise, NaN where not known: what draws are compared by.
std::vector<double> KneeCurve(const Model& model, const Rise& rise, const LoadsOptions& options, double factor) {
  std::vector<double> curve(kPercents, LoadsRow::kUnknown);
  for (int percent = 0; percent < kPercents; ++percent) {
    const double at_s = TimeOf(rise, percent);
    if (model.trunk && !SeatIsLeft(rise, at_s, options)) continue;
    if (const auto loads = LoadsAtTime(model, at_s))
      curve[static_cast<std::size_t>(percent)] = factor * loads->moments.knee_nm;
  }
  return curve;
}

double Largest(const std::vector<double>& curve) {
  double largest = LoadsRow::kUnknown;
  for (const double value : curve)
    if (std::isfinite(value)) largest = std::isnan(largest) ? value : std::max(largest, value);
  return largest;
}

// Draws of all that the model takes for granted.
class Drawing {
 public:
  Drawing(const LoadsOptions& options, std::uint64_t seed)
      : u_(options.uncertainty),
        share_(options.body.share),
        random_(seed),
        axis_random_(seed + 1),
        event_random_(seed + 3),
        share_random_(seed + 5) {}

  std::mt19937_64& Random() { return random_; }
  double Normal(double sigma) { return sigma * normal_(random_); }
  // Of the moment across the plane, that about the knee's own axis, which is turned from the plane's normal about the
  // vertical: M cos(yaw) + M_frontal sin(yaw).
  double AxisFactor() {
    std::normal_distribution<double> normal;
    const double yaw_rad = u_.axis_yaw_rad * normal(axis_random_), frontal = u_.frontal_moment * normal(axis_random_);
    return std::cos(yaw_rad) + frontal * std::sin(yaw_rad);
  }

  double Factor(double sigma) { return std::exp(Normal(sigma)); }
  std::size_t Index(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_); }

  LegBody Body(LegBody body) {
    const double leg_kg = body.foot.mass_kg + body.shank.mass_kg + body.thigh.mass_kg, all = Factor(u_.mass);
    for (SegmentInertia* segment : {&body.foot, &body.shank, &body.thigh}) {
      segment->mass_kg *= all * Factor(u_.segment_mass);
      segment->gyration_m *= Factor(u_.segment_gyration);
    }
    // A segment's centre is a third to a half of its length from the upper end.
    for (SegmentInertia* segment : {&body.shank, &body.thigh})
      segment->centre_m += Normal(u_.segment_centre) * segment->centre_m / 0.43;
    const double drawn_kg = body.foot.mass_kg + body.shank.mass_kg + body.thigh.mass_kg;
    body.trunk.mass_kg = Share() * ((body.trunk.mass_kg / share_ + 2 * leg_kg) * all - 2 * drawn_kg);
    body.trunk.gyration_m *= Factor(u_.trunk_gyration);
    return body;
  }

  TrunkPrior Prior(TrunkPrior prior) {
    prior.spread *= Factor(0.2);
    prior.memory_s *= Factor(0.3);
    prior.wobble_m *= Factor(0.5);
    prior.posture_m *= Factor(0.5);
    return prior;
  }

  // Joints beside their markers, and curves beside the leg fit's by its own standard deviations, as fast as the
  // low-pass lets them change.
  LegPath Path(const LegPath& path, double cutoff_hz) {
    LegPath drawn = path;
    const SplineGrid grid = MakeSplineGrid(path.time_s, 1 / (2 * cutoff_hz));
    for (std::size_t joint = 0; joint < kJoints; ++joint)
      for (int axis = 0; axis < 2; ++axis) {
        const double beside_m = Normal(joint == kHip ? 1.5 * u_.joint_m : u_.joint_m);
        std::vector<double> coefficients(grid.count);
        for (double& value : coefficients) value = Normal(1.44 * path.sigma_m[joint]);
        for (std::size_t i = 0; i < path.frames.size(); ++i) {
          const SplineGrid::Place place = grid.At(path.time_s[i]);
          PointMotion& point = drawn.frames[i][joint];
          point.position_m[axis] += beside_m + ValueAt(place, coefficients);
          point.velocity_m_s[axis] += SlopeAt(place, coefficients);
          point.acceleration_m_s2[axis] += CurveAt(place, coefficients);
        }
      }
    return drawn;
  }

  // The same rises, their events beside where they were found, and still in their order.
  std::vector<Rise> Rises(std::vector<Rise> rises) {
    std::normal_distribution<double> normal;
    for (Rise& rise : rises) {
      rise.seat_off_s += rise.seat_off_sd_s * normal(event_random_);
      rise.onset_s = std::min(rise.onset_s + rise.onset_sd_s * normal(event_random_), rise.seat_off_s);
      rise.standing_s = std::max(rise.standing_s + rise.standing_sd_s * normal(event_random_), rise.seat_off_s);
    }
    return rises;
  }

  std::vector<std::optional<Wrench>> Ground(std::vector<std::optional<Wrench>> ground) {
    const double factor = Factor(u_.ground_force), shift_m = Normal(u_.pressure_m);
    for (std::optional<Wrench>& wrench : ground)
      if (wrench) {
        wrench->force_n *= factor;
        wrench->moment_nm = factor * wrench->moment_nm + shift_m * wrench->force_n.y();
      }
    return ground;
  }

 private:
  // Of the trunk that this leg bears.
  double Share() {
    if (u_.trunk_share)
      return std::clamp(share_ + *u_.trunk_share * std::normal_distribution<double>()(share_random_), 0.0, 1.0);
    return std::uniform_real_distribution<double>()(share_random_);
  }

  Uncertainty u_;
  double share_;
  std::mt19937_64 random_, axis_random_, event_random_, share_random_;
  std::normal_distribution<double> normal_;
};

// Angle and its speed at a time.
void SetKnee(const motion::LegMotion& motion, double at_s, LoadsRow& row) {
  const Between b = Locate(motion.time_s, at_s);
  const motion::LegSample &before = motion.samples[b.before], &after = motion.samples[b.before + 1];
  row.knee_deg = std::lerp(before.knee_deg, after.knee_deg, b.part);
  row.knee_deg_s = std::lerp(before.knee_deg_s, after.knee_deg_s, b.part);
}

// The knee's moments between which those lie while the seat bears an unknown part; NaN where not known.
struct SeatBounds {
  double low_nm = LoadsRow::kUnknown, high_nm = LoadsRow::kUnknown;
};

// Without the seat; and with the weight on it, while the foot pushes or pulls along the floor with what the seat's
// friction holds. Floor and seat both hold most where each bears half.
SeatBounds SeatBoundsAt(const Model& model, std::size_t frame) {
  constexpr double kSeatFriction = 0.3;  // clothes on a plain chair; more is seldom used before the seat is left
  const LegPoints& points = model.path.frames[frame];
  const LegBody& body = model.body;
  const double weight_n = kGravity_m_s2 * MassKg(body);
  SeatBounds bounds;
  bounds.low_nm = bounds.high_nm = LoadsAt(model, frame).moments.knee_nm;
  for (const double push : {-1.0, 1.0}) {
    Wrench along_floor;
    along_floor.force_n.x() = push * kSeatFriction * weight_n / 2;
    along_floor.moment_nm = -GroundPoint(points, body).y() * along_floor.force_n.x();
    const double seated_nm = LoadsFromGround(points, body, along_floor).moments.knee_nm;
    bounds.low_nm = std::min(bounds.low_nm, seated_nm);
    bounds.high_nm = std::max(bounds.high_nm, seated_nm);
  }
  return bounds;
}

// At each percent of a rise while the seat bears a part.
std::vector<SeatBounds> SeatBoundsOf(const Model& model, const Rise& rise, const LoadsOptions& options) {
  std::vector<SeatBounds> bounds(kPercents);
  for (int percent = 0; percent < kPercents; ++percent) {
    const double at_s = TimeOf(rise, percent);
    const std::size_t frame = Locate(model.path.time_s, at_s).before;
    if (!model.trunk || SeatIsLeft(rise, at_s, options) || !model.path.known[frame]) continue;
    bounds[static_cast<std::size_t>(percent)] = SeatBoundsAt(model, frame);
  }
  return bounds;
}

// What the seat bears is not known, and the bounds are as uncertain as the moments: the lower one's 2.5 % and the
// higher one's 97.5 %, by the same draws.
void SetBounds(const std::vector<std::vector<SeatBounds>>& draws, RiseLoads& loads) {
  for (std::size_t percent = 0; percent < loads.rows.size(); ++percent) {
    std::vector<double> low_nm, high_nm;
    for (const std::vector<SeatBounds>& bounds : draws) {
      if (std::isnan(bounds[percent].low_nm)) continue;
      low_nm.push_back(bounds[percent].low_nm);
      high_nm.push_back(bounds[percent].high_nm);
    }
    if (low_nm.empty()) continue;
    loads.rows[percent].knee_low_nm = Quantile(low_nm, kLow);
    loads.rows[percent].knee_high_nm = Quantile(high_nm, kHigh);
  }
}

void SetLoads(const LegLoads& loads, bool seat_is_left, LoadsRow& row) {
  row.ankle_nm = loads.moments.ankle_nm;
  row.knee_nm = loads.moments.knee_nm;
  if (seat_is_left) row.hip_nm = loads.moments.hip_nm;
  row.ground_force_n = loads.ground_force_n.y();
  // A force near zero acts nowhere.
  constexpr double kLeastForce_n = 20;
  if (row.ground_force_n > kLeastForce_n) row.zmp_mm = kMmPerM * loads.zmp_m;
  row.knee_power_w = -row.knee_nm * RadiansFromDegrees(row.knee_deg_s);
}

RiseLoads RiseOf(const Model& model, const motion::LegMotion& motion, const Rise& rise, const LoadsOptions& options) {
  RiseLoads loads{.repetition = rise.repetition,
                  .onset_s = rise.onset_s,
                  .seat_off_s = rise.seat_off_s,
                  .standing_s = rise.standing_s,
                  .rows = {},
                  .peak = {},
                  .knee_energy_j = 0,
                  .momentum = {},
                  .momentum_sd = {}};
  for (int percent = 0; percent < kPercents; ++percent) {
    LoadsRow& row = loads.rows.emplace_back();
    row.time_s = TimeOf(rise, percent);
    SetKnee(motion, row.time_s, row);
    const bool seat_is_left = SeatIsLeft(rise, row.time_s, options);
    if (model.trunk && !seat_is_left) continue;
    if (const auto at = LoadsAtTime(model, row.time_s)) SetLoads(*at, seat_is_left, row);
  }
  return loads;
}

void SetPeak(RiseLoads& loads) {
  loads.peak.knee_nm = LoadsRow::kUnknown;
  for (std::size_t percent = 0; percent < loads.rows.size(); ++percent) {
    const LoadsRow& row = loads.rows[percent];
    if (std::isnan(row.knee_nm) || row.knee_nm <= loads.peak.knee_nm) continue;
    loads.peak = {row.knee_nm, 0, 0, row.knee_deg, static_cast<double>(percent)};
  }
  for (std::size_t p = 1; p < loads.rows.size(); ++p) {
    const double mean_w = (loads.rows[p].knee_power_w + loads.rows[p - 1].knee_power_w) / 2;
    if (std::isfinite(mean_w)) loads.knee_energy_j += mean_w * (loads.rows[p].time_s - loads.rows[p - 1].time_s);
  }
}

// Bands and the peak's interval from the draws' curves.
void SetBands(const std::vector<std::vector<double>>& curves, RiseLoads& loads) {
  for (std::size_t percent = 0; percent < loads.rows.size(); ++percent) {
    std::vector<double> values;
    for (const std::vector<double>& curve : curves)
      if (std::isfinite(curve[percent])) values.push_back(curve[percent]);
    LoadsRow& row = loads.rows[percent];
    if (values.size() < 2 || std::isnan(row.knee_nm)) continue;
    row.knee_sd_nm = StandardDeviation(values);
    row.knee_low_nm = Quantile(values, kLow);
    row.knee_high_nm = Quantile(values, kHigh);
  }
  std::vector<double> peaks;
  for (const std::vector<double>& curve : curves)
    if (const double peak = Largest(curve); std::isfinite(peak)) peaks.push_back(peak);
  loads.peak.low_nm = Quantile(peaks, kLow);
  loads.peak.high_nm = Quantile(peaks, kHigh);
}

// The mean of all rises at each percent; empty where one of them is.
RiseLoads MeanOf(const std::vector<RiseLoads>& rises) {
  RiseLoads mean;
  for (int percent = 0; percent < kPercents; ++percent) {
    LoadsRow& row = mean.rows.emplace_back();
    const auto average = [&](auto member) {
      double sum = 0;
      for (const RiseLoads& rise : rises) sum += rise.rows[static_cast<std::size_t>(percent)].*member;
      return sum / static_cast<double>(rises.size());
    };
    row.time_s = 0;
    for (const RiseLoads& rise : rises)
      row.time_s += percent / 100.0 * (rise.standing_s - rise.onset_s) / static_cast<double>(rises.size());
    for (const auto member : {&LoadsRow::knee_deg, &LoadsRow::knee_deg_s, &LoadsRow::ankle_nm, &LoadsRow::knee_nm,
                              &LoadsRow::hip_nm, &LoadsRow::zmp_mm, &LoadsRow::ground_force_n, &LoadsRow::knee_power_w})
      row.*member = average(member);
    if (std::isfinite(row.knee_nm)) continue;
    for (const RiseLoads& rise : rises) {
      const LoadsRow& one = rise.rows[static_cast<std::size_t>(percent)];
      if (std::isfinite(one.knee_nm)) continue;
      row.knee_low_nm = std::fmin(row.knee_low_nm, one.knee_low_nm);  // of a number and NaN: the number
      row.knee_high_nm = std::fmax(row.knee_high_nm, one.knee_high_nm);
    }
  }
  return mean;
}

std::vector<std::vector<double>> MeanCurves(const std::vector<std::vector<std::vector<double>>>& by_rise) {
  std::vector<std::vector<double>> means = by_rise.front();
  for (std::size_t draw = 0; draw < means.size(); ++draw)
    for (std::size_t percent = 0; percent < means[draw].size(); ++percent) {
      double sum = 0;
      for (const auto& curves : by_rise) sum += curves[draw][percent];
      means[draw][percent] = sum / static_cast<double>(by_rise.size());
    }
  return means;
}

MomentumSd SpreadOf(const std::vector<RiseMomentum>& draws) {
  const auto of = [&](double RiseMomentum::*member) {
    std::vector<double> values;
    for (const RiseMomentum& draw : draws)
      if (std::isfinite(draw.*member)) values.push_back(draw.*member);
    return StandardDeviation(values);
  };
  return {.seat_off_m = of(&RiseMomentum::seat_off_m),
          .forward_seat_off_m_s = of(&RiseMomentum::forward_seat_off_m_s),
          .forward_max_m_s = of(&RiseMomentum::forward_max_m_s),
          .upward_max_m_s = of(&RiseMomentum::upward_max_m_s)};
}

// Those that the forces hold from onset to standing.
std::vector<Rise> RisesWithin(const GroundForces& forces, const std::vector<Rise>& rises) {
  if (forces.time_s.size() < 3) throw Fail("loads: forces at {} times are too few", forces.time_s.size());
  std::vector<Rise> held;
  for (const Rise& rise : rises)
    if (forces.time_s.front() <= rise.onset_s && forces.time_s.back() >= rise.standing_s) held.push_back(rise);
  if (!held.empty()) return held;
  throw Fail(
      "loads: the forces run from {:.2f} to {:.2f} s, and hold none of the rises ({:.2f} to {:.2f} s): are they of "
      "another trial?",
      forces.time_s.front(), forces.time_s.back(), rises.front().onset_s, rises.back().standing_s);
}

// Calls look(points, loads) for each percent of the rises, from where the seat has let go.
template <typename Look>
void ForEachOnTheFeet(const Model& model, const std::vector<Rise>& rises, const LoadsOptions& options,
                      const Look& look) {
  for (const Rise& rise : rises)
    for (int percent = 0; percent < kPercents; ++percent) {
      const double at_s = TimeOf(rise, percent);
      const auto loads = LoadsAtTime(model, at_s);
      if (loads && SeatIsLeft(rise, at_s, options))
        look(model.path.frames[Locate(model.path.time_s, at_s).before], *loads);
    }
}

// Vertical, on this foot, by the motion alone.
double NeededForce_n(const LegPoints& points, const LegBody& body) {
  return LoadsFromTrunk(points, body, {}).ground_force_n.y();
}

// Forces that no ground gives to a foot. What is too small to bear a leg may be a plate's zero.
void CheckForces(const Model& model, const std::vector<Rise>& rises, const LoadsOptions& options) {
  constexpr double kBears = 0.2;  // of what the motion needs
  std::vector<double> force_n, before_m;
  ForEachOnTheFeet(model, rises, options, [&](const LegPoints& points, const LegLoads& loads) {
    if (std::abs(loads.ground_force_n.y()) < kBears * NeededForce_n(points, model.body)) return;
    force_n.push_back(loads.ground_force_n.y());
    before_m.push_back(loads.zmp_m);
  });
  if (force_n.empty()) return;
  if (Median(force_n) < 0)
    throw Fail(
        "loads: the ground pulls the foot down, by {:.0f} N in the median of the rises: the forces have the opposite "
        "sign; give those on the foot, not those on the plate",
        -Median(force_n));
  constexpr double kFoot_m = 1, kLaboratory_m = 20;  // none is as long
  const double from_m = Median(before_m);
  if (std::abs(from_m) < kFoot_m) return;
  throw Fail("loads: the force acts {} m {} the ankle in the median of the rises, where no foot is: {}",
             SignificantText(std::abs(from_m), 4), from_m > 0 ? "before" : "behind",
             std::abs(from_m) > kLaboratory_m
                 ? "its points seem to be in mm, and are read in m"
                 : "are the axes and the origin the markers' own, and is it this foot's plate?");
}

// A clock that is not the markers'.
void WarnOfClock(const Model& model, const std::vector<Window>& windows, LoadsResult& result) {
  std::vector<double> needed_n, measured_n;
  for (std::size_t i = 0; i < model.path.frames.size(); ++i) {
    const bool known = model.path.known[i] != 0;
    needed_n.push_back(known ? NeededForce_n(model.path.frames[i], model.body) : LoadsRow::kUnknown);
    measured_n.push_back(model.ground[i] ? model.ground[i]->force_n.y() : LoadsRow::kUnknown);
  }
  const auto offset = FindClockOffset(model.path.time_s, needed_n, measured_n, windows);
  constexpr double kSure = 3;  // standard deviations
  if (!offset || std::abs(offset->add_s) < kSure * offset->sd_s) return;
  result.warnings.push_back(fmt::format(
      "the forces' clock is not the markers': the forces follow the motion best with {} s (1 "
      "SD) added to their times; bring them to one clock (lake sync TRIAL FORCES, then --sync sync.yaml), as "
      "moments of forces and angles of other moments are wrong",
      WithSign(PlusMinusText(offset->add_s, offset->sd_s, 3))));
}

// Forces that the motion contradicts: of another leg, another trial, other axes.
void WarnOfForces(const Model& model, const std::vector<Rise>& rises, const LoadsOptions& options,
                  LoadsResult& result) {
  int outside = 0, count = 0;
  std::vector<double> force, expected, zmp_mm;
  ForEachOnTheFeet(model, rises, options, [&](const LegPoints& points, const LegLoads& loads) {
    force.push_back(loads.ground_force_n.y());
    expected.push_back(NeededForce_n(points, model.body));
    zmp_mm.push_back(kMmPerM * loads.zmp_m);
    outside += loads.zmp_m < -model.body.sole.heel_m || loads.zmp_m > model.body.sole.toe_m;
    ++count;
  });
  if (count == 0) return;
  const double ratio = Mean(force) / Mean(expected);
  if (ratio < 0.7 || ratio > 1.4)
    result.warnings.push_back(fmt::format(
        "while rising the plate bears {:.0f} N on average, the motion of {:.1f} kg on this leg needs {:.0f} N: is it "
        "this leg's plate, and this trial's?",
        Mean(force), MassKg(result.body), Mean(expected)));
  if (outside > count / 10)
    result.warnings.push_back(fmt::format(
        "the force acts outside the foot ({:.0f} to {:.0f} mm before the ankle) for {} of {} moments of the rises, at "
        "{:.0f} mm in the median: are plates and axes right?",
        -kMmPerM * model.body.sole.heel_m, kMmPerM * model.body.sole.toe_m, outside, count, Median(zmp_mm)));
}

void WarnOfTrunk(const Model& model, const std::vector<Window>& windows, const LoadsOptions& options,
                 LoadsResult& result) {
  int outside = 0, count = 0;
  for (const Window& window : windows)
    for (std::size_t i = window.begin; i < window.end; ++i) {
      if (!model.path.known[i]) continue;
      const double zmp_m = LoadsAt(model, i).zmp_m;
      outside += zmp_m < -model.body.sole.heel_m || zmp_m > model.body.sole.toe_m;
      ++count;
    }
  if (outside > count / 10)
    result.warnings.push_back(fmt::format(
        "for {} of {} frames on the feet alone the zero-moment point is outside the foot: the trunk's markers do not "
        "tell its movement, and the moments are less certain than the bands say",
        outside, count));
  const double across_sd_m = model.path.has_shoulder ? options.trunk.across_m : options.trunk.across_from_waist_m;
  if (std::abs(model.trunk->AlongM()) > 3 * options.trunk.along_m || std::abs(model.trunk->AcrossM()) > 3 * across_sd_m)
    result.warnings.push_back(
        fmt::format("the trunk's centre of mass is {:.0f} mm along and {:.0f} mm across the trunk from where the table "
                    "has it, farther than people differ: check --map, --mass and --foot",
                    kMmPerM * model.trunk->AlongM(), kMmPerM * model.trunk->AcrossM()));
}

Model ByMotionAlone(const motion::MarkerRecording& trajectory, LegPathOptions path_options,
                    const std::vector<Window>& windows, const LoadsOptions& options) {
  path_options.cutoff_hz = options.cutoff_hz;
  Model model{MakeLegPath(trajectory, path_options), {}, {}, {}};
  model.body = MakeLegBody(options.body, model.path);
  model.trunk.emplace(model.path, model.body, windows, options.trunk);
  return model;
}

// The trial as measured, which the draws vary.
struct Measured {
  std::vector<Rise> rises;
  std::size_t without_forces = 0;  // rises left out
  std::vector<Window> windows;
  std::vector<double> cutoffs_hz;
  std::vector<LegPath> paths;  // one per cutoff; the model has the first
  LegPath at_custom;           // low-passed as is the field's custom
  Model model;
  Model by_motion;  // without plates; what is of the motion alone is the same with them

  const TrunkFit& Trunk() const { return *by_motion.trunk; }
};

// Without plates the result depends on the cutoff: the draws take several.
std::vector<double> CutoffsHz(const LoadsOptions& options, bool with_forces) {
  if (with_forces) return {options.cutoff_with_forces_hz};
  std::vector<double> cutoffs_hz{1, 0.75, 0.875, 1.125, 1.25};
  for (double& cutoff_hz : cutoffs_hz) cutoff_hz *= options.cutoff_hz;
  return cutoffs_hz;
}

Measured Measure(const motion::MarkerRecording& trajectory, const std::vector<motion::StsEvent>& events,
                 LegPathOptions path_options, const LoadsOptions& options, const std::optional<GroundForces>& forces) {
  Measured measured;
  measured.rises = RisesOf(events);
  if (forces) {
    std::vector<Rise> held = RisesWithin(*forces, measured.rises);
    measured.without_forces = measured.rises.size() - held.size();
    measured.rises = std::move(held);
  }
  path_options.cutoff_hz = options.cutoff_with_forces_hz;
  measured.at_custom = MakeLegPath(trajectory, path_options);
  measured.windows = WindowsOf(measured.rises, trajectory.time_s, options);
  measured.cutoffs_hz = CutoffsHz(options, forces.has_value());
  for (const double cutoff_hz : measured.cutoffs_hz) {
    path_options.cutoff_hz = cutoff_hz;
    measured.paths.push_back(MakeLegPath(trajectory, path_options));
  }
  measured.by_motion = ByMotionAlone(trajectory, path_options, measured.windows, options);
  if (!forces) {
    measured.model = measured.by_motion;
    return measured;
  }
  measured.model = {measured.paths.front(), MakeLegBody(options.body, measured.paths.front()), {}, {}};
  measured.model.ground = ForcesAtFrames(*forces, trajectory.time_s, measured.cutoffs_hz.front());
  CheckForces(measured.model, measured.rises, options);
  return measured;
}

// With the trunk's centre where the table has it: where the fitted one lies along the trunk is hardly determined by the
// zero-moment point, and the largest velocities hang on it.
RiseMomentum MomentumOf(const LegPath& path, const LegBody& body, const Vector2d& in_trunk_m, const Rise& rise,
                        const LoadsOptions& options) {
  return FindMomentum(path, body, options.body.mass_kg, in_trunk_m, rise.onset_s, rise.seat_off_s, rise.standing_s);
}

// By rise and draw. They are of the motion alone: plates change nothing.
std::vector<std::vector<RiseMomentum>> DrawMomenta(const Measured& measured, const LoadsOptions& options) {
  std::vector<std::vector<RiseMomentum>> momenta(measured.rises.size());
  const TrunkPrior& trunk = options.trunk;
  const double across_sd_m = measured.at_custom.has_shoulder ? trunk.across_m : trunk.across_from_waist_m;
  Drawing drawing(options, options.seed + 4);
  for (int draw = 0; draw < options.draws; ++draw) {
    ThrowIfInterrupted();
    const std::vector<Rise> rises = drawing.Rises(measured.rises);
    const LegPath path = drawing.Path(measured.at_custom, options.cutoff_with_forces_hz);
    const LegBody body = drawing.Body(measured.by_motion.body);
    const double along_m = drawing.Normal(trunk.along_m), across_m = drawing.Normal(across_sd_m);
    for (std::size_t r = 0; r < rises.size(); ++r) {
      const Vector2d own(along_m + drawing.Normal(trunk.posture_m), across_m + drawing.Normal(trunk.posture_m));
      momenta[r].push_back(MomentumOf(path, body, own, rises[r], options));
    }
  }
  return momenta;
}

// What the draws say, rise by rise and draw by draw.
struct Drawn {
  std::vector<std::vector<std::vector<double>>> curves;
  std::vector<std::vector<std::vector<SeatBounds>>> bounds;
  // Of the trunk, the balance and the part of the weight on this leg, without plates.
  std::vector<double> along_m, across_m, slow_margin_mm, weight_share;
};

Drawn Draw(const Measured& measured, const LoadsOptions& options) {
  const std::size_t rises = measured.rises.size();
  Drawn drawn;
  drawn.curves.resize(rises);
  drawn.bounds.resize(rises);
  Drawing drawing(options, options.seed);
  for (int draw = 0; draw < options.draws; ++draw) {
    ThrowIfInterrupted();
    const std::size_t which = drawing.Index(measured.paths.size());
    const std::vector<Rise> drawn_rises = drawing.Rises(measured.rises);
    Model model{
        drawing.Path(measured.paths[which], measured.cutoffs_hz[which]), drawing.Body(measured.model.body), {}, {}};
    if (!measured.model.ground.empty()) {
      model.ground = drawing.Ground(measured.model.ground);
    } else {
      const TrunkFit fit(model.path, model.body, measured.windows, drawing.Prior(options.trunk));
      model.trunk = fit.Draw(drawing.Random());
      drawn.slow_margin_mm.push_back(SlowMargin(model, *model.trunk, drawn_rises, options));
      drawn.along_m.push_back(model.trunk->AlongM());
      drawn.across_m.push_back(model.trunk->AcrossM());
      drawn.weight_share.push_back(MassKg(model.body) / options.body.mass_kg);
    }
    const double axis_factor = drawing.AxisFactor();
    for (std::size_t r = 0; r < rises; ++r) {
      drawn.curves[r].push_back(KneeCurve(model, drawn_rises[r], options, axis_factor));
      drawn.bounds[r].push_back(SeatBoundsOf(model, drawn_rises[r], options));
    }
  }
  return drawn;
}

// Each rise, and the mean of all.
void SetRises(const Measured& measured, const Drawn& drawn, const motion::LegMotion& motion,
              const LoadsOptions& options, LoadsResult& result) {
  for (std::size_t r = 0; r < measured.rises.size(); ++r) {
    RiseLoads& loads = result.rises.emplace_back(RiseOf(measured.model, motion, measured.rises[r], options));
    SetPeak(loads);
    SetBands(drawn.curves[r], loads);
    SetBounds(drawn.bounds[r], loads);
  }
  result.mean = MeanOf(result.rises);
  SetPeak(result.mean);
  SetBands(MeanCurves(drawn.curves), result.mean);
}

void SetTrunk(const Measured& measured, const Drawn& drawn, LoadsResult& result) {
  const TrunkFit& trunk = *measured.model.trunk;
  result.trunk_offset_mm = kMmPerM * Vector2d(trunk.AlongM(), trunk.AcrossM());
  result.trunk_offset_sd_mm = kMmPerM * Vector2d(StandardDeviation(drawn.along_m), StandardDeviation(drawn.across_m));
  result.weight_share = {Quantile(drawn.weight_share, kLow), Quantile(drawn.weight_share, kHigh)};
  result.balance.slow_margin_low_mm = Quantile(drawn.slow_margin_mm, kLow);
  result.balance.slow_margin_high_mm = Quantile(drawn.slow_margin_mm, kHigh);
}

}  // namespace

void Describe(LoadsOptions& o, OptionList& options) {
  Describe(o.body, options);
  options.Check([&o](const OptionList& list) {
    constexpr double kOfAGivenShare = 0.025;  // nobody stands quite evenly either
    if (list.IsGiven("share")) o.uncertainty.trunk_share = kOfAGivenShare;
  });
  options
      .Add("rise-time", o.rise_s,
           "Another time for the rise: the moments of the same path in it, and whether the balance is kept")
      .Unit("s")
      .Between(0.3, 300);
  options.Add("draws", o.draws, "Draws that the 95 % bands are taken from").Between(20, 100'000);
  options.Add("seed-number", o.seed, "Seed of the draws");
}

LoadsResult FindLoads(const motion::MarkerRecording& trajectory, const motion::LegMotion& motion,
                      const std::vector<motion::StsEvent>& events, const LegPathOptions& path_options,
                      const LoadsOptions& options, const std::optional<GroundForces>& forces) {
  options.body.Check();
  const Measured measured = Measure(trajectory, events, path_options, options, forces);
  const Drawn drawn = Draw(measured, options);
  const std::vector<std::vector<RiseMomentum>> momenta = DrawMomenta(measured, options);
  LoadsResult result;
  result.from_ground = forces.has_value();
  result.has_shoulder = measured.model.path.has_shoulder;
  result.body = measured.model.body;
  SetRises(measured, drawn, motion, options, result);
  for (std::size_t r = 0; r < measured.rises.size(); ++r) {
    result.rises[r].momentum =
        MomentumOf(measured.at_custom, measured.by_motion.body, Vector2d::Zero(), measured.rises[r], options);
    result.rises[r].momentum_sd = SpreadOf(momenta[r]);
  }
  result.balance = FindBalance(measured.by_motion, measured.Trunk(), measured.rises, options);
  result.body_path = MeanBodyPath(measured.by_motion, measured.Trunk(), measured.rises, options);
  if (const auto warning = BalanceWarning(result.balance)) result.warnings.push_back(*warning);
  if (const std::size_t held = measured.rises.size(); measured.without_forces > 0)
    result.warnings.push_back(
        fmt::format("the forces run from {:.2f} to {:.2f} s and hold {} of the {} rises: the others are left out",
                    forces->time_s.front(), forces->time_s.back(), held, held + measured.without_forces));
  if (forces) {
    WarnOfForces(measured.model, measured.rises, options, result);
    WarnOfClock(measured.model, measured.windows, result);
  } else {
    SetTrunk(measured, drawn, result);
    WarnOfTrunk(measured.model, measured.windows, options, result);
  }
  return result;
}

LoadsResult FindStanceLoads(const motion::MarkerRecording& trajectory, const motion::LegMotion& motion,
                            const std::vector<Stance>& stances, LegPathOptions path_options, LoadsOptions options,
                            const GroundForces& forces) {
  options.body.Check();
  options.seat_release_s = 0;  // there is no seat
  path_options.cutoff_hz = options.cutoff_with_forces_hz;
  Measured measured;
  for (const Stance& stance : stances) {
    Rise& rise = measured.rises.emplace_back();
    rise.repetition = stance.repetition;
    rise.onset_s = rise.seat_off_s = stance.begin_s;
    rise.standing_s = stance.end_s;
  }
  measured.cutoffs_hz = {path_options.cutoff_hz};
  measured.paths = {MakeLegPath(trajectory, path_options)};
  measured.model = {measured.paths.front(),
                    MakeLegBody(options.body, measured.paths.front()),
                    {},
                    ForcesAtFrames(forces, trajectory.time_s, path_options.cutoff_hz)};
  CheckForces(measured.model, measured.rises, options);
  LoadsResult result;
  result.from_ground = true;
  result.repetition = "stance";
  result.body = measured.model.body;
  SetRises(measured, Draw(measured, options), motion, options, result);
  return result;
}

}  // namespace lake::loads
