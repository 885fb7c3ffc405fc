#include "lake/commands/loads.h"

#include <fmt/format.h>

#include <cmath>

#include "force_plates.h"
#include "lake/commands/gait.h"
#include "lake/core/counted.h"
#include "lake/core/cross.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/ground_forces.h"
#include "lake/figure/design_figures.h"
#include "lake/sync/clock.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d, Eigen::Vector3d;

// As given, else as the names of the leg's markers say, else as the only named plate does; where nothing says it, the
// right one, with a warning.
std::string LegOf(const LoadsRunOptions& options, const exchange::Trial& trial, Run& run) {
  if (!options.leg.empty()) return options.leg;
  if (trial.leg) return std::string(ToString(*trial.leg));
  const auto ankle = options.reading.names.find("ankle");
  if (ankle != options.reading.names.end())
    if (const auto side = motion::SideOfName(ankle->second)) return std::string(ToString(*side));
  if (options.plates.size() == 1) return options.plates.begin()->first;
  run.Warn(
      "no marker's name says which leg this is: it is taken for the right one, and its force plate with it; say it "
      "with --leg");
  return "right";
}

// A plate that bears the foot, and when.
struct BearingPlate {
  const exchange::PlateForces* plate;
  double from_s = -std::numeric_limits<double>::infinity(), to_s = -from_s;
};

// The leg's contacts that begin and end in the recording, and their plates.
std::pair<std::vector<loads::Stance>, std::vector<BearingPlate>> StancesOf(
    const gait::LegFitResult& fit, const std::vector<gait::PlateContact>& contacts,
    const exchange::GroundForceRecording& file) {
  std::vector<loads::Stance> stances;
  std::vector<BearingPlate> bearing;
  constexpr double kEdge_s = 0.05;  // the force below the contact's limit
  const auto find = [&](motion::StsEventKind kind, double time_s) {
    return std::ranges::find_if(
        fit.events, [&](const motion::StsEvent& event) { return event.kind == kind && event.time_s == time_s; });
  };
  for (const gait::PlateContact& contact : contacts) {
    const auto strike = find(motion::StsEventKind::kHeelStrike, contact.begin_s);
    if (strike == fit.events.end() || find(motion::StsEventKind::kToeOff, contact.end_s) == fit.events.end()) continue;
    stances.push_back({strike->repetition, contact.begin_s, contact.end_s});
    bearing.push_back({&*std::ranges::find(file.plates, contact.plate, &exchange::PlateForces::name),
                       contact.begin_s - kEdge_s, contact.end_s + kEdge_s});
  }
  return {stances, bearing};
}

loads::GroundForces InLeg(const LoadsRunOptions& options, const exchange::GroundForceRecording& file,
                          const std::vector<BearingPlate>& bearing, const exchange::Trial& trial,
                          const gait::LegFitResult& fit) {
  const Eigen::Matrix3d& plane_from_space = *trial.plane_from_space;
  const motion::Facing facing = fit.motion.facing;
  const double side = facing == motion::Facing::kRight ? 1 : -1;  // the leg's x is the plane's, or its opposite
  const auto in_leg = [&](const Vector3d& v) {
    return gait::LegFromPlane((plane_from_space * v).head<2>(), facing, fit.up);
  };
  loads::GroundForces forces;
  forces.time_s = file.time_s;
  if (options.sync) {
    const sync::Clock clock = sync::ReadClockOf(*options.sync, options.forces);
    for (double& time_s : forces.time_s) time_s = clock.FromB(time_s);
  }
  for (std::size_t i = 0; i < file.time_s.size(); ++i) {
    loads::Wrench& wrench = forces.wrench.emplace_back();
    for (const auto& [plate, from_s, to_s] : bearing) {
      if (forces.time_s[i] < from_s || forces.time_s[i] > to_s) continue;
      const Vector2d force_n = in_leg(plate->force_n[i]);
      wrench.force_n += force_n;
      wrench.moment_nm +=
          Cross(in_leg(plate->point_m[i]), force_n) + side * plane_from_space.row(2).dot(plate->moment_nm[i]);
    }
  }
  return forces;
}

