#include "lake/gait/gait_cycles.h"

#include <algorithm>
#include <array>
#include <optional>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

using motion::StsEventKind;

constexpr const char* kPerry = "Perry and Burnfield 2010, Gait Analysis, 2nd ed.";
constexpr const char* kWinter = "Winter 1991, Biomechanics and Motor Control of Human Gait, 2nd ed.";

constexpr auto kStrideFields = std::to_array<Field<GaitCycle>>(
    {{"begin_s", "s", "time of the heel strike with which the stride begins", kPerry, &GaitCycle::begin_s, 3,
      FieldKind::kMoment},
     {"stride_s", "s", "stride time: to the next heel strike of the same leg", kPerry, &GaitCycle::stride_s, 3},
     {"stance_s", "s", "stance time: from heel strike to toe-off", kPerry, &GaitCycle::stance_s, 3},
     {"stance_percent", "%", "stance time in percent of the stride", kPerry, &GaitCycle::stance_percent, 1},
     {"swing_s", "s", "swing time: from toe-off to the next heel strike", kPerry, &GaitCycle::swing_s, 3},
     {"cadence_steps_min", "1/min", "steps per minute: two per stride", kWinter, &GaitCycle::cadence_steps_min, 1},
     {"stride_mm", "mm",
      "stride length: from heel to heel (ankle to ankle without heel markers), the foot flat on the "
      "ground; of a treadmill with the belt's travel",
      kWinter, &GaitCycle::stride_length, 0},
     {"speed_mm_s", "mm/s", "walking speed: stride length over stride time", kWinter, &GaitCycle::speed, 0},
     {"knee_heel_strike_deg", "deg", "knee flexion at heel strike", kPerry, &GaitCycle::knee_heel_strike_deg, 1},
     {"knee_loading_deg", "deg", "largest knee flexion in loading response: the first 25 % of the stride", kPerry,
      &GaitCycle::knee_loading_deg, 1},
     {"knee_stance_min_deg", "deg", "least knee flexion between that and toe-off", kPerry,
      &GaitCycle::knee_stance_min_deg, 1},
     {"knee_toe_off_deg", "deg", "knee flexion at toe-off", kPerry, &GaitCycle::knee_toe_off_deg, 1},
     {"knee_swing_deg", "deg", "largest knee flexion in swing", kPerry, &GaitCycle::knee_swing_deg, 1},
     {"knee_range_deg", "deg", "range of knee flexion over the stride", kPerry, &GaitCycle::knee_range_deg, 1},
     {"thigh_range_deg", "deg", "range of the thigh's angle from the vertical", kPerry, &GaitCycle::thigh_range_deg, 1},
     {"shank_range_deg", "deg", "range of the shank's angle from the vertical", kPerry, &GaitCycle::shank_range_deg, 1},
     {"trunk_range_deg", "deg", "range of the trunk's angle from the vertical", kPerry, &GaitCycle::trunk_range_deg, 1},
     {"foot_heel_strike_deg", "deg",
      "angle of the foot to where it rests on the ground, at heel strike: positive with the toe up", kPerry,
      &GaitCycle::foot_heel_strike_deg, 1},
     {"ankle_heel_strike_deg", "deg", "dorsiflexion at heel strike: 0 with the shank upright over the resting foot",
      kPerry, &GaitCycle::ankle_heel_strike_deg, 1},
     {"ankle_dorsiflexion_deg", "deg", "largest dorsiflexion in stance", kPerry, &GaitCycle::ankle_dorsiflexion_deg, 1},
     {"ankle_toe_off_deg", "deg", "dorsiflexion at toe-off: negative in plantarflexion", kPerry,
      &GaitCycle::ankle_toe_off_deg, 1},
     {"ankle_plantarflexion_deg", "deg",
      "least dorsiflexion from half of stance to half of swing: negative in plantarflexion", kPerry,
      &GaitCycle::ankle_plantarflexion_deg, 1},
     {"ankle_range_deg", "deg", "range of dorsiflexion over the stride", kPerry, &GaitCycle::ankle_range_deg, 1},
     {"step_s", "s", "step time: from the other leg's heel strike to this leg's, which ends the stride", kPerry,
      &GaitCycle::step_s, 3},
     {"step_mm", "mm", "step length: how far the heel (ankle) is before the other one at that heel strike", kWinter,
      &GaitCycle::step_length, 0},
     {"double_support_percent", "%", "time with both feet on the ground in percent of the stride", kPerry,
      &GaitCycle::double_support_percent, 1},
     {"step_symmetry_percent", "%", "symmetry index of the step times: this leg's less the other's, over their mean",
      "Robinson et al. 1987, J Manipulative Physiol Ther 10(4), 172-176", &GaitCycle::step_symmetry_percent, 1},
     {"toe_clearance_mm", "mm",
      "toe clearance: least height of the toe marker in the middle half of swing over its height in stance", kWinter,
      &GaitCycle::toe_clearance, 0}});

