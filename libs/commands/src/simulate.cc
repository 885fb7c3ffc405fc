#include "lake/commands/simulate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "assistance_tables.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/plausible.h"
#include "lake/core/uncertain_text.h"
#include "lake/drawing/linkage_animation.h"
#include "lake/drawing/linkage_dxf.h"
#include "lake/drawing/linkage_figures.h"
#include "lake/figure/design_figures.h"
#include "lake/linkage/linkage.h"
#include "lake/parts/strength.h"
#include "lake/problem/assistance.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "part_tables.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

// One line of the table.
struct Row {
  linkage::Pose pose;
  linkage::Transmission transmission;
  double force_n;

  Row(const linkage::Links& links, double stroke_mm, double knee_torque_nm)
      : pose(linkage::RequirePose(links, stroke_mm)),
        transmission(linkage::TransmissionOf(links, pose)),
        force_n(linkage::ActuatorForce(transmission, knee_torque_nm)) {}
};

// The paper's poses as far as this design has them, and its own largest whole degree.
std::vector<double> DefaultAngles(const linkage::Links& links, const linkage::UsedRange& range) {
  const double most = DegreesFromRadians(std::max(range.theta_at_lower_rad, range.theta_at_upper_rad));
  std::vector<double> angles;
  for (const double angle : {2.0, 70.0, 110.0, std::floor(most)})
    if ((angles.empty() || angle > angles.back()) && linkage::StrokeForAngle(links, range, RadiansFromDegrees(angle)))
      angles.push_back(angle);
  return angles;
}

double RequireStroke(const linkage::Links& links, const linkage::UsedRange& range, double angle_deg) {
  const auto stroke = linkage::StrokeForAngle(links, range, RadiansFromDegrees(angle_deg));
  if (stroke) return *stroke;
  throw Fail("the knee angle {}° is outside the range of this design, {:.1f}°..{:.1f}° (strokes {}..{} mm)", angle_deg,
             DegreesFromRadians(std::min(range.theta_at_lower_rad, range.theta_at_upper_rad)),
             DegreesFromRadians(std::max(range.theta_at_lower_rad, range.theta_at_upper_rad)),
             SignificantText(range.stroke.lower_mm, 6), SignificantText(range.stroke.upper_mm, 6));
}

// What is asked for, made sure of before anything is written. Poses that are asked for may lie beyond the used range.
struct Request {
  linkage::UsedRange range;
  std::vector<double> angles_deg, angle_strokes_mm;
  std::vector<double> shown_mm;  // strokes of both kinds, ascending
};

Request Resolve(const linkage::Design& design, const SimulationOptions& options) {
  for (const double stroke : options.strokes_mm) linkage::RequirePose(design.links, stroke);
  double least_deg = 0;
  for (const double angle : options.angles_deg) least_deg = std::min(least_deg, angle);
  Request request;
  request.range = linkage::FindUsedRange(design.links, design.d_min_mm, design.d_max_mm);
  const linkage::UsedRange shown =
      linkage::FindUsedRange(design.links, design.d_min_mm, design.d_max_mm, RadiansFromDegrees(least_deg));
  request.angles_deg = options.angles_deg.empty() ? DefaultAngles(design.links, request.range) : options.angles_deg;
  request.shown_mm = options.strokes_mm;
  for (const double angle : request.angles_deg) {
    request.angle_strokes_mm.push_back(RequireStroke(design.links, shown, angle));
    request.shown_mm.push_back(request.angle_strokes_mm.back());
  }
  std::sort(request.shown_mm.begin(), request.shown_mm.end());
  request.shown_mm.erase(std::unique(request.shown_mm.begin(), request.shown_mm.end()), request.shown_mm.end());
  return request;
}

// The regular grid and the strokes asked for, ascending.
std::vector<double> StrokesOf(const linkage::StrokeRange& range, int grid_rows, const std::vector<double>& asked_mm) {
  std::vector<double> strokes = asked_mm;
  for (int i = 0; i < grid_rows; ++i)
    strokes.push_back(i + 1 == grid_rows ? range.upper_mm : range.lower_mm + range.Travel() * i / (grid_rows - 1));
  std::sort(strokes.begin(), strokes.end());
  strokes.erase(std::unique(strokes.begin(), strokes.end()), strokes.end());
  return strokes;
}

void WriteTable(const std::filesystem::path& path, const drawing::LinkageLook& look,
                const std::vector<double>& strokes_mm) {
  CsvWriter table({"stroke_mm", "knee_deg", "deg_per_mm", "moment_arm_mm", "force_n", "transmission_deg",
                   "actuator_angle_deg", "branch"});
  for (const double stroke : strokes_mm) {
    const Row row(look.links, stroke, look.knee_torque_nm);
    table.AddRow(stroke, DegreesFromRadians(row.pose.theta_rad), DegreesFromRadians(row.transmission.radians_per_mm),
                 row.transmission.moment_arm_mm, row.force_n, DegreesFromRadians(row.transmission.transmission_rad),
                 DegreesFromRadians(row.transmission.actuator_rad), static_cast<int>(row.pose.branch));
  }
  table.Write(path);
}