loads::GroundForces ReadForces(const LoadsRunOptions& options, const exchange::Trial& trial,
                               const gait::LegFitResult& fit, Run& run) {
  const exchange::GroundForceRecording file = exchange::ReadGroundForces(options.forces);
  VerticalOf(file, trial, options.forces);  // both have one
  const std::string leg = LegOf(options, trial, run);
  const exchange::PlateForces& plate = exchange::PlateOf(file, options.plates, leg, options.forces);
  WarnOfSwappedPlates(file, plate, leg, trial, options.reading, "Name them with --plates, the leg with --leg", run);
  return InLeg(options, file, {{&plate}}, trial, fit);
}

// The columns of loads.csv behind the percent, and of loads.json.
struct LoadsColumn {
  const char* name;
  double loads::LoadsRow::*value;
  bool is_of_profile = true;  // in loads.json, too
};
constexpr LoadsColumn kLoadsColumns[] = {{"time_s", &loads::LoadsRow::time_s},
                                         {"knee_deg", &loads::LoadsRow::knee_deg},
                                         {"knee_deg_s", &loads::LoadsRow::knee_deg_s},
                                         {"ankle_nm", &loads::LoadsRow::ankle_nm},
                                         {"knee_nm", &loads::LoadsRow::knee_nm},
                                         {"hip_nm", &loads::LoadsRow::hip_nm},
                                         {"knee_sd_nm", &loads::LoadsRow::knee_sd_nm},
                                         {"knee_low_nm", &loads::LoadsRow::knee_low_nm},
                                         {"knee_high_nm", &loads::LoadsRow::knee_high_nm},
                                         {"zmp_mm", &loads::LoadsRow::zmp_mm, false},
                                         {"ground_force_n", &loads::LoadsRow::ground_force_n, false},
                                         {"knee_power_w", &loads::LoadsRow::knee_power_w}};

void WriteTable(const fs::path& path, const loads::LoadsResult& result) {
  std::vector<std::string> header = {"repetition", "percent"};
  for (const LoadsColumn& column : kLoadsColumns) header.emplace_back(column.name);
  CsvWriter csv(header);
  const auto add = [&](const loads::RiseLoads& rise, const std::string& name) {
    for (std::size_t percent = 0; percent < rise.rows.size(); ++percent) {
      csv.Add(name).Add(percent);
      for (const LoadsColumn& column : kLoadsColumns) csv.Add(rise.rows[percent].*column.value);
      csv.EndRow();
    }
  };
  for (const loads::RiseLoads& rise : result.rises) add(rise, std::to_string(rise.repetition));
  add(result.mean, "mean");
  csv.Write(path);
}

// The whole body's centre of mass over each rise, and its momentum.
void WriteCentres(const fs::path& path, const loads::LoadsResult& result, double mass_kg) {
  CsvWriter csv({"repetition", "percent", "time_s", "com_x_mm", "com_y_mm", "com_forward_mm_s", "com_upward_mm_s",
                 "com_forward_ns", "com_upward_ns"});
  for (const loads::RiseLoads& rise : result.rises)
    for (std::size_t percent = 0; percent < rise.rows.size(); ++percent) {
      const loads::CentreOfMass& centre = rise.momentum.rows[percent];
      csv.Add(rise.repetition).Add(percent).Add(rise.rows[percent].time_s);
      for (const Vector2d& of : {Vector2d(kMmPerM * centre.position_m), Vector2d(kMmPerM * centre.velocity_m_s),
                                 Vector2d(mass_kg * centre.velocity_m_s)})
        csv.Add(of.x()).Add(of.y());
      csv.EndRow();
    }
  csv.Write(path);
}

// One row a rise: what carries the body off the seat.
void WriteMomenta(const fs::path& path, const loads::LoadsResult& result, double mass_kg) {
  CsvWriter csv({"repetition", "com_seat_off_mm", "com_seat_off_mm_sd", "com_forward_seat_off_mm_s",
                 "com_forward_seat_off_mm_s_sd", "com_forward_max_mm_s", "com_forward_max_mm_s_sd",
                 "com_forward_lead_s", "com_upward_max_mm_s", "com_upward_max_mm_s_sd", "com_forward_max_ns",
                 "com_upward_max_ns"});
  for (const loads::RiseLoads& rise : result.rises) {
    const loads::RiseMomentum& of = rise.momentum;
    const loads::MomentumSd& sd = rise.momentum_sd;
    csv.AddRow(rise.repetition, kMmPerM * of.seat_off_m, kMmPerM * sd.seat_off_m, kMmPerM * of.forward_seat_off_m_s,
               kMmPerM * sd.forward_seat_off_m_s, kMmPerM * of.forward_max_m_s, kMmPerM * sd.forward_max_m_s,
               of.forward_lead_s, kMmPerM * of.upward_max_m_s, kMmPerM * sd.upward_max_m_s,
               mass_kg * of.forward_max_m_s, mass_kg * of.upward_max_m_s);
  }
  csv.Write(path);
}