const motion::Angle& AngleOf(std::string_view name) {
  return *std::ranges::find_if(motion::Angles(), [&](const motion::Angle& angle) { return angle.name == name; });
}

class CycleMeasurer {
 public:
  CycleMeasurer(const LegFitResult& leg, double anatomical_sd_deg)
      : leg_(leg), m_(leg.motion), anatomical_sd_deg_(anatomical_sd_deg) {}

  std::vector<GaitCycle> Strides() const {
    std::vector<GaitCycle> strides;
    for (const auto& [strike, off, next] : StridesOf(leg_.events)) strides.push_back(Measure(strike, off, next));
    return strides;
  }

 private:
  const motion::StsEvent* First(int repetition, StsEventKind kind) const {
    const auto found = std::ranges::find_if(leg_.events, [&](const motion::StsEvent& event) {
      return event.repetition == repetition && event.kind == kind;
    });
    return found == leg_.events.end() ? nullptr : &*found;
  }

  // The part of an event's SD that is its own.
  static double OwnSd(const motion::StsEvent& event) {
    return std::sqrt(std::max(event.sd_s * event.sd_s - event.alike_sd_s * event.alike_sd_s, 0.0));  // NaN: not known
  }

  // Between two events of a kind that markers show, the part that is alike cancels; of a plate's event none is.
  static Measured Between(const motion::StsEvent& from, const motion::StsEvent& to) {
    const double duration_s = to.time_s - from.time_s;
    if (from.kind != to.kind) return {duration_s, std::hypot(from.sd_s, to.sd_s)};
    return {duration_s, std::hypot(OwnSd(from), OwnSd(to), to.alike_sd_s - from.alike_sd_s)};
  }

  // The heel strikes at both ends of a stride move the share together, as far as they are off alike.
  static Measured StancePercent(const motion::StsEvent& strike, const motion::StsEvent& off,
                                const motion::StsEvent& next) {
    const double stride_s = next.time_s - strike.time_s, share = (off.time_s - strike.time_s) / stride_s;
    const double strikes_s = std::hypot((1 - share) * OwnSd(strike), share * OwnSd(next),
                                        std::lerp(strike.alike_sd_s, next.alike_sd_s, share));
    return {100 * share, 100 * std::hypot(off.sd_s, strikes_s) / stride_s};
  }

  // A value that runs through the frames, at a time between two.
  template <typename Get>
  double At(double time_s, const Get& get) const {
    const auto after = static_cast<std::size_t>(std::ranges::lower_bound(m_.time_s, time_s) - m_.time_s.begin());
    if (after == m_.time_s.size()) return NAN;
    if (after == 0) return m_.time_s[0] == time_s ? get(0) : NAN;
    return std::lerp(get(after - 1), get(after),
                     (time_s - m_.time_s[after - 1]) / (m_.time_s[after] - m_.time_s[after - 1]));
  }

  Measured AngleAt(const motion::Angle& angle, const motion::StsEvent& event) const {
    const auto deg = [&](std::size_t i) { return m_.samples[i].*angle.deg; };
    const double sigma_deg = At(event.time_s, [&](std::size_t i) { return m_.samples[i].*angle.sigma_deg; });
    constexpr double kBeside_s = 0.01;
    const double from_s = std::max(event.time_s - kBeside_s, m_.time_s.front()),
                 to_s = std::min(event.time_s + kBeside_s, m_.time_s.back());
    const double speed_deg_s = (At(to_s, deg) - At(from_s, deg)) / (to_s - from_s);
    return {At(event.time_s, deg), std::hypot(sigma_deg, speed_deg_s * event.sd_s)};
  }

  Measured Anatomical(Measured knee) const { return {knee.value, std::hypot(knee.sd, anatomical_sd_deg_)}; }

  struct Extreme {
    Measured value;
    double time_s = NAN;
  };

  // The largest value of an angle, or with sign −1 the smallest, between two times.
  Extreme Find(const motion::Angle& angle, double from_s, double to_s, double sign) const {
    Extreme best;
    for (std::size_t i = 0; i < m_.time_s.size(); ++i)
      if (const double value = m_.samples[i].*angle.deg; m_.time_s[i] >= from_s && m_.time_s[i] <= to_s &&
                                                         std::isfinite(value) &&
                                                         !(sign * value <= sign * best.value.value))
        best = {{value, m_.samples[i].*angle.sigma_deg}, m_.time_s[i]};
    return best;
  }

