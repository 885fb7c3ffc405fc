#include "lake/gait/sit_to_stand.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

constexpr std::size_t kFive = 5;
constexpr int kHalfCycles = 2 * kFive - 1;  // to the fifth standing: five rises and four lowerings
constexpr std::size_t kSteadied = 3;
constexpr double kLiftedMass = 0.9, kGravity_m_s2 = 9.81;

constexpr const char* kSchenkman = "Schenkman et al. 1990, doi:10.1093/ptj/70.10.638";
constexpr const char* kAlcazar = "Alcazar et al. 2018, doi:10.1016/j.exger.2018.08.006";
constexpr const char* kBohannon = "Bohannon 2006, doi:10.2466/pms.103.1.215-222";
constexpr const char* kWu = "Wu et al. 2002, doi:10.1016/S0021-9290(01)00222-6";
constexpr const char* kPai = "Pai and Rogers 1990, Med. Sci. Sports Exerc. 22(3), 378-384";

constexpr auto kRiseFields = std::to_array<Field<SitToStand>>(
    {{"onset_s", "s", "onset", kLake, &SitToStand::onset_s, 3, FieldKind::kMoment},
     {"seat_off_s", "s", "seat-off", kLake, &SitToStand::seat_off_s, 3, FieldKind::kMoment},
     {"standing_s", "s", "standing", kLake, &SitToStand::standing_s, 3, FieldKind::kMoment},
     {"rise_s", "s", "rise time", kLake, &SitToStand::rise_s, 3},
     {"flexion_s", "s", "flexion momentum: onset to seat-off", kSchenkman, &SitToStand::flexion_s, 3},
     {"transfer_s", "s", "momentum transfer: seat-off to largest ankle dorsiflexion", kSchenkman,
      &SitToStand::transfer_s, 3},
     {"extension_s", "s", "extension: from there to standing", kSchenkman, &SitToStand::extension_s, 3},
     {"stabilisation_s", "s", "stabilisation: from standing until steady", kSchenkman, &SitToStand::stabilisation_s, 3},
     {"descent_s", "s", "time to sit down", kLake, &SitToStand::descent_s, 3},
     {"knee_seat_off_deg", "deg", "knee angle at seat-off", kLake, &SitToStand::knee_seat_off_deg, 1},
     {"hip_seat_off_deg", "deg", "hip angle at seat-off", kLake, &SitToStand::hip_seat_off_deg, 1},
     {"trunk_seat_off_deg", "deg", "trunk lean at seat-off", kLake, &SitToStand::trunk_seat_off_deg, 1},
     {"knee_max_deg", "deg", "largest knee angle", kLake, &SitToStand::knee_max_deg, 1},
     {"hip_max_deg", "deg", "largest hip angle", kLake, &SitToStand::hip_max_deg, 1},
     {"trunk_max_deg", "deg", "largest trunk lean", kLake, &SitToStand::trunk_max_deg, 1},
     {"knee_extension_max_deg_s", "deg/s", "fastest knee extension", kLake, &SitToStand::knee_extension_max_deg_s, 0},
     {"trunk_flexion_max_deg_s", "deg/s", "fastest trunk flexion", kLake, &SitToStand::trunk_flexion_max_deg_s, 0},
     {"hip_rise_mm", "mm", "rise of the hip", kLake, &SitToStand::hip_rise, 0},
     {"hip_speed_mm_s", "mm/s", "mean speed of the hip, seat-off to standing", kLake, &SitToStand::hip_speed, 0},
     {"hip_speed_max_mm_s", "mm/s", "largest speed of the hip", kLake, &SitToStand::hip_speed_max, 0},
     {"power_w_kg", "W/kg", "mean power over body mass", kAlcazar, &SitToStand::power_w_kg, 2},
     {"five_times_s", "s", "five-times sit-to-stand", kBohannon, &SitToStand::five_times_s, 3},
     {"trunk_pelvis_seat_off_deg", "deg", "trunk lean to the pelvis at seat-off", kWu,
      &SitToStand::trunk_pelvis_seat_off_deg, 1},
     {"trunk_pelvis_max_deg", "deg", "largest trunk lean to the pelvis", kWu, &SitToStand::trunk_pelvis_max_deg, 1},
     {"com_seat_off_mm", "mm", "centre of mass before the ankle at seat-off", kPai, &SitToStand::com_seat_off_mm, 0,
      FieldKind::kOnlyMm},
     {"com_forward_max_mm_s", "mm/s", "largest speed forward of the centre of mass", kPai,
      &SitToStand::com_forward_max_mm_s, 0, FieldKind::kOnlyMm},
     {"com_upward_max_mm_s", "mm/s", "largest speed upward of the centre of mass", kPai,
      &SitToStand::com_upward_max_mm_s, 0, FieldKind::kOnlyMm}});