// The knee's extension torque over the stroke or over the knee angle.
class TorqueTable {
 public:
  explicit TorqueTable(double constant_nm) : constant_nm_(constant_nm) {}

  // A CSV table with stroke_mm or knee_deg, and knee_torque_nm. Throws Error with file and line: no such columns, fewer
  // than two rows, two rows for one place.
  static TorqueTable Read(const std::filesystem::path& path);

  // N m, linear between rows; NaN beyond them.
  double At(const linkage::Pose& pose) const;

 private:
  double constant_nm_ = 0;
  std::map<double, double> rows_;  // none: the same torque everywhere
  bool over_stroke_ = false;
};

TorqueTable TorqueTable::Read(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  TorqueTable torques(0);
  torques.over_stroke_ = table.Has("stroke_mm");
  if (!torques.over_stroke_ && !table.Has("knee_deg"))
    throw Fail("{}: a table of torques needs a column stroke_mm or knee_deg", path.string());
  const std::size_t place = table.Column(torques.over_stroke_ ? "stroke_mm" : "knee_deg");
  const std::size_t torque = table.Column("knee_torque_nm");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const double at = table.RequiredNumber(row, place);
    if (!torques.rows_.emplace(at, table.RequiredNumber(row, torque)).second)
      throw Fail("{}: a second torque for {} {}", table.Where(row), table.Header()[place], at);
  }
  if (torques.rows_.size() < 2) throw Fail("{}: a table of torques needs two rows or more", path.string());
  return torques;
}

double TorqueTable::At(const linkage::Pose& pose) const {
  if (rows_.empty()) return constant_nm_;
  const double place = over_stroke_ ? pose.stroke_mm : DegreesFromRadians(pose.theta_rad);
  const auto after = rows_.lower_bound(place);
  if (after == rows_.end()) return kNaN;
  if (after->first == place) return after->second;
  if (after == rows_.begin()) return kNaN;
  const auto before = std::prev(after);
  const double part = (place - before->first) / (after->first - before->first);
  return before->second + part * (after->second - before->second);
}

TorqueTable ReadTorques(const SimulationOptions& options) {
  if (options.torques.empty()) return TorqueTable(options.knee_torque_nm);
  return TorqueTable::Read(options.torques);
}

// Forces where the torque is known: everywhere, or as far as its table goes.
std::vector<parts::LoadedPose> LoadedPosesOf(const linkage::Links& links, const std::vector<double>& strokes_mm,
                                             const TorqueTable& torque) {
  std::vector<parts::LoadedPose> poses;
  for (const double stroke : strokes_mm) {
    const linkage::Pose pose = linkage::RequirePose(links, stroke);
    poses.push_back({pose, torque.At(pose), linkage::MemberForcesOf(pose, torque.At(pose))});
  }
  return poses;
}

std::vector<parts::LoadedPose> Within(const linkage::StrokeRange& used, std::vector<parts::LoadedPose> poses) {
  std::erase_if(poses, [&](const parts::LoadedPose& at) {
    return !(used.lower_mm <= at.pose.stroke_mm && at.pose.stroke_mm <= used.upper_mm);
  });
  return poses;
}

std::vector<figure::PinForcesRow> PinForcesOf(const std::vector<parts::LoadedPose>& poses) {
  std::vector<figure::PinForcesRow> rows;
  for (const parts::LoadedPose& at : poses)
    rows.push_back({at.pose.stroke_mm, DegreesFromRadians(at.pose.theta_rad), at.forces});
  return rows;
}

void WritePinForces(const std::filesystem::path& path, const std::vector<figure::PinForcesRow>& rows) {
  CsvWriter table({"stroke_mm", "knee_deg", "actuator_n", "coupler_n", "bar_n", "knee_pin_n", "thigh_pin_n",
                   "tip_pin_n", "shank_pin_n", "mount_n"});
  for (const auto& [stroke, knee_deg, forces] : rows)
    table.AddRow(stroke, knee_deg, forces.actuator_n, forces.coupler_n, forces.bar_n, forces.KneePin(),
                 forces.ThighPin(), forces.TipPin(), forces.ShankPin(), forces.Mount());
  table.Write(path);
}

void WriteStrength(const std::filesystem::path& path, const std::vector<parts::StrengthCheck>& checks) {
  CsvWriter table({"part", "check", "knee_deg", "load", "unit", "stress_mpa", "allowed", "safety"});
  for (const parts::StrengthCheck& check : checks)
    table.AddRow(check.part, check.check, check.KneeAngle_deg(), check.load, check.Unit(), check.stress_mpa,
                 check.allowed, check.Safety());
  table.Write(path);
}

