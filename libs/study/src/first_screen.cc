#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "lake/core/colours.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/linkage/design_file.h"
#include "lake/report/misalignment_sections.h"
#include "step_work.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

// A joint that is put where it was found to be misplaced sits within `half_width` (95 %, each axis) of where it should
// be, so that the mean square of what is left grows by the square of that distance: 7.378 SD² at 97.5 %, the quantile
// of chi squared with two degrees of freedom.
Uncertain PutInPlace(double percent, const Vector2d& half_width_mm, double shank_mm) {
  constexpr double kChiSquared = 7.377759;
  const double sd_mm = half_width_mm.norm() / std::sqrt(2.0) / kNormal95;
  return {percent, percent, std::hypot(percent, 100 * std::sqrt(kChiSquared) * sd_mm / shank_mm),
          kPathDifferenceDecimals};
}

Uncertain PredictedPercent(const StudyResults& results, const Json& design) {
  const double percent = NumberAt(design, "misalignment_percent");
  if (!results.Has("comparison")) return {.value = percent, .least_decimals = kPathDifferenceDecimals};
  return PutInPlace(percent, PlacementHalfWidth(results), NumberAt(results.Summary("comparison"), "shank_mm"));
}

// "20 mm back, 30 mm lower"; nothing along an axis on which the way is less than what is known of it.
std::string MoveOf(const Json& from, const Json& to, const Vector2d& half_width_mm) {
  std::vector<std::string> moves;
  const auto add = [&](const char* key, double half_width, const char* less, const char* more) {
    const double way = NumberAt(to, key) - NumberAt(from, key);
    if (std::isfinite(half_width) ? std::abs(way) > half_width : std::abs(way) >= 1)
      moves.push_back(fmt::format("{} mm {}", KnownText(std::abs(way), half_width, 0), way < 0 ? less : more));
  };
  add("placement_x_mm", half_width_mm.x(), "back", "forward");
  add("placement_y_mm", half_width_mm.y(), "lower", "higher");
  return fmt::format("{}", fmt::join(moves, ", "));
}

bool IsReached(double value, double limit) {
  constexpr double kNear = 1e-3;
  return std::isfinite(limit) && std::abs(value / limit - 1) < kNear;
}

// On the body that the new design was simulated on, with the same parts.
std::optional<linkage::WearCheck> WornOnBody(const StudyFile& study, const StudyResults& results,
                                             std::array<double, 2> placement_mm) {
  if (!study.worn || !results.Has("simulation")) return std::nullopt;
  const Json body = results.Summary("simulation").at("mannequin");
  const person::Body person =
      person::BodyOf({.height_mm = NumberAt(body, "height_mm"),
                      .mass_kg = NumberAt(body, "mass_kg"),
                      .leg = person::LegLengths{NumberAt(body, "thigh_mm"), NumberAt(body, "shank_mm")}});
  const linkage::Design worn = linkage::ReadDesign(*study.worn);
  const commands::SimulationOptions simulation = SimulationOf(study);
  const parts::PartOptions& parts = simulation.parts;
  return linkage::CheckWear(worn.links, linkage::FindUsedRange(worn.links, worn.d_min_mm, worn.d_max_mm), person,
                            {parts.bar_width_mm, parts.actuator_diameter_mm, simulation.seat_edge_mm, placement_mm,
                             worn.mount, simulation.has_wide_seat});
}

std::array<double, 2> PlacementOf(const Json& design) {
  return {NumberAt(design, "placement_x_mm"), NumberAt(design, "placement_y_mm")};
}

// What the simulation found of the new design.
linkage::WearCheck SimulatedOnBody(const Json& body) {
  linkage::WearCheck check;
  check.mount_below_hip_mm = NumberAt(body, "mount_below_hip_mm");
  check.seat_clearance_mm = NumberAt(body, "seat_clearance_mm");
  check.thigh_clearance_mm = NumberAt(body, "actuator_to_thigh_mm");
  check.shank_clearance_mm = NumberAt(body, "actuator_to_shank_mm");
  return check;
}

Way AsWorn(const StudyFile& study, const StudyResults& results, const Json& redesign) {
  Way way{.name = "as worn",
          .design = "before",
          .misalignment_percent = FactOf(results.Summary("comparison"), kPathPercent),
          .rise_s = RecordedRise(results),
          .build = "–"};
  if (study.worn) way.on_body = WornOnBody(study, results, PlacementOf(redesign.at("before")));
  return way;
}