// The same path at the person's own pace, as slowly as may be, and in the time that was asked for.
void WritePaces(const fs::path& path, const loads::Balance& balance) {
  CsvWriter csv({"pace", "rise_s", "percent", "time_s", "knee_nm", "zmp_mm", "margin_mm"});
  const auto add = [&](const char* name, const loads::PaceLoads& pace) {
    for (const loads::PaceRow& row : pace.rows)
      csv.AddRow(name, pace.rise_s, row.percent, row.time_s, row.knee_nm, row.zmp_mm, row.margin_mm);
  };
  add("own", balance.own);
  add("slow", balance.slow);
  if (balance.asked) add("asked", *balance.asked);
  csv.Write(path);
}

Json PaceJson(const loads::PaceLoads& pace) {
  double peak_nm = loads::LoadsRow::kUnknown;
  for (const loads::PaceRow& row : pace.rows) peak_nm = std::fmax(peak_nm, row.knee_nm);
  return {{"rise_s", pace.rise_s},
          {"margin_mm", pace.margin_mm},
          {"at_percent", pace.at_percent},
          {"peak_knee_nm", peak_nm}};
}

Json BalanceJson(const loads::LoadsResult& result) {
  const loads::Balance& balance = result.balance;
  Json json = {
      {"own", PaceJson(balance.own)}, {"slow", PaceJson(balance.slow)}, {"slowest_s", ValueOrNull(balance.slowest_s)}};
  if (!result.from_ground)
    json["slow"]["margin_interval_mm"] = {balance.slow_margin_low_mm, balance.slow_margin_high_mm};
  if (balance.asked) json["asked"] = PaceJson(*balance.asked);
  return json;
}

Json ColumnsOf(const loads::RiseLoads& rise) {
  Json columns;
  for (const LoadsColumn& column : kLoadsColumns)
    if (column.is_of_profile)
      for (const loads::LoadsRow& row : rise.rows) columns[column.name].push_back(row.*column.value);
  return columns;
}

Json PeakJson(const loads::RiseLoads& rise, double mass_kg) {
  return {{"knee_nm", rise.peak.knee_nm},
          {"knee_nm_interval", {rise.peak.low_nm, rise.peak.high_nm}},
          {"knee_nm_kg", rise.peak.knee_nm / mass_kg},
          {"knee_deg", rise.peak.knee_deg},
          {"percent", rise.peak.percent}};
}

const char* Method(const loads::LoadsResult& result) {
  return result.from_ground ? "bottom-up" : "top-down";
}

// The mean knee's moment on the same path gone along as slowly as may be, at each percent; null while the seat bears a
// part. What accelerations add to it falls with the square of the time that a rise takes.
Json SlowMoments(const loads::Balance& balance) {
  std::vector<double> moments(loads::kPercents, loads::LoadsRow::kUnknown);
  for (const loads::PaceRow& row : balance.slow.rows) moments[static_cast<std::size_t>(row.percent)] = row.knee_nm;
  return moments;
}

// What a design needs: one leg's profile over the rise.
Json ProfileJson(const loads::LoadsResult& result, const LoadsRunOptions& options) {
  Json profile;
  profile["method"] = Method(result);
  profile["mass_kg"] = options.loads.body.mass_kg;
  profile["share"] = options.loads.body.share;
  Json& percents = profile["percent"] = Json::array();
  for (int percent = 0; percent < loads::kPercents; ++percent) percents.push_back(percent);
  profile.update(ColumnsOf(result.mean));
  profile["knee_slow_nm"] = SlowMoments(result.balance);
  profile["body_path"] = loads::BodyPathJson(result.body_path);
  profile["peak"] = PeakJson(result.mean, options.loads.body.mass_kg);
  Json& rises = profile["rises"] = Json::array();
  for (const loads::RiseLoads& rise : result.rises) {
    Json one = {{"repetition", rise.repetition}};
    one.update(ColumnsOf(rise));
    one["peak"] = PeakJson(rise, options.loads.body.mass_kg);
    rises.push_back(std::move(one));
  }
  return profile;
}