// The check with the least safety factor; nullptr without a load.
const parts::StrengthCheck* WeakestOf(const std::vector<parts::StrengthCheck>& checks) {
  const auto weakest = std::ranges::min_element(checks, {}, &parts::StrengthCheck::Safety);
  return weakest == checks.end() ? nullptr : &*weakest;
}

Json WeakestJson(const parts::StrengthCheck* weakest) {
  if (!weakest) return nullptr;
  return {{"safety", weakest->Safety()},
          {"part", weakest->part},
          {"check", weakest->check},
          {"at_deg", weakest->KneeAngle_deg()}};
}

// How far from in line: coupler and shank link, actuator and slewing bar.
double DeadPointAngle_deg(const linkage::Links& links, const linkage::Pose& pose) {
  const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
  const auto off = [](double angle_rad) {
    return DegreesFromRadians(std::min(angle_rad, std::numbers::pi - angle_rad));
  };
  return std::min(off(transmission.transmission_rad), off(transmission.actuator_rad));
}

// What would help. Near a dead point forces grow without bound, and no plate is thick enough.
std::string AdviceOn(const parts::StrengthCheck& weakest, const linkage::Links& links) {
  using Kind = parts::StrengthCheck::Kind;
  constexpr double kNear_deg = 10;
  const double off_deg = DeadPointAngle_deg(links, weakest.at.pose);
  if (weakest.kind != Kind::kBending && off_deg < kNear_deg)
    return fmt::format(
        "the linkage is {}° from a dead point there, where forces grow without bound: end its range before that, "
        "or optimise with a transmission angle or a safety factor (lake optimize --min-transmission, "
        "--safety-factor)",
        SignificantText(off_deg, 2));
  return weakest.kind == Kind::kBuckling ? "a thicker rod, a shorter actuator or a smaller torque would help"
                                         : "thicker or wider plates, thicker pins or a smaller torque would help";
}

void WarnOfStrength(const parts::StrengthCheck& weakest, const linkage::Links& links, Run& run) {
  if (!(weakest.Safety() < 1)) return;
  run.Warn("{} of the {} exceeds what it bears at {:.1f}° (safety factor {}): {}", weakest.check, weakest.part,
           weakest.KneeAngle_deg(), SignificantText(weakest.Safety(), 2), AdviceOn(weakest, links));
}

// Each pin's largest force, and where.
Json PinForcesJson(const std::vector<figure::PinForcesRow>& rows) {
  const std::pair<const char*, double (linkage::MemberForces::*)() const> kPins[] = {
      {"knee_pin", &linkage::MemberForces::KneePin},
      {"thigh_pin", &linkage::MemberForces::ThighPin},
      {"tip_pin", &linkage::MemberForces::TipPin},
      {"shank_pin", &linkage::MemberForces::ShankPin},
      {"mount", &linkage::MemberForces::Mount}};
  Json json = Json::object();
  for (const auto& [name, force] : kPins) {
    const figure::PinForcesRow* largest = nullptr;
    for (const figure::PinForcesRow& row : rows) {
      const double force_n = (row.forces.*force)();
      if (std::isfinite(force_n) && (!largest || force_n > (largest->forces.*force)())) largest = &row;
    }
    if (largest) json[name] = {{"largest_n", (largest->forces.*force)()}, {"at_deg", largest->knee_deg}};
  }
  return json;
}

Json RowJson(const Row& row) {
  return {{"stroke_mm", row.pose.stroke_mm},
          {"knee_deg", DegreesFromRadians(row.pose.theta_rad)},
          {"deg_per_mm", DegreesFromRadians(row.transmission.radians_per_mm)},
          {"moment_arm_mm", row.transmission.moment_arm_mm},
          {"force_n", row.force_n},
          {"transmission_deg", DegreesFromRadians(row.transmission.transmission_rad)},
          {"actuator_angle_deg", DegreesFromRadians(row.transmission.actuator_rad)},
          {"shank_pressure_deg", DegreesFromRadians(row.transmission.shank_pressure_rad)},
          {"actuator_pressure_deg", DegreesFromRadians(row.transmission.actuator_pressure_rad)}};
}

// What ended the used range.
const char* EndOf(const linkage::UsedRange& range) {
  const char* const kEnds[] = {"d_max", "standing", "knee angle turns back", "end of assembly"};
  return kEnds[static_cast<int>(range.end)];
}

