#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "lake/compare/comparison_file.h"
#include "lake/compare/pointwise_error.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

constexpr int kFormat = 1;  // of comparison.json; raised when a reader of the old one would go wrong

struct Figure {
  const char* name;
  double MisalignmentMetrics::*value;
};
constexpr Figure kFigures[] = {{"rms_mm", &MisalignmentMetrics::rms_mm},
                               {"mean_mm", &MisalignmentMetrics::mean_mm},
                               {"max_mm", &MisalignmentMetrics::max_mm},
                               {"p95_mm", &MisalignmentMetrics::p95_mm},
                               {"relative_rms", &MisalignmentMetrics::relative_rms},
                               {"relative_max", &MisalignmentMetrics::relative_max},
                               {"relative_p95", &MisalignmentMetrics::relative_p95},
                               {"relative_paper_rms", &MisalignmentMetrics::relative_paper_rms},
                               {"relative_paper_max", &MisalignmentMetrics::relative_paper_max},
                               {"closest_point_rms_mm", &MisalignmentMetrics::closest_point_rms_mm},
                               {"hausdorff_mm", &MisalignmentMetrics::hausdorff_mm},
                               {"frechet_mm", &MisalignmentMetrics::frechet_mm},
                               {"knee_rmse_deg", &MisalignmentMetrics::knee_rmse_deg},
                               {"cmc", &MisalignmentMetrics::cmc}};

void AddMetrics(const MisalignmentMetrics& metrics, const std::string& suffix, Json& json) {
  for (const Figure& figure : kFigures) json[figure.name + suffix] = metrics.*figure.value;
  json["linear_fit_slope" + suffix] = metrics.linear_fit.slope;
  json["linear_fit_intercept_deg" + suffix] = metrics.linear_fit.intercept;
  json["linear_fit_r2" + suffix] = metrics.linear_fit.r2;
}

Json IntervalJson(const Interval& interval) {
  return {interval.low, interval.high};
}

Json DecompositionJson(const Misalignment& m) {
  const Decomposition& d = m.decomposition;
  Json json = {{"offset_mm", {d.offset_mm.x(), d.offset_mm.y()}}};
  for (std::size_t k = 0; k < kParts.size(); ++k)
    json[kParts[k].name] = {{"fraction", NumberOrNull(d.*kParts[k].fraction)},
                            {"interval", m.part_intervals ? IntervalJson(m.part_intervals->fraction[k]) : Json()}};
  if (m.part_intervals)
    json["offset_interval_mm"] = {IntervalJson(m.part_intervals->offset_x_mm),
                                  IntervalJson(m.part_intervals->offset_y_mm)};
  json["timing_knots_percent"] = d.knots_percent;
  json["timing_rms_percent"] = RootMeanSquare(d.timing_percent);
  json["converged"] = d.converged;
  json["iterations"] = d.iterations;
  json["cost_mm2"] = d.cost;
  json["start"] = d.start;
  return json;
}

void AddVectors(const std::string& name, const std::vector<Vector2d>& vectors, Json& curves) {
  std::vector<double> x, y;
  for (const Vector2d& v : vectors) {
    x.push_back(v.x());
    y.push_back(v.y());
  }
  curves[name + "_x_mm"] = x;
  curves[name + "_y_mm"] = y;
}