Measured Difference(const Measured& later, const Measured& earlier) {
  return {later.value - earlier.value, std::hypot(later.sd, earlier.sd)};
}

Measured Ratio(const Measured& of, const Measured& by) {
  const double ratio = of.value / by.value;
  return {ratio, std::abs(ratio) * std::hypot(of.sd / of.value, by.sd / by.value)};
}

Measured Times(double factor, const Measured& of) {
  return {factor * of.value, std::abs(factor) * of.sd};
}

// A quantity of every frame, with its SDs.
struct ValuesOfFrames {
  std::vector<double> value, sd;
};

// What a rise is measured by.
class Rises {
 public:
  Rises(const LegFitResult& fit, TrunkOnPelvis on_pelvis, const CentresOfMass& centres)
      : fit_(fit), time_s_(fit.motion.time_s), centres_(centres) {
    const StsDeviations& sd = fit.signals.sd;
    for (const motion::LegSample& sample : fit.motion.samples) {
      knee_.value.push_back(sample.knee_deg);
      knee_.sd.push_back(sample.knee_sigma_deg);
      hip_.value.push_back(sample.trunk_deg - sample.thigh_deg);
      trunk_.value.push_back(sample.trunk_deg);
    }
    hip_.sd = sd.hip_deg;
    trunk_.sd = sd.trunk_deg;
    on_pelvis_ = {std::move(on_pelvis.deg), std::move(on_pelvis.sd_deg)};
    height_ = {fit.signals.hip_height, sd.hip_height};
    hip_speed_ = {fit.signals.hip_up_speed, sd.hip_up_speed};
    trunk_speed_ = {fit.signals.trunk_deg_s, sd.trunk_deg_s};
    shank_ = {fit.signals.shank_deg, sd.shank_deg};
    extension_speed_ = {fit.signals.knee_deg_s, sd.knee_deg_s};
    for (double& speed : extension_speed_.value) speed = -speed;
    steadied_ = {{{fit.signals.hip_deg_s, sd.hip_deg_s}, {fit.signals.knee_deg_s, sd.knee_deg_s}, hip_speed_}};
    const auto fill = [&](ValuesOfFrames& course) {  // empty where not known
      course.value.resize(time_s_.size(), NAN);
      course.sd.resize(time_s_.size(), NAN);
    };
    fill(on_pelvis_);
    std::ranges::for_each(steadied_, fill);
  }

  std::vector<SitToStand> Measure() const {
    std::map<int, std::map<motion::StsEventKind, Measured>> times;
    for (const motion::StsEvent& event : fit_.events) times[event.repetition][event.kind] = {event.time_s, event.sd_s};
    std::vector<SitToStand> rises;
    for (auto& [repetition, time] : times) {
      rises.push_back(MeasureRise(time));
      rises.back().repetition = repetition;
      TakeCentreOfMass(rises.back());
    }
    return rises;
  }

 private:
  SitToStand MeasureRise(std::map<motion::StsEventKind, Measured>& time) const {
    SitToStand rise;
    rise.onset_s = time[motion::StsEventKind::kOnset];
    rise.seat_off_s = time[motion::StsEventKind::kSeatOff];
    rise.standing_s = time[motion::StsEventKind::kStanding];
    rise.rise_s = Difference(rise.standing_s, rise.onset_s);
    rise.descent_s = Difference(time[motion::StsEventKind::kSeated], time[motion::StsEventKind::kDescent]);
    const Measured leaned_s = LargestLean(rise.seat_off_s, rise.standing_s);
    rise.flexion_s = Difference(rise.seat_off_s, rise.onset_s);
    rise.transfer_s = Difference(leaned_s, rise.seat_off_s);
    rise.extension_s = Difference(rise.standing_s, leaned_s);
    rise.stabilisation_s = Stabilisation(rise, time[motion::StsEventKind::kDescent].value);
    MeasureAngles(rise);
    rise.hip_rise = Difference(At(height_, rise.standing_s), At(height_, rise.onset_s));
    rise.hip_speed = Ratio(rise.hip_rise, Difference(rise.standing_s, rise.seat_off_s));
    rise.hip_speed_max = Largest(hip_speed_, rise);
    if (fit_.motion.unit == motion::LengthUnit::kMm)
      rise.power_w_kg = Times(kLiftedMass * kGravity_m_s2 / 1000, Ratio(rise.hip_rise, rise.rise_s));
    return rise;
  }