Json RangeJson(const linkage::Design& design, const linkage::UsedRange& range) {
  Json assembly = Json::array();
  for (const linkage::StrokeRange& part : linkage::AssemblyRanges(design.links))
    assembly.push_back({part.lower_mm, part.upper_mm});
  return {{"range_deg", DegreesFromRadians(range.theta_at_lower_rad)},
          {"least_deg", DegreesFromRadians(range.theta_at_upper_rad)},
          {"used_stroke_mm", {range.stroke.lower_mm, range.stroke.upper_mm}},
          {"travel_mm", range.stroke.Travel()},
          {"used_range_ends_at", EndOf(range)},
          {"assembly_ranges_mm", assembly},
          {"turning_strokes_mm", linkage::TurningStrokes(design.links)}};
}

Json SingularityJson(const linkage::Links& links, double stroke_mm) {
  const linkage::SingularityDistances distances =
      linkage::DistancesToSingularities(links, linkage::RequirePose(links, stroke_mm));
  return {{"stroke_mm", stroke_mm},
          {"actuator_folded_mm", distances.actuator_folded_mm},
          {"actuator_extended_mm", distances.actuator_extended_mm},
          {"shank_folded_mm", distances.shank_folded_mm},
          {"shank_extended_mm", distances.shank_extended_mm}};
}

// The main numbers, and a line for each pose asked for.
std::string ReportOf(const linkage::Design& design, const Request& request, const parts::StrengthCheck* weakest,
                     double knee_torque_nm) {
  const linkage::UsedRange& range = request.range;
  const linkage::Grashof grashof = linkage::GrashofOf(design.links);
  std::string text = fmt::format(
      "range {:.4f}° to {:.4f}° over strokes {:.4f} to {:.4f} mm (travel {:.2f} mm, ends at: {})\n"
      "Grashof: {}, slack {} mm; actuator {} mm from its dead point at d_min\n",
      DegreesFromRadians(range.theta_at_lower_rad), DegreesFromRadians(range.theta_at_upper_rad), range.stroke.lower_mm,
      range.stroke.upper_mm, range.stroke.Travel(), EndOf(range), linkage::NameOf(grashof.type),
      SignificantText(grashof.slack_mm, 4),
      SignificantText(
          linkage::DistancesToSingularities(design.links, linkage::RequirePose(design.links, range.stroke.lower_mm))
              .actuator_folded_mm,
          4));
  if (weakest)
    text += fmt::format("least safety factor {}: {} of the {} at {:.1f}°\n", SignificantText(weakest->Safety(), 3),
                        weakest->check, weakest->part, weakest->KneeAngle_deg());
  text += fmt::format("{:>10} {:>9} {:>9} {:>10} {:>9} {:>13} {:>11}\n", "stroke mm", "knee °", "° per mm", "arm mm",
                      "force N", "transmission °", "actuator °");
  for (const double stroke_mm : request.shown_mm) {
    const Row row(design.links, stroke_mm, knee_torque_nm);
    text +=
        fmt::format("{:>10.4f} {:>9.4f} {:>9.4f} {:>10.3f} {:>9.1f} {:>14.3f} {:>10.3f}\n", stroke_mm,
                    DegreesFromRadians(row.pose.theta_rad), DegreesFromRadians(row.transmission.radians_per_mm),
                    row.transmission.moment_arm_mm, row.force_n, DegreesFromRadians(row.transmission.transmission_rad),
                    DegreesFromRadians(row.transmission.actuator_rad));
  }
  return text;
}

Json WearJson(const person::Body& body, const linkage::WearCheck& check) {
  return {{"height_mm", body.height_mm},
          {"mass_kg", body.mass_kg},
          {"thigh_mm", body.thigh.length_mm},
          {"shank_mm", body.shank.length_mm},
          {"seated_deg", check.seated_deg},
          {"standing_deg", check.standing_deg},
          {"mount_below_hip_mm", check.mount_below_hip_mm},
          {"mount_behind_thigh_mm", check.mount_behind_thigh_mm},
          {"seat_clearance_mm", check.seat_clearance_mm},
          {"seat_edge_needed_mm", check.seat_edge_needed_mm},
          {"actuator_to_thigh_mm", check.thigh_clearance_mm},
          {"actuator_to_thigh_at_deg", check.thigh_clearance_deg},
          {"actuator_to_shank_mm", check.shank_clearance_mm},
          {"actuator_to_shank_at_deg", check.shank_clearance_deg},
          {"reach_behind_standing_mm", check.reach_behind_standing_mm},
          {"fits_along_thigh", check.FitsAlongThigh()},
          {"mount", linkage::NameOf(check.mount)},
          {"clears_seat", check.meets_seat ? Json(check.ClearsSeat()) : Json()},
          {"clears_limb", check.meets_limbs ? Json(check.ClearsLimb()) : Json()}};
}