Json CurvesJson(const Misalignment& m) {
  std::vector<double> percent, thigh_mm;
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    percent.push_back(static_cast<double>(i));
    thigh_mm.push_back((m.human.hip[i] - m.human.knee[i]).norm());
  }
  Json curves = {{"percent", percent}};
  AddVectors("human_ankle", m.human.ankle, curves);
  AddVectors("human_knee", m.human.knee, curves);
  AddVectors("human_hip", m.human.hip, curves);
  AddVectors("exo_ankle", m.exo.ankle, curves);
  AddVectors("exo_knee", m.exo.knee, curves);
  AddVectors("exo_hip", m.exo.hip, curves);
  AddVectors("exo_leg_knee", m.exo.leg_knee, curves);
  AddVectors("exo_slope", m.exo.slope, curves);  // mm/mm
  curves["shank_mm"] = m.shank_mm;
  curves["thigh_mm"] = thigh_mm;
  curves["human_knee_deg"] = m.human.knee_deg;
  curves["exo_knee_deg"] = m.exo.knee_deg;
  curves["human_knee_sigma_mm"] = m.human.knee_sigma_mm;
  curves["exo_knee_sigma_mm"] = m.exo.knee_sigma_mm;
  curves["distance_mm"] = m.distance_mm;
  curves["relative_error"] = m.misalignment_ratio;
  curves["relative_error_paper"] = m.misalignment_ratio_paper;
  curves["relative_error_sd"] = m.misalignment_ratio_sd;
  curves["spike"] = m.spike;
  curves["timing_percent"] = m.decomposition.timing_percent;
  for (const Part& part : kParts) AddVectors(part.name, m.decomposition.*part.vectors_mm, curves);
  return curves;
}

Json JointJson(const JointMisalignment& joint) {
  Json json = {{"rms_mm", joint.rms_mm},
               {"max_mm", joint.max_mm},
               {"relative_rms", joint.relative_rms},
               {"offset_mm", {joint.mean_mm.x(), joint.mean_mm.y()}},
               {"angle_rms_deg", joint.angle_rms_deg},
               {"repetitions", joint.repetitions}};
  if (joint.intervals) {
    json["rms_interval_mm"] = IntervalJson(joint.intervals->rms_mm);
    json["max_interval_mm"] = IntervalJson(joint.intervals->max_mm);
    json["offset_interval_mm"] = {IntervalJson(joint.intervals->mean_x_mm), IntervalJson(joint.intervals->mean_y_mm)};
    json["angle_rms_interval_deg"] = IntervalJson(joint.intervals->angle_rms_deg);
  }
  return json;
}

// The worn linkage moved to where its joint is nearest the knee, and what that leaves: of the joint against the knee
// beneath it, and of its path against the human trial's.
Json BestPlacementJson(const JointMisalignment& joint, const std::optional<JointMoved>& moved) {
  Json json = {{"move_mm", {-joint.mean_mm.x(), -joint.mean_mm.y()}}, {"rms_mm", joint.remainder_mm}};
  if (joint.intervals) json["rms_interval_mm"] = IntervalJson(joint.intervals->remainder_mm);
  if (!moved) return json;
  json["path_rms_mm"] = moved->rms_mm;
  json["path_relative_rms"] = moved->relative_rms;
  if (moved->intervals) {
    json["path_rms_interval_mm"] = IntervalJson(moved->intervals->rms_mm);
    json["path_relative_rms_interval"] = IntervalJson(moved->intervals->relative_rms);
  }
  return json;
}

// Null below four repetitions, of which the parts mean little.
Json PartsJson(const Misalignment& m) {
  if (std::min(m.human_repetitions, m.exo_repetitions) < kLeastRepetitionsOfParts) return nullptr;
  Json parts;
  for (std::size_t k = 0; k < kParts.size(); ++k)
    parts[kParts[k].name] = {{"rms_mm", std::sqrt(MeanSquare(m.decomposition.*kParts[k].vectors_mm))},
                             {"interval_mm", m.part_intervals ? IntervalJson(m.part_intervals->rms_mm[k]) : Json()}};
  return parts;
}

// Keys end in the unit: "s" or "deg".
Json DifferenceJson(const Difference& difference, const std::string& unit) {
  const auto interval = [](const std::optional<Interval>& of) { return of ? IntervalJson(*of) : Json(); };
  return {{"human_" + unit, difference.human},
          {"human_interval_" + unit, interval(difference.human_interval)},
          {"exo_" + unit, difference.exo},
          {"exo_interval_" + unit, interval(difference.exo_interval)},
          {"difference_" + unit, difference.Value()},
          {"difference_interval_" + unit, interval(difference.interval)}};
}

Json PaceJson(const Pace& pace, gait::MovementKind movement) {
  Json json = DifferenceJson(pace.repetition, "s");
  if (movement != gait::MovementKind::kSitToStand) return json;
  for (const auto& [name, phase] : {std::pair("onset_to_seat_off", &pace.onset_to_seat_off),
                                    std::pair("seat_off_to_standing", &pace.seat_off_to_standing)})
    json["phases"][name] = *phase ? DifferenceJson(**phase, "s") : Json();
  return json;
}