  void TakeCentreOfMass(SitToStand& rise) const {
    const auto centre = centres_.find(rise.repetition);
    if (centre == centres_.end()) return;
    rise.com_seat_off_mm = centre->second.seat_off_mm;
    rise.com_forward_max_mm_s = centre->second.forward_max_mm_s;
    rise.com_upward_max_mm_s = centre->second.upward_max_mm_s;
  }

  void MeasureAngles(SitToStand& rise) const {
    rise.knee_seat_off_deg = At(knee_, rise.seat_off_s);
    rise.knee_max_deg = Largest(knee_, rise);
    rise.hip_seat_off_deg = At(hip_, rise.seat_off_s);
    rise.hip_max_deg = Largest(hip_, rise);
    rise.trunk_seat_off_deg = At(trunk_, rise.seat_off_s);
    rise.trunk_max_deg = Largest(trunk_, rise);
    rise.trunk_pelvis_seat_off_deg = At(on_pelvis_, rise.seat_off_s);
    rise.trunk_pelvis_max_deg = Largest(on_pelvis_, rise);
    rise.knee_extension_max_deg_s = Largest(extension_speed_, rise);
    rise.trunk_flexion_max_deg_s = Largest(trunk_speed_, rise);
  }

  // The value at an event, between two frames; its SD, that of the event's time included.
  Measured At(const ValuesOfFrames& course, const Measured& time) const {
    const auto after = std::lower_bound(time_s_.begin(), time_s_.end(), time.value);
    if (std::isnan(time.value) || after == time_s_.end()) return {};
    const auto i = static_cast<std::size_t>(after - time_s_.begin()), before = i == 0 ? 0 : i - 1;
    const std::size_t next = i == 0 ? 1 : i;
    const double step_s = time_s_[next] - time_s_[before], slope = (course.value[next] - course.value[before]) / step_s;
    return {course.value[before] + slope * (time.value - time_s_[before]),
            std::hypot(course.sd[next], slope * time.sd)};
  }

  // The frame of the largest value from one time to another; nullopt if one of them, or every value, is unknown.
  std::optional<std::size_t> FrameOfLargest(const ValuesOfFrames& course, double from_s, double to_s) const {
    std::optional<std::size_t> largest;
    for (std::size_t i = 0; i < time_s_.size(); ++i)
      if (time_s_[i] >= from_s && time_s_[i] <= to_s && std::isfinite(course.value[i]) &&
          (!largest || course.value[i] > course.value[*largest]))
        largest = i;
    return largest;
  }

  Measured Largest(const ValuesOfFrames& course, const SitToStand& rise) const {
    const auto i = FrameOfLargest(course, rise.onset_s.value, rise.standing_s.value);
    return i ? Measured{course.value[*i], course.sd[*i]} : Measured{};
  }

  // When the shank leans forward most: where its speed crosses zero beside the frame of the largest lean. At seat-off
  // if it only goes back from there, at standing if it leans until then.
  Measured LargestLean(const Measured& seat_off, const Measured& standing) const {
    const auto largest = FrameOfLargest(shank_, seat_off.value, standing.value);
    if (!largest) return {};
    const std::vector<double>& speed = fit_.signals.shank_deg_s;
    std::size_t before = *largest;  // the last frame in which it still leans forward
    while (before > 0 && !(speed[before] > 0)) --before;
    while (before + 1 < time_s_.size() && speed[before + 1] > 0) ++before;
    if (time_s_[before] < seat_off.value) return seat_off;
    if (before + 1 == time_s_.size() || time_s_[before + 1] > standing.value) return standing;
    const double step_s = time_s_[before + 1] - time_s_[before], slope = (speed[before] - speed[before + 1]) / step_s;
    return {time_s_[before] + speed[before] / slope, fit_.signals.sd.shank_deg_s[before] / slope};
  }