// As the comparison has it, whose interval holds how rises differ; where its trial shows no knee, as predicted.
Uncertain MovedPercent(const StudyResults& results, const Json& moved) {
  Uncertain of = FactOf(results.Summary("comparison"), kPathMoved);
  if (!std::isfinite(of.low)) return PredictedPercent(results, moved);
  of.value = NumberAt(moved, "misalignment_percent");
  return of;
}

Way JointMoved(const StudyFile& study, const StudyResults& results, const Json& redesign) {
  const Json& moved = redesign.at("joint_moved");
  const std::string move = MoveOf(redesign.at("before"), moved, PlacementHalfWidth(results));
  const bool has_program = study.worn && linkage::ReadDesign(*study.worn).program;
  return {.name = "same links, joint moved",
          .design = "joint_moved",
          .misalignment_percent = MovedPercent(results, moved),
          .rise_s = has_program ? Uncertain{.value = NumberAt(moved, "program_duration_s")} : RecordedRise(results),
          .build = move.empty() ? "–" : "mount " + move,
          .time_is_set = has_program,
          .mends_joint = !move.empty(),
          .on_body = WornOnBody(study, results, PlacementOf(moved))};
}

Way NewLinks(const StudyResults& results, const Json& redesign) {
  const Json& after = redesign.at("after");
  return {.name = "new links",
          .design = "after",
          .misalignment_percent = PredictedPercent(results, after),
          .rise_s = {.value = NumberAt(after, "program_duration_s")},
          .build = "links, mount, program",
          .misalignment_is_limit =
              IsReached(NumberAt(after, "misalignment_percent"), NumberAt(redesign, "max_misalignment_percent")),
          .time_is_limit =
              RepetitionIn(results) == "rise" &&
              IsReached(NumberAt(after, "program_duration_s"), NumberAt(redesign, "stroke_program/duration_limit_s")),
          .time_is_set = true,
          .on_body = SimulatedOnBody(results.Summary("simulation").at("mannequin"))};
}

// What a free program of another time would leave at best: "20 s: 7.3 %"; empty where there is no front.
std::string OtherTime(const Json& redesign) {
  const double own_s = NumberAt(redesign, "stroke_program/duration_limit_s");
  for (const Json& front : redesign.value("pareto", Json::array())) {
    double limit_s = 0;
    const std::string program = front.at("program");
    const Json& points = front.at("range_deg_and_misalignment_percent");
    const bool is_other = std::sscanf(program.c_str(), "free %lf s", &limit_s) == 1 && !IsReached(limit_s, own_s);
    if (is_other && !points.empty())  // by misalignment
      return fmt::format("{} s: {} %", SignificantText(limit_s, 4), NumberText(NumberOrNaN(points.front().at(1)), 1));
  }
  return "";
}

// A limit of the redesign that was asked for, and what the worn and the new links have of it.
struct Asked {
  std::string name, unit;
  double worn = 0, built = 0, least = 0, most = 0;  // NaN: no such limit

  bool IsKeptByWorn() const { return !(worn < least || worn > most); }
};

// Of the links, wherever their joint is; none where it is not known which were worn.
std::vector<Asked> AskedOfLinks(const StudyFile& study, const StudyResults& results) {
  if (!study.worn) return {};
  const CsvTable table = CsvTable::Read(results.Folder() / "redesign/constraints.csv");
  const auto number = [&](std::size_t row, const char* column) {
    return table.Number(row, table.Column(column)).value_or(std::nan(""));
  };
  std::vector<Asked> asked;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const std::string &name = table.Text(row, table.Column("constraint")),
                      &unit = table.Text(row, table.Column("unit"));
    if (unit != "%" && !name.starts_with("balance"))
      asked.push_back(
          {name, unit, number(row, "initial"), number(row, "optimum"), number(row, "lower"), number(row, "upper")});
  }
  return asked;
}

// As people say it.
std::string WordsOf(const Asked& limit) {
  return limit.name == "force"         ? "actuator force"
         : limit.name == "grashof"     ? "Grashof margin"
         : limit.name == "singularity" ? "distance from a singularity"
                                       : limit.name;
}

// Of each limit that the worn links do not keep.
template <typename Text>
std::string WornFaults(const std::vector<Asked>& asked, const Text& text) {
  std::vector<std::string> faults;
  for (const Asked& limit : asked)
    if (!limit.IsKeptByWorn()) faults.push_back(text(limit));
  return fmt::format("{}", fmt::join(faults, ", "));
}

