#include "lake/report/misalignment_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/compare/knee_axis.h"
#include "lake/compare/misalignment.h"
#include "lake/core/counted.h"
#include "lake/core/json.h"
#include "lake/report/uncertain.h"

namespace lake::report {

namespace {

constexpr const char* kNoKnee = "the trial does not show the knee; two markers on the shank would replace it";

// A key figure rounded to its interval, which stands below it with what it includes.
KeyFigure FigureOf(const char* label, const Uncertain& of, int otherwise, const char* unit, const char* includes = "") {
  KeyFigure figure{.label = label, .value = of.value, .decimals = of.Decimals(otherwise), .unit = unit};
  if (of.IsKnown()) figure.note = fmt::format("95 %{}: {} {}", includes, of.IntervalText(otherwise), unit);
  return figure;
}

// What moving the joint leaves and why its paths still differ, and what seat and limbs allow of it; empty where the
// trial shows no knee beside the joint.
std::string MovedText(const Json& comparison) {
  const Uncertain path = FactOf(comparison, kPathMoved);
  if (Find(comparison, kPathMoved.value).is_null()) return "";
  std::string text = fmt::format(
      "With the joint moved onto the knee {} % of path difference would be left{}: that of the knees of both trials at "
      "equal percent, as the two differ in pace and posture.",
      path.Text(), path.IsKnown() ? fmt::format(" (95 %: {} %)", path.IntervalText()) : "");
  if (const Json body = Find(comparison, "best_placement/body_text"); body.is_string())
    text += " " + body.get<std::string>();
  return text;
}

Section KeySection(const Json& comparison) {
  const Json& repetitions = comparison.at("repetitions");
  const Json& duration = comparison.at("duration_s");
  Section section{"The misalignment", {MisalignmentKeyFigures(comparison)}};
  section.blocks.push_back(Paragraph{fmt::format(
      "We compare the means of {} of the human trial ({:.1f} s {}) and {} of the "
      "exoskeleton trial ({:.1f} s). The shank is {:.0f} mm long. Recording noise and marker re-placement alone "
      "would show {} mm RMS, or {} % of the shank length.",
      Counted(repetitions.at("human").get<int>(), "repetition"), NumberAt(duration, "human"),
      IsOfWalking(comparison) ? "a stride" : "from onset to standing", repetitions.at("exo").get<int>(),
      NumberAt(duration, "exo"), NumberAt(comparison, "shank_mm"),
      SignificantText(NumberAt(comparison, "noise_floor_mm"), 2),
      SignificantText(100 * NumberAt(comparison, "noise_floor_relative"), 2))});
  if (std::string moved = MovedText(comparison); !moved.empty()) section.blocks.push_back(Paragraph{std::move(moved)});
  return section;
}

Section PathsSection(const Json& comparison) {
  LineChart paths = KneePathsChart(comparison), angles = KneeAnglesChart(comparison);
  paths.width = angles.width = Width::kHalf;
  Section section{"Knee paths and angles", {std::move(paths), std::move(angles)}};
  if (auto joint = JointChart(comparison)) section.blocks.emplace_back(*std::move(joint));
  section.blocks.emplace_back(PathDifferenceChart(comparison));
  return section;
}

Section PartsSection(const Json& comparison) {
  BarChart shares = DecompositionChart(comparison);
  LineChart parts = PartsChart(comparison);
  shares.width = parts.width = Width::kHalf;
  std::string what;
  for (const compare::Part& part : compare::kParts)
    what += fmt::format("{}{} is {}", what.empty() ? "" : "; ", part.name, part.meaning);
  return {"Parts of the path difference",
          {Paragraph{DecompositionAdvice(comparison)}, std::move(shares), std::move(parts),
           Paragraph{fmt::format("The parts: {}.", what)}}};
}

struct MetricRow {
  const char* name;
  const char* what;
  double factor;
};
constexpr MetricRow kMetricRows[] = {
    {"relative_rms", "path difference, RMS (% of the shank length)", 100},
    {"relative_max", "path difference, largest (% of the shank length)", 100},
    {"relative_p95", "path difference, 95th percentile (% of the shank length)", 100},
    {"rms_mm", "path difference, RMS (mm)", 1},
    {"mean_mm", "path difference, mean (mm)", 1},
    {"max_mm", "path difference, largest (mm)", 1},
    {"p95_mm", "path difference, 95th percentile (mm)", 1},
    {"closest_point_rms_mm", "to the closest point of the human path, RMS (mm)", 1},
    {"hausdorff_mm", "Hausdorff distance of the paths (mm)", 1},
    {"frechet_mm", "discrete Fréchet distance of the paths (mm)", 1},
    {"knee_rmse_deg", "knee angles, RMS difference (°)", 1},
    {"cmc", "knee angles, coefficient of multiple correlation", 1},
    {"linear_fit_slope", "knee angles, linear fit: slope", 1},
    {"linear_fit_intercept_deg", "knee angles, linear fit: intercept (°)", 1},
    {"linear_fit_r2", "knee angles, linear fit: R²", 1},
    {"relative_paper_rms", "|Δy| / |y| as the paper plots it, RMS (%)", 100},
    {"relative_paper_max", "|Δy| / |y| as the paper plots it, largest (%)", 100},
};

Section MetricsSection(const Json& comparison) {
  const Json& metrics = comparison.at("metrics");
  const int spikes = comparison.at("spikes").get<int>();
  Table table{fmt::format("All figures; {} of 101 samples {} marked as {}", spikes, spikes == 1 ? "is" : "are",
                          spikes == 1 ? "a spike" : "spikes"),
              {{"Figure"}, {"All samples", 3}, {"Without spikes", 3}},
              {}};
  for (const MetricRow& row : kMetricRows)
    table.rows.push_back({row.what, row.factor * NumberAt(metrics, row.name),
                          row.factor * NumberAt(metrics, std::string(row.name) + "_without_spikes")});
  return {"Figures", {std::move(table)}};
}

// What the exoskeleton does to its person's movement, which the path difference holds as well.
Section PaceAndPostureSection(const Json& comparison) {
  Table table{"Means of both trials; the interval (95 %) needs two repetitions of each",
              {{"Quantity"}, {"Unit"}, {"Human", 2}, {"Exoskeleton", 2}, {"Difference", 2}, {"Interval"}},
              {}};
  const auto add = [&](const char* what, const Json& difference, const std::string& unit) {
    if (difference.is_null()) return;
    const Json interval = Find(difference, "difference_interval_" + unit);
    table.rows.push_back({what, unit == "deg" ? "°" : unit, NumberAt(difference, "human_" + unit),
                          NumberAt(difference, "exo_" + unit), NumberAt(difference, "difference_" + unit),
                          interval.is_null() ? ""
                                             : fmt::format("95 %: {} to {} ", NumberText(NumberOrNaN(interval[0]), 2),
                                                           NumberText(NumberOrNaN(interval[1]), 2))});
  };
  const Json &pace = comparison.at("pace"), &posture = comparison.at("posture");
  if (IsOfWalking(comparison)) {
    add("stride, heel strike to heel strike", pace, "s");
  } else {
    add("rise, onset to standing", pace, "s");
    add("onset to seat-off", pace.at("phases").at("onset_to_seat_off"), "s");
    add("seat-off to standing", pace.at("phases").at("seat_off_to_standing"), "s");
  }
  add("shank's forward lean, mean", posture.at("shank"), "deg");
  add("trunk's forward lean, mean", posture.at("lean"), "deg");
  return {"Pace and posture", {std::move(table)}};
}

Section KneeAxisSection(const Json& comparison) {
  const Json& axis = comparison.at("knee_axis");
  const std::vector<double> angles = [&] {
    std::vector<double> deg;
    for (const double angle : NumbersOrNaN(comparison.at("curves").at("human_knee_deg")))
      if (std::isfinite(angle)) deg.push_back(angle);
    return deg;
  }();
  const auto [low, high] = std::minmax_element(angles.begin(), angles.end());
  std::string text = "The human knee rolls and slides, so no hinge follows it exactly. ";
  text += fmt::format(
      "In the knee model of Yamaguchi and Zajac the best hinge for this subject's {} to {}° leaves a gap of {:.2f} mm "
      "RMS and {:.2f} mm at most (at {:.0f}°). A hinge beside the best one by δ adds 2 δ sin(θ/2): 10 mm add {:.1f} mm "
      "at 90°. Where the joint sits matters, the moving axis hardly does.",
      NumberText(*low, 0), NumberText(*high, 0), NumberAt(axis, "gap_rms_mm"), NumberAt(axis, "gap_max_mm"),
      NumberAt(axis, "gap_max_at_deg"), compare::OffsetGap(10, 90));
  return {"The knee's moving axis", {Paragraph{std::move(text)}}};
}

// Where the joint sits: on the exo trial's own leg if it is shown, else the fitted offset with its own interval.
Uncertain OffsetOf(const Json& comparison, std::size_t axis) {
  constexpr Fact kWorn[] = {{"", "mm", "joint/offset_mm/0", "uncertainty/joint_offset_x_mm/anatomical_interval"},
                            {"", "mm", "joint/offset_mm/1", "uncertainty/joint_offset_y_mm/anatomical_interval"}};
  constexpr Fact kFitted[] = {{"", "mm", "decomposition/offset_mm/0", "decomposition/offset_interval_mm/0"},
                              {"", "mm", "decomposition/offset_mm/1", "decomposition/offset_interval_mm/1"}};
  return FactOf(comparison, (Find(comparison, "joint").is_null() ? kFitted : kWorn)[axis]);
}

// What the part is for the designer.
std::string PartAdvice(const std::string& part, const Json& comparison) {
  const Json& parts = comparison.at("decomposition");
  if (part == "timing")
    return fmt::format(
        "timing: the exoskeleton runs at another pace within the {} ({:.1f} % RMS){}", RepetitionIn(comparison),
        NumberAt(parts, "timing_rms_percent"),
        IsOfWalking(comparison) ? "" : ", which the stroke program and the linkage's angle over stroke decide");
  if (part == "shape")
    return "shape: neither moving the joint nor another pace removes it. Soft tissue, straps that slip, a movement out "
           "of the plane or a different movement of the leg remain";
  return fmt::format("placement: the joint sits {}. Moving the joint onto the knee removes this part",
                     JointPlaceText(comparison));
}

// Whether its interval lies above those of the other parts.
bool IsLargestForSure(const std::string& part, const Json& parts) {
  const Json& interval = parts.at(part).at("interval");
  return std::ranges::all_of(compare::kParts, [&](const compare::Part& other) {
    return other.name == part || NumberOrNaN(parts.at(other.name).at("interval").at(1)) < NumberOrNaN(interval.at(0));
  });
}

Section MethodSection(const Json& comparison) {
  const std::string repetition =
      IsOfWalking(comparison)
          ? "Each stride runs from 0 % (heel strike) to 100 % (the next heel strike of the same leg) and is sampled at "
            "every percent relative to the hip, x in the direction of walking. "
          : "Each repetition runs from 0 % (onset: hip or trunk leaves rest) to 100 % (standing: the knee's "
            "extension speed falls below 5 % of its peak) and is sampled at every percent in the leg frame. ";
  return {"Method",
          {Paragraph{
              "The joint misalignment is the distance between the exoskeleton's joint and the knee of the leg that "
              "wears it, at the same instants; neither pace nor posture is in it. The path difference is that between "
              "the two trials at equal percent, in which they are. " +
              repetition +
              "The path difference is the distance between the knees, also divided by the human's distance from ankle "
              "to knee at the same sample; its RMS is the root of the mean square. Placement, timing and shape are "
              "fitted together: an offset constant in the shank's frame, a monotone piecewise linear registration of "
              "time with 9 knots, and the rest; a share is the part's projection on the distance vector over its mean "
              "square, so the shares add up to 100 % and a small one can be negative. Spikes are samples at which the "
              "distance vector leaves its own smooth course by more than 5 median absolute deviations. Intervals hold "
              "95 %. That of the joint misalignment is by the jackknife over the repetitions, from two on; of the path "
              "difference also by how people vary from repetition to repetition, where repetitions are few, by the "
              "events' times, marker noise and marker re-placement; of its parts from four repetitions in each trial "
              "on."}}};
}

}  // namespace

std::string JointPlaceText(const Json& comparison) {
  const Uncertain x = OffsetOf(comparison, 0), y = OffsetOf(comparison, 1);
  return compare::DescribeJoint({x.value, y.value}, {x.HalfWidth(), y.HalfWidth()});
}

Uncertain JointMovedFigure(const Json& comparison) {
  constexpr double kLeastHalfWidth_mm = 0.05;
  Uncertain left = FactOf(comparison, kJointMoved);
  if (!left.IsKnown()) return left;
  left.low = std::min(left.low, left.value - kLeastHalfWidth_mm);
  left.high = std::max(left.high, left.value + kLeastHalfWidth_mm);
  return left;
}

KeyFigures MisalignmentKeyFigures(const Json& comparison) {
  const Json& parts = comparison.at("decomposition");
  const bool has_knee = Find(comparison, "joint").is_object();
  KeyFigures all;
  for (const Fact* fact :
       {&kJointRms, &kJointMax, &kJointMoved, &kPathMoved, &kPathPercent, &kPathMaxPercent, &kPathMm, &kPathMaxMm}) {
    const Uncertain of = fact == &kJointMoved ? JointMovedFigure(comparison) : FactOf(comparison, *fact);
    all.figures.push_back(FigureOf(fact->label, of, 1, fact->unit, fact->includes));
    const std::string_view from = fact->value;
    if (!has_knee && (from.starts_with("joint") || from.starts_with("best"))) all.figures.back().note = kNoKnee;
  }
  for (const compare::Part& part : compare::kParts) {
    const Json interval = Find(parts, part.name + std::string("/interval"));
    const Uncertain share = UncertainOf(parts.at(part.name).at("fraction"), interval, 100);
    all.figures.push_back(FigureOf(part.name, share, 1, "%"));
    if (interval.is_null() && std::isfinite(share.value))
      all.figures.back().note = "too few repetitions for an interval";
  }
  const char* of_place = has_knee ? kOfAllSources : kOfMarkers;
  all.figures.insert(all.figures.end(),
                     {FigureOf("joint in front of the knee", OffsetOf(comparison, 0), 0, "mm", of_place),
                      FigureOf("joint above the knee, along the shank", OffsetOf(comparison, 1), 0, "mm", of_place),
                      {.label = "difference in pace, RMS",
                       .value = NumberAt(parts, "timing_rms_percent"),
                       .unit = "% of the " + RepetitionIn(comparison)}});
  return all;
}

std::string DecompositionAdvice(const Json& comparison) {
  const Json& parts = comparison.at("decomposition");
  const auto fraction = [&](const std::string& name) { return NumberOrNaN(parts.at(name).at("fraction")); };
  if (std::isnan(fraction("placement"))) return "Both paths are one; there is nothing to divide.";
  const std::string largest = std::ranges::max_element(compare::kParts, {}, [&](const compare::Part& part) {
                                return fraction(part.name);
                              })->name;
  const Json& share = parts.at(largest);
  static_assert(compare::kLeastRepetitionsOfParts == 4);
  if (share.at("interval").is_null())
    return fmt::format(
        "{}How much of it is {} cannot be said: a person's own pace differs as much from one "
        "{} to the next, and it takes four repetitions in each trial to tell.",
        comparison.value("joint", Json()).is_null() ? ""
                                                    : fmt::format("The joint sits {}. ", JointPlaceText(comparison)),
        compare::PartNames(), RepetitionIn(comparison));
  return fmt::format("Most of it, {} %, is {}.{}",
                     UncertainOf(share.at("fraction"), share.value("interval", Json()), 100).Text(1),
                     PartAdvice(largest, comparison),
                     IsLargestForSure(largest, parts) ? ""
                                                      : " But the intervals of the parts overlap: another part may be "
                                                        "the largest, which more repetitions would show.");
}

std::vector<Section> MisalignmentSections(const Json& comparison) {
  return {KeySection(comparison),     PathsSection(comparison),
          PartsSection(comparison),   PaceAndPostureSection(comparison),
          MetricsSection(comparison), KneeAxisSection(comparison),
          MethodSection(comparison)};
}

}  // namespace lake::report