  Measured Range(const motion::Angle& angle, double from_s, double to_s) const {
    const Measured high = Find(angle, from_s, to_s, 1).value, low = Find(angle, from_s, to_s, -1).value;
    // Where the foot rests is no part of a range.
    const double alike_deg = angle.name == std::string_view("ankle") ? m_.foot_rest_sd_deg : 0;
    return {high.value - low.value,
            std::sqrt(std::max(high.sd * high.sd + low.sd * low.sd - 2 * alike_deg * alike_deg, 0.0))};
  }

  // Of the heel, or the ankle where no heel is seen; forward (axis 0) or up, with its standard deviation.
  Measured Place(const std::string& heel, const std::string& ankle, double time_s, int axis = 0) const {
    for (const std::string* name : {&heel, &ankle}) {
      const motion::MarkerTrack* track = leg_.trajectory.Find(*name);
      if (!track) continue;
      const double place = At(time_s, [&](std::size_t i) {
        const motion::MarkerSample& sample = track->samples[i];
        return sample.IsKnown() ? LegFromPlane(sample.position, m_.facing, leg_.up)[axis] : NAN;
      });
      if (std::isfinite(place)) return {place, At(time_s, [&](std::size_t i) { return track->samples[i].sigma; })};
    }
    return {};
  }

  // Of the belt under the foot in stance, or as the options say it.
  double BeltSpeed(const motion::StsEvent& strike, double stance_s) const {
    if (leg_.movement.walk.ground == Ground::kOverground) return 0;
    if (o_.belt_speed_mm_s && m_.unit == motion::LengthUnit::kMm) return *o_.belt_speed_mm_s;
    const double from_s = strike.time_s + 0.2 * stance_s, to_s = strike.time_s + 0.5 * stance_s;
    return (OwnPlace(from_s).value - OwnPlace(to_s).value) / (to_s - from_s);
  }

  Measured OwnPlace(double time_s) const { return Place(o_.heel, leg_.leg_markers.ankle, time_s); }

  void MeasureLengths(const motion::StsEvent& strike, const motion::StsEvent& next, GaitCycle& cycle) const {
    const double stride_s = cycle.stride_s.value, belt = BeltSpeed(strike, cycle.stance_s.value);
    // Where the foot is flat it moves with the ground, and the event's own error does not count.
    double flat_s = 0.1 * stride_s;
    if (!std::isfinite(OwnPlace(next.time_s + flat_s).value)) flat_s = 0;
    const Measured from = OwnPlace(strike.time_s + flat_s), to = OwnPlace(next.time_s + flat_s);
    const double foot_speed = flat_s > 0 ? belt : (to.value - OwnPlace(next.time_s - 0.02).value) / 0.02;
    cycle.stride_length = {to.value - from.value + belt * stride_s,
                           std::hypot(from.sd, to.sd, foot_speed * cycle.stride_s.sd)};
    cycle.speed.value = cycle.stride_length.value / stride_s;
    cycle.speed.sd = std::hypot(cycle.stride_length.sd, cycle.speed.value * cycle.stride_s.sd) / stride_s;
  }

  void MeasureBothLegs(const motion::StsEvent& strike, const motion::StsEvent& off, const motion::StsEvent& next,
                       GaitCycle& cycle) const {
    const motion::StsEvent *other = First(strike.repetition, StsEventKind::kHeelStrikeOther),
                           *other_off = First(strike.repetition, StsEventKind::kToeOffOther);
    if (!other) return;
    cycle.step_s = Between(*other, next);
    const double other_step_s = other->time_s - strike.time_s, mean_s = cycle.stride_s.value / 2;
    cycle.step_symmetry_percent = {100 * (cycle.step_s.value - other_step_s) / mean_s, 100 * 2 * other->sd_s / mean_s};
    const Measured own = OwnPlace(next.time_s), others = Place(o_.other_heel, o_.other_ankle, next.time_s);
    const double slide = (OwnPlace(next.time_s).value - OwnPlace(next.time_s - 0.02).value) / 0.02;
    cycle.step_length = {own.value - others.value, std::hypot(own.sd, others.sd, slide * next.sd_s)};
    if (!other_off) return;
    const double both_s = other_off->time_s - strike.time_s + off.time_s - other->time_s;
    cycle.double_support_percent = {
        100 * both_s / cycle.stride_s.value,
        100 * std::hypot(std::hypot(other_off->sd_s, strike.sd_s), std::hypot(off.sd_s, other->sd_s)) /
            cycle.stride_s.value};
  }