// What collides on the body, each with what to do about it.
void WarnOfBody(const linkage::WearCheck& check, Run& run) {
  if (!check.FitsAlongThigh())
    run.Warn("the mount does not fit on the thigh: its plate ends {:.1f} mm above the hip joint; limit l6",
             -check.mount_below_hip_mm);
  if (!check.ClearsSeat())
    run.Warn(
        "seated at {:.1f}°, the linkage reaches {:.1f} mm into the seat: use a seat that begins at least {:.0f} mm "
        "behind the knee, or limit l5",
        check.seated_deg, -check.seat_clearance_mm, std::ceil(check.seat_edge_needed_mm));
  std::vector<std::string> overlaps;
  const auto add = [&](const char* limb, double clearance_mm, double at_deg) {
    if (clearance_mm < 0)
      overlaps.push_back(fmt::format("the {} by up to {:.1f} mm (at {:.1f}°)", limb, -clearance_mm, at_deg));
  };
  if (check.meets_limbs) {
    add("thigh", check.thigh_clearance_mm, check.thigh_clearance_deg);
    add("shank", check.shank_clearance_mm, check.shank_clearance_deg);
  }
  if (!overlaps.empty())
    run.Warn("seen from the side, the actuator overlaps {}: mount it beside the leg, not behind it",
             fmt::join(overlaps, " and "));
}

void WarnOf(const linkage::Design& design, const linkage::UsedRange& range, Run& run) {
  const double range_deg = DegreesFromRadians(range.theta_at_lower_rad);
  if (design.range_deg && std::abs(*design.range_deg - range_deg) > 0.01)
    run.Warn("the design file says range_deg = {}, but its links give {:.4f}°", *design.range_deg, range_deg);
  constexpr double kRounding_mm = 1e-4;  // as the message shows it
  if (design.d_max_mm && *design.d_max_mm > range.stroke.upper_mm + kRounding_mm)
    run.Warn("d_max = {} mm is past the used range, which ends at {:.4f} mm", *design.d_max_mm, range.stroke.upper_mm);
  const double slack =
      linkage::DistancesToSingularities(design.links, linkage::RequirePose(design.links, design.d_min_mm))
          .actuator_folded_mm;
  if (slack < 1)
    run.Warn(
        "at the shortest stroke the linkage is {:.5f} mm from the actuator's dead point, where the force has no bound; "
        "choose a longer one, or a design with --singularity-margin",
        slack);
}

// The actuator is as long as the design says; what does not fit its maker's lengths is a warning.
void WarnOfActuator(const problem::LinearActuator& actuator, const linkage::StrokeRange& used, Run& run) {
  constexpr double kRounding_mm = 1e-3;
  if (actuator.closed_mm && *actuator.closed_mm > used.lower_mm + kRounding_mm)
    run.Warn("{} is {} mm long when closed, and the design goes down to {} mm", actuator.name,
             SignificantText(*actuator.closed_mm, 6), SignificantText(used.lower_mm, 6));
  if (actuator.closed_mm && actuator.travel_mm &&
      *actuator.closed_mm + *actuator.travel_mm < used.upper_mm - kRounding_mm)
    run.Warn("{} reaches {} mm, and the design goes up to {} mm", actuator.name,
             SignificantText(*actuator.closed_mm + *actuator.travel_mm, 6), SignificantText(used.upper_mm, 6));
}

bool IsAbove(double value, const std::optional<double>& limit) {
  constexpr double kRounding = 1e-6;  // a solver leaves a value this much above its limit
  return limit && value > *limit * (1 + kRounding);
}

// Without a load profile: the largest force of the torques given, over the used range.
void WarnOfForce(const problem::LinearActuator& actuator, const std::vector<figure::PinForcesRow>& used, Run& run) {
  double most_n = 0, at_deg = 0;
  for (const figure::PinForcesRow& row : used)
    if (std::abs(row.forces.actuator_n) > most_n) {
      most_n = std::abs(row.forces.actuator_n);
      at_deg = row.knee_deg;
    }
  if (IsAbove(most_n, actuator.LiftingForce()))
    run.Warn("{} lifts {:.0f} N, and the torque at the knee takes {:.0f} N at {:.1f}°", actuator.name,
             *actuator.LiftingForce(), most_n, at_deg);
}

// Where it may rest: the force that it must hold there.
double RestingForce(const problem::Assistance& assistance, bool rests_anywhere) {
  double force_n = 0;
  for (const problem::AssistanceRow& row : assistance.rows)
    if (!std::isnan(row.force_n)) force_n = std::max(rests_anywhere ? force_n : 0, std::abs(row.force_n));
  return force_n;
}