  double PeakOf(const ValuesOfFrames& speed, const SitToStand& rise) const {
    double peak = NAN;
    for (std::size_t i = 0; i < time_s_.size(); ++i)
      if (time_s_[i] >= rise.onset_s.value && time_s_[i] <= rise.standing_s.value)
        peak = std::fmax(peak, std::abs(speed.value[i]));
    return peak;
  }

  // From standing to the last time at which a speed comes below its limit before all stay there.
  Measured Stabilisation(const SitToStand& rise, double descent_s) const {
    std::array<double, kSteadied> limit{};
    for (std::size_t k = 0; k < kSteadied; ++k) limit[k] = kSteadyFraction * PeakOf(steadied_[k], rise);
    const double until_s = std::isnan(descent_s) ? time_s_.back() : descent_s;
    Measured steady{rise.standing_s.value, 0};
    const auto next = std::upper_bound(time_s_.begin(), time_s_.end(), steady.value);
    for (auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, next - time_s_.begin()) - 1);
         i < time_s_.size() && time_s_[i] <= std::min(until_s, steady.value + kSteady_s); ++i)
      for (std::size_t k = 0; k < kSteadied; ++k) {
        const Measured slow = ComesBelow(steadied_[k], limit[k], i);
        if (std::isnan(slow.value)) return {};
        if (slow.value > steady.value) steady = slow;
      }
    if (!(steady.value + kSteady_s <= until_s)) return {};
    return {steady.value - rise.standing_s.value, std::hypot(steady.sd, rise.standing_s.sd)};
  }

  // When a speed comes below its limit after frame i, or the next frame if it stays above; −∞ if it is below there, NaN
  // where it is not known well enough.
  Measured ComesBelow(const ValuesOfFrames& speed, double limit, std::size_t i) const {
    const double size = std::abs(speed.value[i]);
    if (!std::isfinite(size) || !(speed.sd[i] <= limit / 2)) return {};
    if (size <= limit) return {-INFINITY, 0};
    if (i + 1 == time_s_.size()) return {};
    const double after = std::abs(speed.value[i + 1]), step_s = time_s_[i + 1] - time_s_[i];
    if (!(after <= limit)) return {time_s_[i + 1], 0};
    const double slope = (size - after) / step_s;
    return {time_s_[i] + (size - limit) / slope, speed.sd[i] / slope};
  }

  const LegFitResult& fit_;
  const std::vector<double>& time_s_;
  const CentresOfMass& centres_;
  ValuesOfFrames knee_, hip_, trunk_, on_pelvis_, shank_, height_, hip_speed_, trunk_speed_, extension_speed_;
  std::array<ValuesOfFrames, kSteadied> steadied_;  // the speeds of which the person becomes steady
};

SitToStand FiveTimes(const std::vector<SitToStand>& rises, bool in_mm) {
  std::vector<SitToStand> five;
  for (const SitToStand& rise : rises)
    if (five.size() < kFive && std::isfinite(rise.rise_s.value)) five.push_back(rise);
  SitToStand test;
  if (five.size() < kFive) return test;
  for (const Field<SitToStand>& field : kRiseFields) {
    std::vector<double> values;
    for (const SitToStand& rise : five)
      if (const double value = (rise.*field.value).value; std::isfinite(value)) values.push_back(value);
    if (values.size() == kFive) test.*field.value = {Mean(values), StandardDeviation(values)};
  }
  test.onset_s = five.front().onset_s;
  test.standing_s = five.back().standing_s;
  test.seat_off_s = {};
  test.five_times_s = Difference(test.standing_s, test.onset_s);
  if (in_mm)
    test.power_w_kg =
        Times(kLiftedMass * kGravity_m_s2 / 1000, Ratio(test.hip_rise, Times(1.0 / kHalfCycles, test.five_times_s)));
  return test;
}

// In the leg frame's axes: from the pelvis' back to its front, and what both are uncertain by on each axis.
struct PelvisLine {
  Eigen::Vector2d forward;
  double sd = kNaN;
};