Table WaysTable(const std::vector<Way>& ways, const std::vector<Asked>& asked, const Json& redesign,
                const std::string& repetition) {
  const auto force = std::ranges::find(asked, "force", &Asked::name);
  Table table{"",
              {{"Way"},
               {"Path difference"},
               {(repetition == "rise" ? "Rise" : "Stride") + std::string(" time")},
               {"Actuator force (N)", 0},
               {"To build"}}};
  for (const Way& way : ways) {
    std::string misalignment = UncertainText(way.misalignment_percent, " %"),
                time = UncertainText(way.rise_s, " s", way.rise_s.value < 10 ? 1 : 0);
    if (way.misalignment_is_limit) misalignment += ", limit you set";
    if (way.time_is_limit) {
      const std::string other = OtherTime(redesign);
      time += ", limit you set" + (other.empty() ? "" : fmt::format(" ({})", other));
    } else if (way.time_is_set) {
      time += ", programmed";
    }
    const double force_n = force == asked.end() ? std::nan("") : &way == &ways.back() ? force->built : force->worn;
    table.rows.push_back({way.name, std::move(misalignment), std::move(time), force_n, way.build});
  }
  return table;
}

// Where the joint sits, as far as that is known: "in front of and above"; empty where it may be on the knee.
std::string SideOf(const StudyResults& results) {
  const Json comparison = results.Summary("comparison"), joint = Find(comparison, "joint");
  const Json offset = (joint.is_null() ? comparison.at("decomposition") : joint).at("offset_mm");
  const Vector2d half_width = PlacementHalfWidth(results);
  std::vector<std::string> sides;
  const auto add = [&](double mm, double known, const char* less, const char* more) {
    if (std::abs(mm) > (std::isfinite(known) ? known : 0)) sides.emplace_back(mm < 0 ? less : more);
  };
  add(NumberOrNaN(offset.at(0)), half_width.x(), "behind", "in front of");
  add(NumberOrNaN(offset.at(1)), half_width.y(), "below", "above");
  return fmt::format("{}", fmt::join(sides, " and "));
}

// The cheapest way that helps for certain: its misalignment lies below the worn one's interval, which holds how rises
// differ; or, in the trial that shows it, the joint that it moves is off the knee. Worn links that do not keep the
// limits are no way.
const Way* FirstToTry(const std::vector<Way>& ways, const std::vector<Asked>& asked) {
  const Uncertain& worn = ways.front().misalignment_percent;
  const bool can_stay = std::ranges::all_of(asked, &Asked::IsKeptByWorn);
  for (const Way& way : ways)
    if (&way != &ways.front() && (can_stay || &way == &ways.back()) &&
        way.misalignment_percent.value < (way.mends_joint ? worn.value : worn.low))
      return &way;
  return nullptr;
}

// What the redesign was required to keep to a part of body or seat, mm; NaN where nothing was asked.
double AskedClearance(const Json& redesign, const char* key) {
  return NumberOrNaN(Find(redesign, std::string("clearances/") + key));
}

// A moved joint takes its linkage with it, further into the seat than it was worn; where the seat is to be cleared.
bool MeetsSeat(const std::vector<Way>& ways, const Json& redesign) {
  if (std::isnan(AskedClearance(redesign, "seat_mm"))) return false;
  const auto into_mm = [](const Way& way) { return std::max(0.0, -way.on_body->seat_clearance_mm); };
  constexpr double kTold_mm = 1;
  return std::ranges::any_of(ways, [&](const Way& way) {
    return way.mends_joint && way.on_body && ways.front().on_body && into_mm(way) >= into_mm(ways.front()) + kTold_mm;
  });
}

std::string LeadText(const StudyResults& results, const std::vector<Way>& ways, const std::vector<Asked>& asked,
                     const Json& redesign) {
  if (!results.Has("comparison")) return "No exoskeleton was recorded: new links for this person's movement.";
  const std::string side = SideOf(results);
  std::string text = side.empty() ? "The joint sits on the knee, as far as is known. "
                                  : fmt::format("The joint sits {} the knee. ", side);
  const Way* first = FirstToTry(ways, asked);
  if (!first)
    return text + fmt::format("No way below is certain to help: record more {}s first.", RepetitionIn(results));
  if (first == &ways.back())
    return text + (std::ranges::all_of(asked, &Asked::IsKeptByWorn)
                       ? "New links help."
                       : "New links help; those that were worn do not keep the limits, wherever "
                         "their joint is.");
  return text + fmt::format("Move it {} the knee first.", MeetsSeat(ways, redesign) ? "towards" : "onto");
}