Json AngleJson(const AngleDifference& angle) {
  Json json = DifferenceJson(angle.mean_deg, "deg");
  json["rms_deg"] = angle.rms_deg;
  json["max_deg"] = angle.max_deg;
  return json;
}

Json PostureJson(const Posture& posture) {
  const auto angle = [](const std::optional<AngleDifference>& difference) {
    return difference ? AngleJson(*difference) : Json();
  };
  return {{"shank", angle(posture.shank)}, {"lean", angle(posture.trunk)}};
}

Json KneeAxisJson(const Misalignment& m) {
  const FixedPivot& pivot = m.best_pivot;
  return {{"gap_rms_mm", pivot.gap_rms_mm},
          {"gap_max_mm", pivot.gap_max_mm},
          {"gap_max_at_deg", pivot.most_gap_deg},
          {"pivot_in_femur_mm", {pivot.in_femur_mm.x(), pivot.in_femur_mm.y()}},
          {"pivot_in_tibia_mm", {pivot.in_tibia_mm.x(), pivot.in_tibia_mm.y()}}};
}

// Reads the curves of one comparison.json; every error names the file.
class ComparisonReader {
 public:
  explicit ComparisonReader(const std::filesystem::path& file) : file_(file.string()), json_(ReadJsonFile(file)) {}

  ComparedCurves Read() {
    CheckFormat();
    const std::vector<double> percent = Curve("percent");
    for (std::size_t i = 0; i < percent.size(); ++i)
      if (percent[i] != static_cast<double>(i)) throw Fail("{}: curves.percent does not run from 0 to 100", file_);
    ComparedCurves curves{Leg("human"), Leg("exo"), Spikes()};
    if (!Entry("exo_leg_knee_x_mm").empty()) curves.exo.leg_knee = Path("exo_leg_knee");
    if (const auto plane = gait::PlaneSightIn(json_, file_)) {
      curves.exo.slope = Path("exo_slope");
      curves.exo_sight = {*plane, gait::DepthOf(*plane, json_.at("markers").at("exo").get<std::string>())};
    }
    curves.noise_floor_mm = NoiseFloor("noise_floor_mm");
    curves.noise_floor_relative = NoiseFloor("noise_floor_relative");
    const Json uncertainty = json_.value("uncertainty", Json::object());
    for (const char* offset : {"joint_offset_x_mm", "joint_offset_y_mm"})
      if (const Json of = uncertainty.value(offset, Json::object()); of.contains("anatomical_sd"))
        curves.joint_sd_mm = LargerOrNaN(curves.joint_sd_mm.value_or(0), NumberOrNaN(of["anatomical_sd"]));
    curves.movement = Movement();
    curves.knee_is_functional = json_.value("knee_from", Json()) == "functional";
    if (json_.contains("knee_axis_sd_mm")) curves.axes = {AxisSd("human"), AxisSd("exo")};
    CheckShank(curves.human);
    return curves;
  }

 private:
  void CheckFormat() const {
    if (!json_.is_object() || !json_.contains("metrics"))
      throw Fail("{}: not a comparison: lake-compare writes such a file", file_);
    const Json format = json_.value("format", Json());
    const double number = format.is_number_integer() ? format.get<double>() : 0;
    if (number < kFormat)
      throw Fail("{}: made by an older version of lake-compare (format {}, needed {}): run lake-compare again", file_,
                 format.is_null() ? "none" : format.dump(), kFormat);
    if (number > kFormat)
      throw Fail("{}: made by a newer version of lake-compare (format {}, known {}): use that version here too", file_,
                 number, kFormat);
  }

  gait::MovementKind Movement() const {
    const Json name = json_.value("movement", Json("sit-to-stand"));
    const auto movements = gait::Movements();
    const auto found =
        std::ranges::find_if(movements, [&](const gait::Movement& movement) { return name == movement.name; });
    if (found == movements.end()) throw Fail("{}: movement {} is not known", file_, name.dump());
    return found->kind;
  }