// What it cannot although it lifts its share.
void WarnOfShare(const problem::LinearActuator& actuator, const problem::Assistance& assistance,
                 const problem::SynthesisProblem& load, Run& run) {
  if (const double force_n = RestingForce(assistance, load.rests_anywhere); IsAbove(force_n, actuator.holding_force_n))
    run.Warn("{} holds {:.0f} N at rest, and its share takes {:.0f} N{}", actuator.name, *actuator.holding_force_n,
             force_n, load.rests_anywhere ? "" : " when standing");
  if (std::isfinite(assistance.shortest_s) && IsAbove(assistance.shortest_s, load.duration_s))
    run.Warn("a rise in {} s is asked for, and {} takes {:.2f} s or longer with this linkage",
             SignificantText(*load.duration_s, 6), actuator.name, assistance.shortest_s);
}

// The load as it is on this design.
problem::SynthesisProblem LoadOn(const linkage::Design& design, const linkage::UsedRange& range,
                                 problem::SynthesisProblem load) {
  load.d_min_mm = design.d_min_mm;
  load.limits["d_max_mm"] = range.stroke.upper_mm;
  load.standing_deg = DegreesFromRadians(range.theta_at_upper_rad);
  return load;
}

// What the design's actuator does along the load profile.
Json Assist(const problem::Assistance& assistance, const linkage::UsedRange& range,
            const problem::SynthesisProblem& load, Run& run) {
  if (load.actuator) WarnOfShare(*load.actuator, assistance, load, run);
  if (load.profile->LargestAngle() > range.theta_at_lower_rad)
    run.Warn(
        "the load profile bends the knee to {:.1f}°, and this design to {:.1f}°: beyond that no force, speed or "
        "duration is known",
        DegreesFromRadians(load.profile->LargestAngle()), DegreesFromRadians(range.theta_at_lower_rad));
  return WriteAssistance(assistance, load, run);
}

// The moment that the device gives over its used range: its share of the load profile, else the torque given.
std::vector<KneeMoment> MomentsOf(const std::optional<problem::Assistance>& assistance, double share,
                                  const std::vector<parts::LoadedPose>& used) {
  std::vector<KneeMoment> moments;
  if (assistance)
    for (const problem::AssistanceRow& row : assistance->rows)
      moments.push_back({row.stroke_mm, row.knee_deg, share * row.knee_nm});
  else
    for (const parts::LoadedPose& at : used)
      moments.push_back({at.pose.stroke_mm, DegreesFromRadians(at.pose.theta_rad), at.knee_torque_nm});
  std::erase_if(moments, [](const KneeMoment& at) { return std::isnan(at.stroke_mm); });
  return moments;
}

// With its links as heavy as was said, or as the parts are.
cuffs::CuffOptions WornOf(const SimulationOptions& options, const parts::Mechanism& mechanism) {
  constexpr double kGramsPerKilogram = 1000;
  const double shank_link_g = parts::PartList(mechanism)[static_cast<std::size_t>(parts::Body::kShank)].mass_g.value();
  const double actuator_g = options.load.actuator && options.load.actuator->mass_g
                                ? *options.load.actuator->mass_g
                                : options.parts.actuator_mass_kg * kGramsPerKilogram;
  const double thigh_link_g = MassOf_g(mechanism) - shank_link_g + actuator_g;
  cuffs::CuffOptions worn = options.leg_loads.cuffs;
  worn.thigh_link_kg = options.leg_loads.thigh_link_kg.value_or(thigh_link_g / kGramsPerKilogram);
  worn.shank_link_kg = options.leg_loads.shank_link_kg.value_or(shank_link_g / kGramsPerKilogram);
  return worn;
}

void DrawPictures(const drawing::LinkageLook& look, const Request& request, const linkage::WearCheck& check, Run& run) {
  Progress progress("pictures", "files", static_cast<std::int64_t>(2 * request.angles_deg.size() + 4), run.Quiet());
  for (const char* ending : {"png", "svg"}) {
    drawing::DrawAngleVsStroke(run.Result(fmt::format("angle_vs_stroke.{}", ending)), look, request.shown_mm);
    progress.Advance();
    for (std::size_t i = 0; i < request.angles_deg.size(); ++i) {
      ThrowIfInterrupted();
      const std::string name = fmt::format("pose_{}.{}", FormatNumber(request.angles_deg[i]), ending);
      drawing::DrawLinkagePose(run.Result(name), look, linkage::RequirePose(look.links, request.angle_strokes_mm[i]));
      progress.Advance();
    }
  }
  const double middle = 0.5 * (look.range.stroke.lower_mm + look.range.stroke.upper_mm);
  drawing::DrawLinkageSchematic(run.Result("schematic.svg"), look.links, linkage::RequirePose(look.links, middle));
  progress.Advance();
  DrawPngAndSvg("mannequin", run, drawing::DrawMannequin, look, check);
  progress.Advance();
}

}  // namespace

