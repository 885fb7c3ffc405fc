#include "lake/gait/sit_to_stand.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/json_or_null.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

constexpr std::size_t kFive = 5;
constexpr int kHalfCycles = 2 * kFive - 1;  // to the fifth standing: five rises and four lowerings
constexpr std::size_t kSteadied = 3;
constexpr double kLiftedMass = 0.9, kGravity_m_s2 = 9.81;

using Quantity = SitToStandQuantity;
constexpr std::array kQuantities = {
    Quantity{"onset_s", &SitToStand::onset_s, "onset", "s", false, true},
    Quantity{"seat_off_s", &SitToStand::seat_off_s, "seat-off", "s", false, true},
    Quantity{"standing_s", &SitToStand::standing_s, "standing", "s", false, true},
    Quantity{"rise_s", &SitToStand::rise_s, "rise time", "s"},
    Quantity{"flexion_s", &SitToStand::flexion_s, "flexion momentum: onset to seat-off", "s"},
    Quantity{"transfer_s", &SitToStand::transfer_s, "momentum transfer: seat-off to largest ankle dorsiflexion", "s"},
    Quantity{"extension_s", &SitToStand::extension_s, "extension: from there to standing", "s"},
    Quantity{"stabilisation_s", &SitToStand::stabilisation_s, "stabilisation: from standing until steady", "s"},
    Quantity{"descent_s", &SitToStand::descent_s, "time to sit down", "s"},
    Quantity{"knee_seat_off_deg", &SitToStand::knee_seat_off_deg, "knee angle at seat-off", "°"},
    Quantity{"hip_seat_off_deg", &SitToStand::hip_seat_off_deg, "hip angle at seat-off", "°"},
    Quantity{"trunk_seat_off_deg", &SitToStand::trunk_seat_off_deg, "trunk lean at seat-off", "°"},
    Quantity{"knee_max_deg", &SitToStand::knee_max_deg, "largest knee angle", "°"},
    Quantity{"hip_max_deg", &SitToStand::hip_max_deg, "largest hip angle", "°"},
    Quantity{"trunk_max_deg", &SitToStand::trunk_max_deg, "largest trunk lean", "°"},
    Quantity{"knee_extension_max_deg_s", &SitToStand::knee_extension_max_deg_s, "fastest knee extension", "°/s"},
    Quantity{"trunk_flexion_max_deg_s", &SitToStand::trunk_flexion_max_deg_s, "fastest trunk flexion", "°/s"},
    Quantity{"hip_rise", &SitToStand::hip_rise, "rise of the hip", "", true},
    Quantity{"hip_speed", &SitToStand::hip_speed, "mean speed of the hip, seat-off to standing", "/s", true},
    Quantity{"hip_speed_max", &SitToStand::hip_speed_max, "largest speed of the hip", "/s", true},
    Quantity{"power_w_kg", &SitToStand::power_w_kg, "mean power over body mass", "W/kg"},
    Quantity{"five_times_s", &SitToStand::five_times_s, "five-times sit-to-stand", "s"},
    Quantity{"trunk_pelvis_seat_off_deg", &SitToStand::trunk_pelvis_seat_off_deg,
             "trunk lean to the pelvis at seat-off", "°"},
    Quantity{"trunk_pelvis_max_deg", &SitToStand::trunk_pelvis_max_deg, "largest trunk lean to the pelvis", "°"},
    Quantity{"com_seat_off_mm", &SitToStand::com_seat_off_mm, "centre of mass before the ankle at seat-off", "mm"},
    Quantity{"com_forward_max_mm_s", &SitToStand::com_forward_max_mm_s, "largest speed forward of the centre of mass",
             "mm/s"},
    Quantity{"com_upward_max_mm_s", &SitToStand::com_upward_max_mm_s, "largest speed upward of the centre of mass",
             "mm/s"}};

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
  for (const Quantity& quantity : kQuantities) {
    std::vector<double> values;
    for (const SitToStand& rise : five)
      if (const double value = (rise.*quantity.value).value; std::isfinite(value)) values.push_back(value);
    if (values.size() == kFive) test.*quantity.value = {Mean(values), StandardDeviation(values)};
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

}  // namespace

std::string SitToStandQuantity::Unit(motion::LengthUnit of_plane) const {
  return is_length ? fmt::format("{}{}", ToString(of_plane), unit) : unit;
}

std::string SitToStandQuantity::Column(motion::LengthUnit of_plane) const {
  if (!is_length) return name;
  return fmt::format("{}_{}{}", name, ToString(of_plane), *unit ? "_s" : "");
}

std::span<const SitToStandQuantity> SitToStandQuantities() {
  return kQuantities;
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
    json["source"] = "Bohannon 2006, doi:10.2466/pms.103.1.215-222";
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
  auto quantities = kQuantities;  // in the order of the columns: the fourth phase stands before the pelvis' angles
  const auto phase = std::ranges::find(quantities, &SitToStand::stabilisation_s, &Quantity::value),
             pelvis = std::ranges::find(quantities, &SitToStand::trunk_pelvis_seat_off_deg, &Quantity::value);
  std::rotate(phase, phase + 1, pelvis);
  std::vector<std::string> header = {"repetition"};
  for (const char* sd : {"", "_sd"})
    for (const Quantity& quantity : quantities) header.push_back(quantity.Column(of_plane) + sd);
  CsvWriter csv(header);
  for (const SitToStand& row : rows) {
    csv.Add(row.repetition > 0 ? std::to_string(row.repetition) : "five_times");
    for (const Quantity& quantity : quantities) csv.Add((row.*quantity.value).value);
    for (const Quantity& quantity : quantities) csv.Add((row.*quantity.value).sd);
    csv.EndRow();
  }
  csv.Write(path);
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