  const Json& Entry(const std::string& name) const {
    if (!json_.contains("curves") || !json_["curves"].is_object() || !json_["curves"].contains(name))
      throw Fail("{}: the curve '{}' is missing: give the folder that lake-compare wrote, or run it again", file_,
                 name);
    return json_["curves"][name];
  }

  double NoiseFloor(const char* name) const {
    const double floor = Number(json_, name, name);
    if (!(floor >= 0)) throw Fail("{}: {} = {} is below 0: run lake-compare again", file_, name, floor);
    return floor;
  }

  std::optional<double> AxisSd(const char* trial) const {
    const Json sds = json_.value("knee_axis_sd_mm", Json());
    if (!sds.is_object() || sds.value(trial, Json()).is_null()) return std::nullopt;
    const std::string name = fmt::format("knee_axis_sd_mm.{}", trial);
    const double sd_mm = Number(sds, trial, name);
    if (!(sd_mm >= 0)) throw Fail("{}: {} = {} is below 0: run lake-compare again", file_, name, sd_mm);
    return sd_mm;
  }

  double Duration(const std::string& who) const {
    const std::string name = "duration_s." + who;
    const double duration = Number(json_.value("duration_s", Json()), who, name);
    if (!(duration > 0)) throw Fail("{}: {} = {} is not above 0: run lake-compare again", file_, name, duration);
    return duration;
  }

  double Number(const Json& map, const std::string& key, const std::string& name) const {
    const Json number = map.is_object() ? map.value(key, Json()) : Json();
    if (!number.is_number()) throw Fail("{}: {} is missing: run lake-compare again", file_, name);
    return number.get<double>();
  }

  const Json& List(const std::string& name) const {
    const Json& curve = Entry(name);
    if (!curve.is_array() || curve.size() != kPercentSamples)
      throw Fail("{}: curves.{} must be a list of {} numbers", file_, name, kPercentSamples);
    return curve;
  }

  std::vector<bool> Spikes() const {
    std::vector<bool> spikes;
    for (const Json& spike : List("spike")) {
      if (!spike.is_boolean())
        throw Fail("{}: curves.spike[{}] = {} is neither true nor false", file_, spikes.size(), spike.dump());
      spikes.push_back(spike.get<bool>());
    }
    return spikes;
  }

  std::vector<double> Curve(const std::string& name) const {
    const Json& curve = List(name);
    std::vector<double> values;
    for (const Json& value : curve) {
      if (!value.is_number() || !std::isfinite(value.get<double>()))
        throw Fail("{}: curves.{}[{}] = {} is not a number", file_, name, values.size(), value.dump());
      values.push_back(value.get<double>());
    }
    return values;
  }

  std::vector<Vector2d> Path(const std::string& name) const {
    const std::vector<double> x = Curve(name + "_x_mm"), y = Curve(name + "_y_mm");
    std::vector<Vector2d> path;
    for (std::size_t i = 0; i < x.size(); ++i) path.emplace_back(x[i], y[i]);
    return path;
  }

  StsCurve Leg(const std::string& who) const {
    StsCurve curve;
    curve.ankle = Path(who + "_ankle");
    curve.knee = Path(who + "_knee");
    curve.hip = Path(who + "_hip");
    curve.knee_deg = Curve(who + "_knee_deg");
    curve.knee_sigma_mm = Curve(who + "_knee_sigma_mm");
    curve.duration_s = Duration(who);
    return curve;
  }

  void CheckShank(const StsCurve& human) const {
    constexpr double kRounding = 1e-6;
    const std::vector<double> written = Curve("shank_mm"), found = ShankLengths(human);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!(found[i] > 0 && std::abs(found[i] - written[i]) <= kRounding * found[i]))
        throw Fail("{}: curves.shank_mm[{}] = {} contradicts the ankle and the knee, {} mm apart", file_, i, written[i],
                   found[i]);
  }

  const std::string file_;
  const Json json_;
};

}  // namespace