Json BodyJson(const loads::LegBody& body) {
  const auto segment = [](const loads::SegmentInertia& s) {
    return Json{{"mass_kg", s.mass_kg},
                {"centre_mm", kMmPerM * s.centre_m},
                {"inertia_kg_m2", s.mass_kg * s.gyration_m * s.gyration_m}};
  };
  return {{"table", body.table},
          {"source", body.source},
          {"height_mm", kMmPerM * body.height_m},
          {"foot_mm", {kMmPerM * body.sole.heel_m, kMmPerM * body.sole.toe_m}},
          {"foot", segment(body.foot)},
          {"shank", segment(body.shank)},
          {"thigh", segment(body.thigh)},
          {"trunk", segment(body.trunk)}};
}

// Means over the rises; of the momentum, over those of which it is known.
struct MeanRise {
  loads::Peak peak;  // low and high: the share of the peaks that the mean curve's draws leave open
  double knee_energy_j = 0;
  loads::RiseMomentum momentum;
};

double MeanMomentum(const loads::LoadsResult& result, double loads::RiseMomentum::*member) {
  std::vector<double> values;
  for (const loads::RiseLoads& rise : result.rises)
    if (std::isfinite(rise.momentum.*member)) values.push_back(rise.momentum.*member);
  return Mean(values);
}

MeanRise MeanOf(const loads::LoadsResult& result) {
  std::vector<double> peaks, low, high, angles, energies;
  for (const loads::RiseLoads& rise : result.rises) {
    if (!std::isfinite(rise.peak.knee_nm)) continue;
    peaks.push_back(rise.peak.knee_nm);
    low.push_back(rise.peak.low_nm);
    high.push_back(rise.peak.high_nm);
    angles.push_back(rise.peak.knee_deg);
    energies.push_back(rise.knee_energy_j);
  }
  MeanRise mean{.peak = {.knee_nm = Mean(peaks), .low_nm = Mean(low), .high_nm = Mean(high), .knee_deg = Mean(angles)},
                .knee_energy_j = Mean(energies),
                .momentum = {}};
  for (double loads::RiseMomentum::*member :
       {&loads::RiseMomentum::seat_off_m, &loads::RiseMomentum::forward_max_m_s, &loads::RiseMomentum::upward_max_m_s,
        &loads::RiseMomentum::forward_lead_s})
    mean.momentum.*member = MeanMomentum(result, member);
  return mean;
}

Json MomentumJson(const loads::RiseMomentum& mean, double mass_kg) {
  return {
      {"com_seat_off_mm", kMmPerM * mean.seat_off_m},         {"com_forward_max_mm_s", kMmPerM * mean.forward_max_m_s},
      {"com_upward_max_mm_s", kMmPerM * mean.upward_max_m_s}, {"com_forward_max_ns", mass_kg * mean.forward_max_m_s},
      {"com_upward_max_ns", mass_kg * mean.upward_max_m_s},   {"com_forward_lead_s", mean.forward_lead_s}};
}

// Each stance and the mean of all, over 0 to 100 % of it.
Json RunStances(const LoadsRunOptions& options, const exchange::Trial& trial, const gait::LegFitResult& fit,
                const loads::LegPathOptions& path, Run& run) {
  if (options.forces.empty())
    throw Fail("{}: a walk's moments are worked out from the ground's forces: give --forces", trial.file.string());
  const exchange::GroundForceRecording file = exchange::ReadGroundForces(options.forces);
  const auto [stances, bearing] = StancesOf(fit, fit.movement.walking.contacts, file);
  if (stances.empty())
    throw Fail("{}: no plate bears this foot from heel strike to toe-off; --map chooses the leg",
               options.forces.string());
  const loads::LoadsResult result = loads::FindStanceLoads(fit.trajectory, fit.motion, stances, path, options.loads,
                                                           InLeg(options, file, bearing, trial, fit));
  WriteTable(run.Result("loads.csv"), result);
  DrawPngAndSvg("loads", run, figure::DrawLoads, result, options.trial.filename().string());
  Json of_stances = Json::array();
  for (const loads::RiseLoads& stance : result.rises) {
    const auto most_nm = [&](double loads::LoadsRow::*member) {
      return (*std::ranges::max_element(stance.rows, {}, member)).*member;
    };
    const Json peak = PeakJson(stance, options.loads.body.mass_kg);
    run.Report(
        "stance {}, {:.3f} to {:.3f} s: largest extension moments knee {} N m (95 %: {} to {}) at {:.0f}°, ankle {} N "
        "m, hip {} N m\n",
        stance.repetition, stance.onset_s, stance.standing_s, SignificantText(stance.peak.knee_nm, 3),
        SignificantText(stance.peak.low_nm, 3), SignificantText(stance.peak.high_nm, 3), stance.peak.knee_deg,
        SignificantText(most_nm(&loads::LoadsRow::ankle_nm), 3), SignificantText(most_nm(&loads::LoadsRow::hip_nm), 3));
    of_stances.push_back({{"repetition", stance.repetition},
                          {"heel_strike_s", stance.onset_s},
                          {"toe_off_s", stance.standing_s},
                          {"peak", peak},
                          {"peak_ankle_nm", most_nm(&loads::LoadsRow::ankle_nm)},
                          {"peak_hip_nm", most_nm(&loads::LoadsRow::hip_nm)},
                          {"knee_energy_j", stance.knee_energy_j}});
  }
  return {{"method", Method(result)}, {"stances", of_stances}, {"body", BodyJson(result.body)}};
}