void SimulationOptions::Check() const {
  if (knee_torque_nm == 0) throw UsageError("--knee-torque must not be 0: the force is given for it");
  leg_loads.Check();
  load.CheckLoad();
}

std::vector<InputFile> InputsOf(const SimulationOptions& options) {
  std::vector<InputFile> inputs = problem::LoadFiles(options.load);
  if (!options.torques.empty()) inputs.push_back({options.torques, "torques"});
  return inputs;
}

Json SimulateLinkage(const linkage::Design& design, const SimulationOptions& options, Run& run) {
  options.Check();
  options.parts.Check();
  run.AddInputs(InputsOf(options));
  const Request request = Resolve(design, options);
  const TorqueTable torque = ReadTorques(options);
  std::vector<std::string> names = {"assistance.csv", "assistance.png", "assistance.svg"};
  if (!options.load.HasLoadProfile()) names.clear();
  if (options.leg_loads.AreAsked()) names.emplace_back("leg_loads.csv");
  names.insert(names.end(),
               {"summary.json", "angle_vs_stroke.csv", "angle_vs_stroke.png", "angle_vs_stroke.svg", "schematic.svg",
                "mannequin.png", "mannequin.svg", "design.dxf", "animation.mp4", "animation.gif", "pin_forces.csv",
                "pin_forces.png", "pin_forces.svg", "parts.csv", "strength.csv"});
  run.Begin(names);
  const drawing::LinkageLook look{
      .links = design.links,
      .range = request.range,
      .body = person::BodyOf(options.body),
      .wear = {options.parts.bar_width_mm, options.parts.actuator_diameter_mm, options.seat_edge_mm,
               design.placement_mm, options.mount.value_or(design.mount), options.has_wide_seat},
      .knee_torque_nm = options.knee_torque_nm};
  const linkage::WearCheck check = linkage::CheckWear(look.links, look.range, look.body, look.wear);
  WarnOfBody(check, run);
  WarnOf(design, request.range, run);
  if (options.load.actuator) WarnOfActuator(*options.load.actuator, request.range.stroke, run);
  const std::vector<double> strokes_mm = StrokesOf(request.range.stroke, options.rows, request.shown_mm);
  WriteTable(run.Result("angle_vs_stroke.csv"), look, strokes_mm);
  const std::vector<parts::LoadedPose> loaded = LoadedPosesOf(look.links, strokes_mm, torque);
  const std::vector<figure::PinForcesRow> pin_forces = PinForcesOf(loaded);
  WritePinForces(run.Result("pin_forces.csv"), pin_forces);
  const std::vector<parts::LoadedPose> used = Within(request.range.stroke, loaded);
  const std::vector<figure::PinForcesRow> used_forces = PinForcesOf(used);
  if (options.load.actuator && !options.load.HasLoadProfile()) WarnOfForce(*options.load.actuator, used_forces, run);
  DrawPngAndSvg("pin_forces", run, figure::DrawPinForces, pin_forces);
  drawing::WriteLinkPlates(run.Result("design.dxf"), design.links, options.parts);
  const parts::Mechanism mechanism = parts::MakeMechanism(design.links, request.range, options.parts);
  WarnOfStack(mechanism, run);
  WritePartList(run.Result("parts.csv"), mechanism);
  const std::vector<parts::StrengthCheck> strength = parts::CheckStrength(mechanism, used);
  WriteStrength(run.Result("strength.csv"), strength);
  DrawPictures(look, request, check, run);
  if (options.animation) drawing::WriteLinkageAnimation(run.Result("animation.mp4"), run.Result("animation.gif"), look);

  const parts::StrengthCheck* weakest = WeakestOf(strength);
  if (weakest) WarnOfStrength(*weakest, design.links, run);
  run.Report(ReportOf(design, request, weakest, options.knee_torque_nm));

  Json summary = RangeJson(design, request.range);
  const auto values = design.links.Values();
  for (std::size_t i = 0; i < values.size(); ++i) summary["links"][fmt::format("l{}", i + 1)] = values[i];
  const linkage::Grashof grashof = linkage::GrashofOf(design.links);
  summary["grashof"] = {{"class", linkage::NameOf(grashof.type)}, {"slack_mm", grashof.slack_mm}};
  summary["singularities"] = {SingularityJson(design.links, request.range.stroke.lower_mm),
                              SingularityJson(design.links, request.range.stroke.upper_mm)};
  summary["knee_torque_nm"] = options.knee_torque_nm;
  summary["parts"] = PartsJson(mechanism);
  summary["weakest"] = WeakestJson(weakest);
  summary["pin_forces"] = PinForcesJson(used_forces);
  summary["poses"] = Json::array();
  for (const double stroke : request.shown_mm)
    summary["poses"].push_back(RowJson(Row(design.links, stroke, options.knee_torque_nm)));
  summary["mannequin"] = WearJson(look.body, check);
  std::optional<problem::Assistance> assistance;
  if (options.load.HasLoadProfile()) {
    const problem::SynthesisProblem load = LoadOn(design, request.range, options.load);
    assistance = problem::FindAssistance(design.links, load);
    summary["assistance"] = Assist(*assistance, request.range, load, run);
  }
  if (options.leg_loads.AreAsked()) {
    const cuffs::CuffOptions worn = WornOf(options, mechanism);
    const std::vector<LegLoadRow> leg_loads =
        LegLoadsOf(MomentsOf(assistance, options.load.assist.value_or(1), used), worn);
    WriteLegLoads(run.Result("leg_loads.csv"), leg_loads);
    summary["leg_loads"] = ReportLegLoads(leg_loads, options.leg_loads, run);
    summary["leg_loads"]["thigh_link_kg"] = worn.thigh_link_kg;
    summary["leg_loads"]["shank_link_kg"] = worn.shank_link_kg;
  }
  return summary;
}