ComparedCurves ReadComparison(const std::filesystem::path& path) {
  const bool is_folder = std::filesystem::is_directory(path);
  const std::filesystem::path file = is_folder ? path / "comparison.json" : path, summary = path / "summary.json";
  if (is_folder && !std::filesystem::exists(file) && std::filesystem::exists(summary))
    throw Fail("{}: a folder of {}, and a comparison is needed: lake compare writes one from two trials", path.string(),
               ReadJsonFile(summary).value("program", "another program"));
  if (!std::filesystem::is_regular_file(file))
    throw Fail("{}: not there; a comparison is the folder that lake-compare wrote", file.string());
  return ComparisonReader(file).Read();
}

ComparedCurves ReadComparisonOfRises(const std::filesystem::path& path) {
  ComparedCurves curves = ReadComparison(path);
  if (curves.movement != gait::MovementKind::kSitToStand)
    throw Fail("{}: it is of {}, and a linkage is designed for sit-to-stands", path.string(),
               gait::MovementOf(curves.movement).name);
  return curves;
}

Json ComparisonJson(const Misalignment& m) {
  Json json = {{"format", kFormat}};
  AddMetrics(m.metrics, "", json["metrics"]);
  AddMetrics(m.metrics_without_spikes, "_without_spikes", json["metrics"]);
  if (m.intervals)
    json["intervals"] = {{"rms_mm", IntervalJson(m.intervals->rms_mm)},
                         {"max_mm", IntervalJson(m.intervals->max_mm)},
                         {"relative_rms", IntervalJson(m.intervals->relative_rms)},
                         {"relative_max", IntervalJson(m.intervals->relative_max)},
                         {"knee_rmse_deg", IntervalJson(m.intervals->knee_rmse_deg)}};
  json["movement"] = gait::MovementOf(m.movement).name;
  json["human_angle_strays_deg"] = ValueOrNull(m.human_angle_strays_deg);
  json["noise_floor_mm"] = m.noise_floor_mm;
  json["noise_floor_relative"] = m.noise_floor_relative;
  json["spikes"] = kPercentSamples - m.metrics_without_spikes.samples;
  json["decomposition"] = DecompositionJson(m);
  json["joint"] = m.joint ? JointJson(*m.joint) : Json();
  json["best_placement"] = m.joint ? BestPlacementJson(*m.joint, m.joint_moved) : Json();
  json["parts_mm"] = PartsJson(m);
  json["pace"] = PaceJson(m.pace, m.movement);
  json["posture"] = PostureJson(m.posture);
  json["knee_axis"] = KneeAxisJson(m);
  json["shank_mm"] = Mean(m.shank_mm);
  json["repetitions"] = {{"human", m.human_repetitions}, {"exo", m.exo_repetitions}};
  json["duration_s"] = {{"human", m.human.duration_s}, {"exo", m.exo.duration_s}};
  json["curves"] = CurvesJson(m);
  return json;
}

void WriteMisalignmentCsv(const std::filesystem::path& path, const Misalignment& m) {
  CsvWriter csv({"percent", "human_x_mm", "human_y_mm", "exo_x_mm", "exo_y_mm", "dx_mm", "dy_mm", "distance_mm",
                 "relative_error", "relative_error_paper", "human_knee_deg", "exo_knee_deg", "spike", "joint_x_mm",
                 "joint_y_mm", "joint_mm", "joint_thigh_x_mm", "joint_thigh_y_mm"});
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    const Vector2d& h = m.human.knee[i];
    const Vector2d& e = m.exo.knee[i];
    const Vector2d unknown = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    const Vector2d shank = m.joint ? m.joint->shank_mm[i] : unknown, thigh = m.joint ? m.joint->thigh_mm[i] : unknown;
    csv.AddRow(i, h.x(), h.y(), e.x(), e.y(), e.x() - h.x(), e.y() - h.y(), m.distance_mm[i], m.misalignment_ratio[i],
               m.misalignment_ratio_paper[i], m.human.knee_deg[i], m.exo.knee_deg[i], bool{m.spike[i]}, shank.x(),
               shank.y(), shank.norm(), thigh.x(), thigh.y());
  }
  csv.Write(path);
}

}  // namespace lake::compare