Json SummaryJson(const loads::LoadsResult& result, const MeanRise& mean, double mass_kg) {
  Json rises = Json::array();
  for (const loads::RiseLoads& rise : result.rises)
    rises.push_back({{"repetition", rise.repetition},
                     {"onset_s", rise.onset_s},
                     {"seat_off_s", rise.seat_off_s},
                     {"standing_s", rise.standing_s},
                     {"peak", PeakJson(rise, mass_kg)},
                     {"knee_energy_j", rise.knee_energy_j}});
  Json json;
  json["method"] = Method(result);
  json["peak_knee_nm"] = mean.peak.knee_nm;
  json["peak_knee_nm_interval"] = {mean.peak.low_nm, mean.peak.high_nm};
  json["peak_knee_nm_kg"] = mean.peak.knee_nm / mass_kg;
  json["peak_knee_deg"] = mean.peak.knee_deg;
  json["knee_energy_j"] = mean.knee_energy_j;
  if (result.from_ground) {
    json["trunk_offset_mm"] = nullptr;
  } else {
    json["trunk_offset_mm"] = {{"along", result.trunk_offset_mm.x()},
                               {"across", result.trunk_offset_mm.y()},
                               {"along_sd", result.trunk_offset_sd_mm.x()},
                               {"across_sd", result.trunk_offset_sd_mm.y()}};
    json["trunk_from"] = result.has_shoulder ? "shoulder" : "waist";
  }
  json["balance"] = BalanceJson(result);
  json["momentum"] = MomentumJson(mean.momentum, mass_kg);
  json["body"] = BodyJson(result.body);
  json["rises"] = std::move(rises);
  return json;
}

std::string BalanceReport(const loads::Balance& balance) {
  const std::string text = fmt::format(
      "balance: in a very slow rise the centre of pressure would be {:.0f} mm {} the foot (at {:.0f} % of the rise)",
      std::abs(balance.slow.margin_mm), balance.slow.margin_mm < 0 ? "outside" : "inside", balance.slow.at_percent);
  if (!balance.slowest_s) return text + "\n";
  return text + fmt::format("; along this path balance takes a rise of at most {} s\n",
                            SignificantText(*balance.slowest_s, 2));
}

// Empty where it is not known.
std::string MomentumReport(const loads::RiseMomentum& mean, double mass_kg) {
  if (!std::isfinite(mean.forward_max_m_s)) return "";
  std::string text = "centre of mass: ";
  if (std::isfinite(mean.seat_off_m))
    text += fmt::format("{:.0f} mm {} the ankle at seat-off; ", kMmPerM * std::abs(mean.seat_off_m),
                        mean.seat_off_m < 0 ? "behind" : "before");
  return text + fmt::format("forward at most {:.2f} m/s ({:.0f} N s), upward {:.2f} m/s ({:.0f} N s)\n",
                            mean.forward_max_m_s, mass_kg * mean.forward_max_m_s, mean.upward_max_m_s,
                            mass_kg * mean.upward_max_m_s);
}