// The clearances that were asked for and are not kept, each with how much is missing.
std::vector<std::pair<std::string, double>> Missing(const linkage::WearCheck& check, const Json& redesign) {
  std::vector<std::pair<std::string, double>> missing;
  const auto add = [&](const char* what, double clearance_mm, const char* key) {
    constexpr double kRounding_mm = 1e-3;  // a solver leaves a clearance this much below its limit
    if (const double missing_mm = AskedClearance(redesign, key) - clearance_mm; missing_mm > kRounding_mm)
      missing.emplace_back(what, missing_mm);
  };
  add("The actuator misses its clearance to the thigh", check.thigh_clearance_mm, "limb_mm");
  add("The actuator misses its clearance to the shank", check.shank_clearance_mm, "limb_mm");
  add("The linkage misses its clearance to the seat", check.seat_clearance_mm, "seat_mm");
  return missing;
}

// What most is missing to a clearance in each repaired or new design; one sentence for those in which it is the same.
std::string CollisionText(const std::vector<Way>& ways, const Json& redesign) {
  std::vector<std::pair<std::string, std::vector<std::string>>> sentences;
  for (std::size_t i = ways.size() > 1 ? 1 : 0; i < ways.size(); ++i) {
    if (!ways[i].on_body) continue;
    const auto missing = Missing(*ways[i].on_body, redesign);
    const auto worst = std::ranges::max_element(missing, {}, [](const auto& clearance) { return clearance.second; });
    if (worst == missing.end()) continue;
    const std::string by =
        fmt::format("{} mm ({})", NumberText(worst->second, 0), i + 1 == ways.size() ? "new" : "moved");
    const auto same = std::ranges::find(sentences, worst->first, [](const auto& sentence) { return sentence.first; });
    if (same == sentences.end())
      sentences.push_back({worst->first, {by}});
    else
      same->second.push_back(by);
  }
  std::string text;
  for (const auto& [what, by] : sentences)
    text += fmt::format("{}{} by {}.", text.empty() ? "" : " ", what, fmt::join(by, ", "));
  return text;
}

// The three ways over the rise, and what a recording could not distinguish from none.
LineChart ErrorChart(const StudyResults& results) {
  LineChart chart;
  chart.alt =
      "Distance of the knees over the repetition: as worn, with the joint moved, with new links, and the noise floor";
  chart.x = {RepetitionIn(results) + " (%)", 0, 100};
  chart.y = {"path difference (%)", 0, std::nullopt};
  chart.width = Width::kHalf;
  const auto add = [&](const char* file, const char* name, const char* colour, Mark mark) {
    if (!results.HasFile(file)) return;
    const Json curves = ReadJsonFile(results.Folder() / file).at("curves");
    Series series{.name = name, .colour = colour, .mark = mark};
    series.x = NumbersOrNaN(curves.at("percent"));
    for (const double error : NumbersOrNaN(curves.at("relative_error"))) series.y.push_back(100 * error);
    chart.series.push_back(std::move(series));
  };
  add("comparison/comparison.json", "as worn", colour::kWorn, Mark::kLine);
  add("redesign/joint_moved/comparison.json", "joint moved", colour::kHip, Mark::kDotted);
  add("redesign/predicted/comparison.json", "new links", colour::kNew, Mark::kDashed);
  if (results.Has("comparison")) {
    const double floor = 100 * NumberAt(results.Summary("comparison"), "noise_floor_relative");
    chart.series.push_back(
        {.name = "noise floor", .x = {0, 100}, .y = {floor, floor}, .colour = colour::kGuide, .mark = Mark::kThin});
  }
  return chart;
}

std::string NextSteps(const std::vector<Way>& ways, const std::vector<Asked>& asked) {
  if (const Way* first = FirstToTry(ways, asked); first && first != &ways.back())
    return "Move the mount (an hour), record again (an hour).";
  return "Cut links (a day), test without a person (a day), record again (an hour).";
}

}  // namespace

std::string UncertainText(const Uncertain& of, const std::string& unit, int otherwise) {
  const std::string text = of.Text(otherwise) + unit;
  return of.IsKnown() ? fmt::format("{} ({})", text, of.IntervalText(otherwise, "–")) : text;
}

// The RMS of a prediction against the human's mean is off by no more than that mean is (triangle inequality).
Uncertain KneeAngleError(const StudyResults& results, const Json& design) {
  const double error_deg = NumberAt(design, "knee_rmse_deg");
  if (!results.Has("comparison")) return {.value = error_deg};
  const double strays_deg = NumberOrNaN(Find(results.Summary("comparison"), "human_angle_strays_deg"));
  return {error_deg, std::max(0.0, error_deg - strays_deg), error_deg + strays_deg};
}