PelvisLine LineOf(const LegFitResult& fit, const motion::MarkerSample& asis, const motion::MarkerSample& psis) {
  return {.forward = LegFromPlane(asis.position - psis.position, fit.motion.facing, fit.up),
          .sd = std::hypot(asis.sigma, psis.sigma)};
}

// Why no lean can be measured by these markers; empty if one can. `lines` are those of the frames that show both,
// `waist` how far the waist marker is from the middle between them there.
std::string WhyUnknown(const std::vector<PelvisLine>& lines, const std::vector<double>& waist) {
  if (lines.empty()) return fmt::format("the markers '{}' and '{}' are never seen together", kAsis, kPsis);
  const auto backward = std::ranges::count_if(lines, [](const PelvisLine& line) { return line.forward.x() < 0; });
  if (2 * backward > std::ssize(lines))
    return fmt::format("the marker '{}' is behind '{}': exchange their names, or say where the subject faces", kAsis,
                       kPsis);
  std::vector<double> lengths;
  lengths.reserve(lines.size());
  for (const PelvisLine& line : lines) lengths.push_back(line.forward.norm());
  if (!waist.empty() && Median(waist) < Median(lengths))
    return fmt::format(
        "the waist marker is on the pelvis itself, no farther from '{}' and '{}' than they are apart: give one on the "
        "trunk above, as on the shoulder",
        kAsis, kPsis);
  return "";
}

}  // namespace

TrunkOnPelvis FindTrunkOnPelvis(const LegFitResult& fit) {
  const std::size_t frames = fit.motion.samples.size();
  TrunkOnPelvis lean{std::vector<double>(frames, kNaN), std::vector<double>(frames, kNaN), ""};
  const motion::MarkerTrack *asis = fit.trajectory.Find(kAsis), *psis = fit.trajectory.Find(kPsis);
  const motion::MarkerTrack* waist = fit.trajectory.Find(fit.leg_markers.waist);
  if (!asis && !psis) return lean;
  if (!asis || !psis) {
    lean.warning = fmt::format("no lean to the pelvis: there is a marker '{}' and none called '{}'",
                               asis ? kAsis : kPsis, asis ? kPsis : kAsis);
    return lean;
  }
  std::vector<PelvisLine> lines;
  std::vector<double> from_waist;
  for (std::size_t i = 0; i < frames; ++i) {
    const motion::MarkerSample &front = asis->samples[i], &back = psis->samples[i];
    if (!front.IsKnown() || !back.IsKnown()) continue;
    const PelvisLine& line = lines.emplace_back(LineOf(fit, front, back));
    if (waist && waist->samples[i].IsKnown())
      from_waist.push_back((waist->samples[i].position - (front.position + back.position) / 2).norm());
    const double tilt_deg = DegreesFromRadians(std::atan2(-line.forward.y(), line.forward.x())),
                 tilt_sd_deg = DegreesFromRadians(line.sd / line.forward.norm());
    lean.deg[i] = fit.motion.samples[i].trunk_deg - tilt_deg;
    lean.sd_deg[i] = std::hypot(fit.signals.sd.trunk_deg.empty() ? kNaN : fit.signals.sd.trunk_deg[i], tilt_sd_deg);
  }
  if (const std::string why = WhyUnknown(lines, from_waist); !why.empty()) {
    std::ranges::fill(lean.deg, kNaN);
    std::ranges::fill(lean.sd_deg, kNaN);
    lean.warning = "no lean to the pelvis: " + why;
  }
  return lean;
}

std::span<const Field<SitToStand>> SitToStand::Fields() {
  return kRiseFields;
}

std::vector<SitToStand> MeasureSitToStands(const LegFitResult& fit) {
  return MeasureSitToStands(fit, FindTrunkOnPelvis(fit));
}

std::vector<SitToStand> MeasureSitToStands(const LegFitResult& fit, TrunkOnPelvis on_pelvis,
                                           const CentresOfMass& centres) {
  std::vector<SitToStand> rows = Rises(fit, std::move(on_pelvis), centres).Measure();
  rows.push_back(FiveTimes(rows, fit.motion.unit == motion::LengthUnit::kMm));
  return rows;
}