std::string ReportOf(const loads::LoadsResult& result, const MeanRise& mean, double mass_kg, bool given_share) {
  const double half_nm = (mean.peak.high_nm - mean.peak.low_nm) / 2;
  const auto nm = [&](double value) { return KnownText(value, half_nm, 1); };
  std::string text = fmt::format(
      "peak knee extension moment of one leg: {} N m (95 %: {} to {}), {} N m/kg, at {:.0f}°; mean of {}, {}\n",
      nm(mean.peak.knee_nm), nm(mean.peak.low_nm), nm(mean.peak.high_nm),
      KnownText(mean.peak.knee_nm / mass_kg, half_nm / mass_kg, 2), mean.peak.knee_deg,
      Counted(result.rises.size(), "rise"), result.from_ground ? "from the ground's forces" : "without force plates");
  text += BalanceReport(result.balance) + MomentumReport(mean.momentum, mass_kg);
  if (result.from_ground) return text;
  text += fmt::format("the 95 % interval assumes that the leg bears {:.0f} to {:.0f} % of the body's weight{}\n",
                      100 * result.weight_share[0], 100 * result.weight_share[1],
                      given_share ? "" : "; --share, where it is known, narrows it");
  return text + fmt::format("the trunk's centre of mass: {} mm along and {} mm across the trunk from the table's\n",
                            WithSign(PlusMinusText(result.trunk_offset_mm.x(), result.trunk_offset_sd_mm.x(), 0)),
                            WithSign(PlusMinusText(result.trunk_offset_mm.y(), result.trunk_offset_sd_mm.y(), 0)));
}

}  // namespace

void Describe(LoadsRunOptions& o, OptionList& options) {
  DescribeTrialFit(o, options);
  Describe(o.loads, options);
  DescribeForces(o, options);
  options.Add("plates", o.plates, "The feet's force plates, in the file's order").Value("right=N,left=N");
  options
      .AddChoice("leg", o.leg, OptionList::Choices<std::string>{{"right", "right"}, {"left", "left"}},
                 "Leg whose markers these are")
      .Otherwise("by the markers' names");
  options.Check([&o](const OptionList&) {
    exchange::CheckPlates(o.plates);
    if (!o.plates.empty() && o.forces.empty())
      throw UsageError("--plates needs a file with the forces: give it with --forces");
    if (!o.leg.empty() && o.forces.empty())
      throw UsageError("--leg has no effect without --forces: it says which force plate is this leg's; leave it out");
  });
}

Json RunLoads(const LoadsRunOptions& options, Run& run) {
  options.loads.body.Check();
  const exchange::Trial trial = ReadTrialFor(options.trial, options.reading, options);
  run.AddInputs(InputsOf(options));
  if (!options.forces.empty() && !trial.plane_from_space)
    throw Fail(
        "{}: a trial in a plane does not say where the force plates are; give the marker file of the same laboratory "
        "(.trc, .c3d)",
        trial.file.string());
  run.Begin({"summary.json", "loads.csv", "pace.csv", "centre_of_mass.csv", "momentum.csv", "loads.json", "loads.png",
             "loads.svg"});
  const gait::LegFitResult fit = FitTrial(trial, options.fit, run, options, options.events, options);
  loads::LegPathOptions path;
  path.facing = fit.motion.facing;
  path.up = fit.up;
  path.markers = options.fit.markers;
  if (fit.movement.kind == gait::MovementKind::kWalking) return RunStances(options, trial, fit, path, run);
  std::optional<loads::GroundForces> forces;
  if (!options.forces.empty()) forces = ReadForces(options, trial, fit, run);
  const loads::LoadsResult result =
      loads::FindLoads(fit.trajectory, fit.motion, fit.events, path, options.loads, forces);
  for (const std::string& warning : result.warnings) run.Warn(warning);
  WriteTable(run.Result("loads.csv"), result);
  WritePaces(run.Result("pace.csv"), result.balance);
  const double mass_kg = options.loads.body.mass_kg;
  WriteCentres(run.Result("centre_of_mass.csv"), result, mass_kg);
  WriteMomenta(run.Result("momentum.csv"), result, mass_kg);
  WriteJsonFile(run.Result("loads.json"), ProfileJson(result, options));
  DrawPngAndSvg("loads", run, figure::DrawLoads, result, options.trial.filename().string());
  const MeanRise mean = MeanOf(result);
  run.Report(ReportOf(result, mean, mass_kg, options.loads.uncertainty.trunk_share.has_value()));
  return SummaryJson(result, mean, mass_kg);
}

}  // namespace lake::commands