std::string RepetitionIn(const StudyResults& results) {
  return results.Has("human") && Find(results.Summary("human"), "movement") == "walking" ? "stride" : "rise";
}

Uncertain RecordedRise(const StudyResults& results) {
  return FactOf(results.Summary("comparison"), kExoTime);
}

Vector2d PlacementHalfWidth(const StudyResults& results) {
  Vector2d half_width = Vector2d::Constant(std::nan(""));
  if (!results.Has("comparison")) return half_width;
  const Json comparison = results.Summary("comparison"),
             intervals = Find(comparison, "decomposition/offset_interval_mm");
  for (const int axis : {0, 1}) {
    const Json sd = Find(comparison, fmt::format("uncertainty/joint_offset_{}_mm/anatomical_sd", "xy"[axis]));
    if (!sd.is_null())
      half_width[axis] = kNormal95 * NumberOrNaN(sd);
    else if (intervals.is_array())
      half_width[axis] = UncertainOf({}, intervals.at(axis)).HalfWidth();
  }
  return half_width;
}

std::vector<Way> WaysOf(const StudyFile& study, const StudyResults& results) {
  const Json redesign = results.Summary("redesign");
  std::vector<Way> ways;
  if (results.Has("comparison")) ways.push_back(AsWorn(study, results, redesign));
  if (results.Has("comparison") && redesign.at("joint_moved").is_object())
    ways.push_back(JointMoved(study, results, redesign));
  ways.push_back(NewLinks(results, redesign));
  return ways;
}

Section ResultChapter(const StudyFile& study, const StudyResults& results) {
  if (!results.Has("redesign")) return MeasuredResult(results);
  const Json redesign = results.Summary("redesign");
  const std::vector<Way> ways = WaysOf(study, results);
  const std::vector<Asked> asked = AskedOfLinks(study, results);
  Section section{
      "Result",
      {Paragraph{LeadText(results, ways, asked, redesign)}, WaysTable(ways, asked, redesign, RepetitionIn(results))}};
  if (const Json walking = redesign.value("walking", Json()); walking.is_object())
    section.blocks.insert(section.blocks.begin(), Answers{{{"For walking", walking.at("text")}}});
  std::vector<std::string> forbids;
  if (const std::string faults = WornFaults(asked, WordsOf); !faults.empty())
    forbids.push_back(fmt::format("The worn links: {}.", faults));
  if (std::string collision = CollisionText(ways, redesign); !collision.empty())
    forbids.push_back(std::move(collision));
  if (MeetsSeat(ways, redesign)) forbids.emplace_back("If the joint is moved, the linkage touches the seat.");
  if (NeedsHolding(results, redesign))
    forbids.emplace_back("At this pace the person cannot keep their balance without support.");
  if (!forbids.empty())
    section.blocks.push_back(Answers{{{"Limits that are violated", fmt::format("{}", fmt::join(forbids, " "))}}});
  if (results.HasFile(kKneesPicture))
    section.blocks.push_back(Picture{results.Folder() / kKneesPicture, KneesPictureAlt(results), "", Width::kHalf});
  else
    section.blocks.push_back(PathsChart(results));
  section.blocks.push_back(ErrorChart(results));
  section.blocks.push_back(Answers{{{"Next", NextSteps(ways, asked)}}});
  return section;
}

std::string WhyNewLinks(const StudyFile& study, const StudyResults& results) {
  const std::string faults = WornFaults(AskedOfLinks(study, results), [](const Asked& limit) {
    const bool is_most = limit.worn > limit.most;
    return fmt::format("{} {} ({} {:g})", WordsOf(limit), Quantity(limit.worn, limit.unit == "deg" ? "°" : limit.unit),
                       is_most ? "at most" : "at least", is_most ? limit.most : limit.least);
  });
  return faults.empty() ? "" : fmt::format("Those that were worn do not keep the limits: {}.", faults);
}

std::string ResultText(const StudyFile& study, const StudyResults& results) {
  if (!results.Has("redesign")) return "";
  const Json redesign = results.Summary("redesign");
  const std::vector<Way> ways = WaysOf(study, results);
  std::vector<std::string> misalignments;
  for (const Way& way : ways)
    misalignments.push_back(fmt::format("{} {}", way.name, UncertainText(way.misalignment_percent, " %")));
  return fmt::format("{}\npath difference: {}\n", LeadText(results, ways, AskedOfLinks(study, results), redesign),
                     fmt::join(misalignments, "; "));
}

}  // namespace lake::study