std::optional<double> FiveTimesReference_s(double age_years) {
  struct Reference {
    double from_years, upper_s;
  };
  constexpr double kDecade_years = 10;
  for (const Reference& reference : {Reference{60, 11.4}, {70, 12.6}, {80, 14.8}})
    if (age_years >= reference.from_years && age_years < reference.from_years + kDecade_years) return reference.upper_s;
  return std::nullopt;
}

std::optional<double> LowPowerWKg(motion::Sex sex, std::optional<double> age_years) {
  if (age_years && *age_years < kOlder_years) return std::nullopt;
  return sex == motion::Sex::kMale ? 2.5 : 1.9;
}

Json FiveTimesJson(const SitToStand& five_times, const Person& person) {
  const Measured &time_s = five_times.five_times_s, &power = five_times.power_w_kg;
  if (std::isnan(time_s.value)) return nullptr;
  Json json = {
      {"five_times_s", time_s.value}, {"sd_s", time_s.sd}, {"ends", "fifth standing"}, {"half_cycles", kHalfCycles}};
  if (person.age_years) {
    const std::optional<double> reference_s = FiveTimesReference_s(*person.age_years);
    json["age_years"] = *person.age_years;
    json["reference_s"] = ValueOrNull(reference_s);
    json["source"] = kBohannon;
    if (reference_s) json["worse_than_average"] = time_s.value > *reference_s;
  }
  if (person.sex) json["sex"] = *person.sex == motion::Sex::kMale ? "male" : "female";
  if (std::isnan(power.value)) return json;
  json["power_w_kg"] = power.value;
  json["power_sd_w_kg"] = power.sd;
  if (!person.sex) return json;
  const std::optional<double> low = LowPowerWKg(*person.sex, person.age_years);
  json["low_power_below_w_kg"] = ValueOrNull(low);
  json["power_source"] = "Baltasar-Fernandez et al. 2021, doi:10.1038/s41598-021-98871-3";
  if (low) json["low_power"] = power.value < *low;
  return json;
}

void Describe(Person& o, OptionList& options) {
  constexpr double kOldest_years = 120;
  options.Add("age", o.age_years, "How old the subject is: the five-times test is compared with people of that age")
      .Unit("years")
      .Between(0, kOldest_years)
      .Otherwise("not compared");
  options
      .AddChoice("sex", o.sex,
                 OptionList::Choices<motion::Sex>{{"male", motion::Sex::kMale}, {"female", motion::Sex::kFemale}},
                 "The subject's sex: the five-times test's power is compared with that of older women or men")
      .Otherwise("not compared");
}

void WriteSitToStandCsv(const std::filesystem::path& path, const std::vector<SitToStand>& rows,
                        motion::LengthUnit of_plane) {
  auto fields = kRiseFields;  // in the order of the columns: the fourth phase stands before the pelvis' angles
  const auto phase = std::ranges::find(fields, &SitToStand::stabilisation_s, &Field<SitToStand>::value),
             pelvis = std::ranges::find(fields, &SitToStand::trunk_pelvis_seat_off_deg, &Field<SitToStand>::value);
  std::rotate(phase, phase + 1, pelvis);
  std::vector<std::pair<std::string, SitToStand>> named;
  named.reserve(rows.size());
  for (const SitToStand& row : rows)
    named.emplace_back(row.repetition > 0 ? std::to_string(row.repetition) : "five_times", row);
  WriteRows<SitToStand>(path, "repetition", fields, named, of_plane);
}

void ReadEventDeviations(const std::filesystem::path& path, std::vector<motion::StsEvent>& events) {
  using enum motion::StsEventKind;
  constexpr double kSame_s = 1e-6;
  const CsvTable table = CsvTable::Read(path);
  for (motion::StsEvent& event : events) {
    const char* name = event.kind == kOnset      ? "onset_s"
                       : event.kind == kSeatOff  ? "seat_off_s"
                       : event.kind == kStanding ? "standing_s"
                                                 : nullptr;
    if (!name) continue;
    const std::size_t time = table.Column(name), sd = table.Column(fmt::format("{}_sd", name));
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      const std::optional<double> at_s = table.Number(row, time);
      const bool same = table.Text(row, table.Column("repetition")) == fmt::format("{}", event.repetition);
      if (same && at_s && std::abs(*at_s - event.time_s) < kSame_s) event.sd_s = table.Number(row, sd).value_or(NAN);
    }
  }
}

}  // namespace lake::gait