  Measured ToeClearance(const motion::StsEvent& strike, const motion::StsEvent& off, const GaitCycle& cycle) const {
    if (!leg_.trajectory.Find(o_.toe)) return {};
    const Measured ground = Place(o_.toe, o_.toe, strike.time_s + 0.5 * cycle.stance_s.value, 1);
    Measured least;
    for (const double time_s : m_.time_s)
      if (time_s >= off.time_s + 0.25 * cycle.swing_s.value && time_s <= off.time_s + 0.75 * cycle.swing_s.value)
        if (const Measured at = Place(o_.toe, o_.toe, time_s, 1); !(at.value >= least.value)) least = at;
    return {least.value - ground.value, std::hypot(least.sd, ground.sd)};
  }

  GaitCycle Measure(const motion::StsEvent& strike, const motion::StsEvent& off, const motion::StsEvent& next) const {
    GaitCycle cycle;
    cycle.repetition = strike.repetition;
    cycle.begin_s = {strike.time_s, strike.sd_s};
    cycle.stride_s = Between(strike, next);
    cycle.stance_s = Between(strike, off);
    cycle.swing_s = Between(off, next);
    const double stride_s = cycle.stride_s.value;
    cycle.stance_percent = StancePercent(strike, off, next);
    cycle.cadence_steps_min = {120 / stride_s, 120 / stride_s * cycle.stride_s.sd / stride_s};
    const double loaded_s = std::min(strike.time_s + 0.25 * stride_s, off.time_s);
    const motion::Angle &knee = AngleOf("knee"), &ankle = AngleOf("ankle");
    const Extreme loading = Find(knee, strike.time_s, loaded_s, 1);
    cycle.knee_heel_strike_deg = Anatomical(AngleAt(knee, strike));
    cycle.knee_toe_off_deg = Anatomical(AngleAt(knee, off));
    cycle.knee_loading_deg = Anatomical(loading.value);
    cycle.knee_stance_min_deg = Anatomical(Find(knee, loading.time_s, off.time_s, -1).value);
    cycle.knee_swing_deg = Anatomical(Find(knee, off.time_s, next.time_s, 1).value);
    cycle.foot_heel_strike_deg = AngleAt(AngleOf("foot"), strike);
    cycle.ankle_heel_strike_deg = AngleAt(ankle, strike);
    cycle.ankle_dorsiflexion_deg = Find(ankle, strike.time_s, off.time_s, 1).value;
    cycle.ankle_toe_off_deg = AngleAt(ankle, off);
    cycle.ankle_plantarflexion_deg =
        Find(ankle, (strike.time_s + off.time_s) / 2, (off.time_s + next.time_s) / 2, -1).value;
    for (const auto& [name, range] : {std::pair{"knee", &GaitCycle::knee_range_deg},
                                      {"thigh", &GaitCycle::thigh_range_deg},
                                      {"shank", &GaitCycle::shank_range_deg},
                                      {"trunk", &GaitCycle::trunk_range_deg},
                                      {"ankle", &GaitCycle::ankle_range_deg}})
      cycle.*range = Range(AngleOf(name), strike.time_s, next.time_s);
    MeasureLengths(strike, next, cycle);
    MeasureBothLegs(strike, off, next, cycle);
    cycle.toe_clearance = ToeClearance(strike, off, cycle);
    return cycle;
  }

  const LegFitResult& leg_;
  const motion::LegMotion& m_;
  const WalkingOptions& o_ = leg_.movement.walking;
  double anatomical_sd_deg_;
};

}  // namespace

std::span<const Field<GaitCycle>> GaitCycle::Fields() {
  return kStrideFields;
}

Measures<GaitCycle> MeasureGaitCycles(const LegFitResult& leg, double anatomical_sd_deg) {
  return WithMeans(CycleMeasurer(leg, anatomical_sd_deg).Strides());
}

ReferenceCurve ReadReferenceCurve(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  ReferenceCurve curve;
  const std::size_t percent = table.Column("percent"), mean = table.Column("mean"), sd = table.Column("sd");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    curve.percent.push_back(table.RequiredNumber(row, percent));
    curve.mean_deg.push_back(table.RequiredNumber(row, mean));
    curve.sd_deg.push_back(table.RequiredNumber(row, sd));
    const double at = curve.percent.back(), least = row > 0 ? curve.percent[row - 1] : -1;
    if (!(at > least && at >= 0 && at <= 100))
      throw Fail("{}: percent {} is not between the row before and 100", table.Where(row), at);
    if (curve.sd_deg.back() < 0)
      throw Fail("{}: a standard deviation of {} is negative", table.Where(row), curve.sd_deg.back());
  }
  if (curve.percent.size() < 2) throw Fail("{}: a curve has two rows and more", path.string());
  return curve;
}

}  // namespace lake::gait