void Describe(SimulationOptions& o, OptionList& options) {
  options.Add("stroke", o.strokes_mm, "Strokes to add to the table").Unit("mm").Value("MM,...").Positive().Repeats();
  options.Add("angles", o.angles_deg, "Knee angles to draw")
      .Unit("degrees")
      .Value("DEG,...")
      .Between(-360, 360)
      .Otherwise("2, 70, 110 and the largest")
      .Repeats();
  options.Add("knee-torque", o.knee_torque_nm, "Extension torque at the knee for which the force is given")
      .Unit("N m")
      .Between(kPlausibleKneeTorque.low, kPlausibleKneeTorque.high);
  options
      .Add("torques", o.torques,
           "Table of extension torques for pin_forces, instead: stroke_mm or knee_deg, then knee_torque_nm")
      .Otherwise("--knee-torque");
  options.Add("rows", o.rows, "Rows of the regular grid of angle_vs_stroke.csv").Between(2, 1'000'000);
  Describe(o.body, options);
  options
      .Add("seat-edge", o.seat_edge_mm,
           "Knee to the front edge of a seat that lies under the linkage, too; 0: half the thigh, for --mount behind")
      .Unit("mm")
      .Between(0, 5000);
  problem::DescribeMount(o.mount, options).Otherwise("the design's");
  problem::DescribeLoad(o.load, options);
  Describe(o.parts, options);
  Describe(o.leg_loads, options);
  options.Add("animation", o.animation, "Write animation.mp4 and .gif").WithNegation();
}

void Describe(DesignSimulation& o, OptionList& options) {
  const auto read = [&o](const OptionTexts& texts, const std::string& said) {
    OptionField<std::filesystem::path>::Set(texts, said, o.file);
    o.design = linkage::ReadDesign(o.file);
    problem::TakeFromDesign(o.design.parts, o.file, OptionsOf(o.options));
    problem::TakeFromDesign(o.design.body, o.file, OptionsOf(o.options));
    o.absent_load = problem::TakeFromDesign(o.design.load, o.file, OptionsOf(o.options));
  };
  options.AddCustom("design", "design.yaml, as lake-optimize writes it", read, [&o] { return o.file.string(); })
      .IsPath(Option::Path::kFile)
      .Operand();
  options.Add("links", o.links, "Link lengths in mm, instead of a file").Value("l1,l2,l3,l4,l5,l6");
  options.Add("d-min", o.d_min_mm, "Shortest stroke; 0: the design's, or 242").Unit("mm");
  options.Add("d-max", o.d_max_mm, "Longest stroke; 0: the design's, or where the knee is straight").Unit("mm");
  options.Check([&o](const OptionList&) {
    if (o.file.empty() == !o.links) throw UsageError("give either a design file or --links l1,l2,l3,l4,l5,l6");
    if (o.links) {
      o.design.links = linkage::Links::FromValues(*o.links);
      linkage::CheckLinks(o.design.links, "--links");
    }
    if (o.d_min_mm != 0) o.design.d_min_mm = o.d_min_mm;
    if (o.d_max_mm != 0) o.design.d_max_mm = o.d_max_mm;
    if (!(o.design.d_min_mm > 0 && std::isfinite(o.design.d_min_mm)))
      throw UsageError("--d-min must be above 0, not {}", o.design.d_min_mm);
  });
}

Json SimulateLinkage(const DesignSimulation& simulation, Run& run) {
  if (!simulation.file.empty()) run.AddInput(simulation.file, "design");
  if (!simulation.absent_load.empty() && !simulation.options.load.profile)
    run.Warn("{} was made for the load of {}, which is not there: no load is taken from it; give --profile",
             simulation.file.string(), simulation.absent_load.string());
  return SimulateLinkage(simulation.design, simulation.options, run);
}

}  // namespace lake::commands
