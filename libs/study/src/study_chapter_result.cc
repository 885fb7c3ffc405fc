#include <algorithm>
#include <array>
#include <cmath>

#include "lake/compare/misalignment.h"
#include "lake/core/csv.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/misalignment_sections.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

// Where the joint is on the leg that wears it, with the interval of all sources.
std::string JointText(const Json& comparison) {
  const Json joint = Find(comparison, "joint");
  if (joint.is_null()) return "";
  const Uncertain moved = JointMovedFigure(comparison);
  return fmt::format(
      "The exoskeleton's joint is {} RMS from the knee of the leg that wears it; moved there and put on anew, it would "
      "be {}{} mm from it{}. ",
      UncertainText(FactOf(comparison, kJointRms), " mm"), joint.at("repetitions") == 1 ? "at least " : "",
      moved.Text(),
      moved.value < NumberAt(joint, "rms_mm") ? "" : ", no nearer than now, so that it need not be moved");
}

// Where the exoskeleton hides the knee.
std::string RebuiltText(const StudyResults& results) {
  const Json rebuilt = Find(results.Summary("exo"), "rebuilt_knee");
  if (!rebuilt.is_object()) return "";
  return fmt::format(
      "The exoskeleton hides the knee in {} frames, where it is rebuilt from the technical markers, ± {} mm (1 SD "
      "along each axis). ",
      rebuilt.at("frames").get<int>(), RoundedText(NumberAt(rebuilt, "sd_mm"), 1));
}

std::string WrongText(const StudyResults& results) {
  const Json comparison = results.Summary("comparison");
  return JointText(comparison) + RebuiltText(results) +
         fmt::format("The knee paths of both trials differ by {} mm RMS, {} % of the shank length. {}",
                     FactOf(comparison, kPathMm).Text(), FactOf(comparison, kPathPercent).Text(),
                     DecompositionAdvice(comparison));
}

std::string BuildText(const StudyResults& results, const Json& redesign) {
  std::vector<std::string> links;
  for (const auto& [name, length] : redesign.at("links").items())
    links.push_back(fmt::format("{} {}", name, NumberText(NumberOrNaN(length), 2)));
  const Json simulation = results.Summary("simulation");
  std::string text = fmt::format(
      "Links {} mm; joint {}", fmt::join(links, ", "),
      compare::DescribeJoint({NumberAt(redesign, "after/placement_x_mm"), NumberAt(redesign, "after/placement_y_mm")}));
  text += fmt::format("; actuator from {} to {} mm pin to pin ({} mm of travel)",
                      NumberText(NumberAt(simulation, "used_stroke_mm/0"), 2),
                      NumberText(NumberAt(simulation, "used_stroke_mm/1"), 2),
                      NumberText(NumberAt(simulation, "travel_mm"), 2));
  if (const double force_n = LargestForce(results); std::isfinite(force_n))
    text += fmt::format(". To hold {} the actuator pushes with at most {}", QuantityAt(simulation, "knee_torque_nm"),
                        Quantity(force_n, "N"));
  return text + ".";
}

// What range buys: the design of the same program with the least range given up whose misalignment a recording could
// not tell from none, or else the one with the least.
std::string TradeText(const Json& redesign) {
  const std::vector<TradePoint> front = OwnFront(redesign);
  const double range_deg = NumberAt(redesign, "range_deg"), percent = NumberAt(redesign, "misalignment_percent"),
               floor = NumberAt(redesign, "noise_floor_percent");
  const TradePoint* best = nullptr;
  for (const TradePoint& point : front) {
    if (point.range_deg >= range_deg || point.misalignment_percent >= percent) continue;
    const bool enough = best && best->misalignment_percent <= floor;
    if (!best || (point.misalignment_percent <= floor && (!enough || point.range_deg > best->range_deg)) ||
        (!enough && point.misalignment_percent < best->misalignment_percent))
      best = &point;
  }
  if (!best) return "";
  return fmt::format(" With {}° of range it would be {} %.", NumberText(best->range_deg, 0),
                     NumberText(best->misalignment_percent, 1));
}

// Which of the new design's numbers are the study file's own limits.
std::string LimitsText(const Way& way, const Json& redesign) {
  std::vector<std::string> limits;
  if (way.misalignment_is_limit)
    limits.push_back(QuantityAt(redesign, "max_misalignment_percent") + " of path difference");
  if (way.time_is_limit) limits.push_back(QuantityAt(redesign, "stroke_program/duration_limit_s") + " for a rise");
  if (limits.empty()) return "";
  return fmt::format(
      " {} {} that you set: the search goes as far as {}, and what other limits give is in the chapter "
      "New design.",
      fmt::join(limits, " and "), limits.size() == 1 ? "is a limit" : "are limits",
      limits.size() == 1 ? "it allows" : "they allow");
}

std::string CostText(const StudyResults& results, const Json& redesign, const Way& way) {
  const Json &before = redesign.at("before"), &after = redesign.at("after");
  const auto from_to = [&](const char* key) {
    const bool has_worn = before.at(key).is_number();
    return QuantityAt(after, key) + (has_worn ? fmt::format(" instead of {}", QuantityAt(before, key)) : "");
  };
  std::string text = fmt::format("Path difference {} of the shank length.", from_to("misalignment_percent"));
  text += fmt::format(" It costs time: a {} takes {}", RepetitionIn(results), from_to("program_duration_s"));
  if (results.Has("stroke"))
    if (const double rest_s = NumberAt(results.Summary("stroke"), "added_rest_s"); rest_s >= 0.005)
      text += fmt::format(", and {} of rests at reversals", Quantity(rest_s, "s"));
  const Uncertain knee = KneeAngleError(results, after), worn_knee = KneeAngleError(results, before);
  text +=
      fmt::format(". Range of rotation {}; knee angle {}° RMS from the human's{}.", from_to("range_deg"), knee.Text(),
                  std::isfinite(worn_knee.value) ? fmt::format(" instead of {}°", worn_knee.Text()) : "");
  return text + LimitsText(way, redesign) + TradeText(redesign);
}

// What the worn links could do without being moved or made anew.
std::string OtherProgramText(const Json& redesign) {
  const Json& other = redesign.at("other_program");
  if (!other.is_object()) return "";
  return fmt::format("The worn links, their joint where it was, leave {} with the best stroke program of {}.",
                     QuantityAt(other, "misalignment_percent"), QuantityAt(other, "program_duration_s"));
}

// Of a program for which balance was required, or along which it is kept.
std::string KeptText(const Json& redesign, const Json& balance) {
  std::string text = fmt::format("Yes: in {} the ground's force acts at least {} inside the foot",
                                 QuantityAt(balance, "duration_s"), QuantityAt(balance, "margin_mm"));
  const double trunk_deg = NumberAt(balance, "trunk_lean_deg"), leg_deg = NumberAt(balance, "leg_lean_deg");
  if (std::abs(trunk_deg) >= 1)
    text += fmt::format(", with the trunk up to {} farther {} than in the person's own rise",
                        Quantity(std::abs(trunk_deg), "°"), trunk_deg < 0 ? "back" : "forward");
  if (std::abs(leg_deg) >= 1)
    text += fmt::format(" and the leg up to {} farther {}", Quantity(std::abs(leg_deg), "°"),
                        leg_deg < 0 ? "back" : "forward");
  if (const double hold_n = balance.value("hold_force_n", 0.0); hold_n > 0)
    text +=
        fmt::format(". Arm rests, a helper or a harness hold the trunk with {} for this leg", Quantity(hold_n, "N"));
  if (const double device_kg = balance.value("device_mass_kg", 0.0); device_kg > 0)
    text += fmt::format(". The exoskeleton's own {} on this leg are in it", Quantity(device_kg, "kg"));
  if (const Json& without = balance.at("without"); without.is_object()) {
    const auto against = [&](const char* key, const char* what) {
      const std::string without_it = QuantityAt(without, key), with_it = QuantityAt(redesign.at("after"), key);
      return without_it == with_it ? fmt::format("the same {}", what)
                                   : fmt::format("{} of {} instead of {}", with_it, what, without_it);
    };
    const double margin_mm = NumberAt(without, "balance_margin_mm");
    const std::string range = against("range_deg", "range");
    text += fmt::format(
        ". Against a design of which no balance is required, where the ground's force acts {} {} the foot, it has {}, "
        "{}, {} and {}",
        Quantity(std::abs(margin_mm), "mm"), margin_mm < 0 ? "outside" : "inside", range,
        against("misalignment_percent", "path difference"),
        against("angle_mismatch_max_deg", "largest knee angle difference"), against("program_duration_s", "rise time"));
    const bool is_wider = NumberAt(redesign, "after/range_deg") > NumberAt(without, "range_deg");
    if (is_wider && !range.starts_with("the same"))
      text += ": a leg that leans otherwise keeps the knee's path with other knee angles, which frees the links";
  }
  return text + ".";
}

// Whether a person keeps the balance on the measured path, which the stroke program keeps, in the program's time.
std::string BalanceText(const StudyResults& results, const Json& redesign) {
  const Json kept = redesign.value("balance", Json());
  if (kept.is_object() && NumberAt(kept, "margin_mm") >= 0) return KeptText(redesign, kept);
  const Json balance = results.Summary("loads").at("balance"), &slow = balance.at("slow");
  const double program_s = NumberAt(redesign, "after/program_duration_s"), slow_mm = NumberAt(slow, "margin_mm"),
               slowest_s = NumberAt(balance, "slowest_s");
  if (!kept.is_object() && slow_mm >= 0)
    return fmt::format("Yes: however slowly, the ground's force acts at least {} inside the foot.",
                       Quantity(slow_mm, "mm"));
  if (!kept.is_object() && program_s <= slowest_s)
    return fmt::format("Yes, by momentum: along this path a rise takes {} at most.", Quantity(slowest_s, "s"));
  const double margin_mm = kept.is_object() ? NumberAt(kept, "margin_mm") : slow_mm;
  const Json interval = slow.value("margin_interval_mm", Json());
  // What is not known of the body is not known of the program either, whose pace and aids move the margin.
  const auto of_program_mm = [&](std::size_t end) { return NumberOrNaN(interval.at(end)) + margin_mm - slow_mm; };
  const double most_mm = interval.is_array() ? of_program_mm(1) : margin_mm;
  std::string text = most_mm < 0 ? "Not without being held" : "Perhaps not without being held";
  text += ": the program keeps the path of the person's own rise";
  if (std::isfinite(slowest_s)) text += fmt::format(", which is in balance for {} at most", Quantity(slowest_s, "s"));
  text += fmt::format(". In {} the ground's force would act {} outside the foot", Quantity(program_s, "s"),
                      Quantity(-margin_mm, "mm"));
  if (interval.is_array())
    text += fmt::format(" ({} to {})", NumberText(-most_mm, 1), NumberText(-of_program_mm(0), 1));
  return text + ". Lean farther forward, draw the feet back, or let something hold the person.";
}

// What the design was asked to clear.
Json AskedClearances(const StudyResults& results) {
  return results.Summary(results.Has("redesign") ? "redesign" : "optimum").value("clearances", Json());
}

std::string AskedText(const Json& asked) {
  if (asked.is_null()) return "No clearance was required of the design.";
  std::vector<std::string> parts;
  for (const auto& [key, what] : {std::pair{"seat_mm", "the seat"}, {"limb_mm", "thigh and shank"}})
    if (asked.at(key).is_number()) parts.push_back(fmt::format("{} from {}", QuantityAt(asked, key), what));
  return fmt::format("The design was required to keep {}.", fmt::join(parts, " and "));
}

std::string BodyText(const StudyResults& results) {
  const Json body = results.Summary("simulation").at("mannequin");
  std::vector<std::string> findings, overlaps;
  const auto overlap = [&](const std::string& key) {
    const double clearance = NumberAt(body, key);
    return clearance < 0 ? Quantity(-clearance, "mm") : "";
  };
  if (const std::string past = overlap("mount_below_hip_mm"); !past.empty())
    findings.push_back(fmt::format("the mount reaches {} past the hip", past));
  if (const std::string into = overlap("seat_clearance_mm"); !into.empty() && !body.at("clears_seat").is_null())
    findings.push_back(fmt::format("the linkage reaches {} into the seat", into));
  for (const char* limb : {"thigh", "shank"})
    if (const std::string by = overlap(fmt::format("actuator_to_{}_mm", limb));
        !by.empty() && !body.at("clears_limb").is_null())
      overlaps.push_back(fmt::format("the {} by {}", limb, by));
  if (!overlaps.empty())
    findings.push_back(fmt::format("the actuator, seen from the side, overlaps {}", fmt::join(overlaps, " and ")));
  return fmt::format("On a leg of {} thigh and {} shank, with the linkage {} it, {}. {}", QuantityAt(body, "thigh_mm"),
                     QuantityAt(body, "shank_mm"), body.at("mount").get<std::string>(),
                     findings.empty() ? "nothing collides" : fmt::format("{}", fmt::join(findings, "; ")),
                     AskedText(AskedClearances(results)));
}

std::string SureText(const StudyResults& results, const Json& redesign) {
  std::string text = "The new design is predicted, not recorded.";
  if (results.Has("comparison")) {
    const Json trial = redesign.at("trial");
    const double worn = NumberAt(redesign, "before/misalignment_percent");
    if (trial.is_object() && std::isfinite(worn))
      text += fmt::format(" For the worn design the same prediction gives {} where {} was measured.",
                          Quantity(worn, "%"), FactOf(results.Summary("comparison"), kPathPercent).Text() + " %");
    text += fmt::format(
        " Below {}, the noise floor, a recording shows only noise. Intervals on the first screen are "
        "95 %: as worn and with the joint moved how rises differ is in them, of new links only how well the joint can "
        "be put in its place; the knee angle's say how well the person's own mean is known.",
        QuantityAt(redesign, "noise_floor_percent"));
  }
  return text + " " + BodyText(results);
}

std::string NextText(const StudyResults& results) {
  const Json body = results.Summary("simulation").at("mannequin");
  const bool clear = std::ranges::none_of(std::array{"fits_along_thigh", "clears_seat", "clears_limb"},
                                          [&](const char* is_clear) { return body.at(is_clear) == false; });
  const char* mount =
      AskedClearances(results).is_null()
          ? "Require clearances of the design (study file, reoptimize: clearances) or find a mount clear "
          : "Find a mount clear ";
  return (clear ? std::string("Cut the links") : mount + std::string("of body and seat, cut the links")) +
         ", test the firmware on the bench without a person, then record the same movement with the new design and "
         "check the prediction (lake compare, lake stroke --validate).";
}

void Note(const std::string& text, KeyFigure& figure) {
  figure.note += (figure.note.empty() ? "" : "; ") + text;
}

// Rounds the figure to its interval, which is noted below it.
void NoteInterval(const Uncertain& of, const char* unit, KeyFigure& figure) {
  if (!of.IsKnown()) return;
  Note(fmt::format("95 %: {}{}", of.IntervalText(figure.decimals), unit), figure);
  figure.decimals = of.Decimals(figure.decimals);
}

KeyFigures RedesignFigures(const StudyResults& results, const Json& redesign, const Way& way) {
  const Json& before = redesign.at("before");
  const auto figure = [&](const std::string& label, const char* key) {
    const std::string unit = UnitOf(key);
    return KeyFigure{
        .label = label,
        .value = NumberAt(redesign.at("after"), key),
        .decimals = DecimalsOf(unit),
        .unit = unit,
        .note = before.at(key).is_null() ? "" : fmt::format("worn, predicted: {}", QuantityAt(before, key))};
  };
  KeyFigure misalignment = figure("path difference, predicted RMS", "misalignment_percent");
  NoteInterval(way.misalignment_percent, " %", misalignment);
  if (way.misalignment_is_limit) Note("limit you set", misalignment);
  KeyFigure rise = figure(RepetitionIn(results) + " time", "program_duration_s"),
            range = figure("range of rotation", "range_deg"), knee = figure("knee angle error, RMS", "knee_rmse_deg");
  Note(way.time_is_limit ? "limit you set" : "exact: set by the stroke program", rise);
  Note("exact: follows from the links", range);
  if (const Uncertain worn = KneeAngleError(results, redesign.at("before")); std::isfinite(worn.value))
    knee.note = fmt::format("worn, predicted: {}°", worn.Text());
  NoteInterval(KneeAngleError(results, redesign.at("after")), "°", knee);
  return {{std::move(misalignment), std::move(rise), std::move(range), std::move(knee)}};
}

Files BuildFiles(const StudyFile& study, const StudyResults& results) {
  std::vector<Files::File> all = {{"simulation/design.dxf", "link plates to cut, 1:1 in mm"},
                                  {"simulation/schematic.svg", "schematic: what each symbol is"},
                                  {"redesign/design.yaml", "links, placement and stroke program"},
                                  {"stroke/program.csv", "stroke program as a table"}};
  if (const auto firmware = FirmwareOf(study)) all.push_back(*firmware);
  Files files;
  for (const Files::File& file : all)
    if (results.HasFile(file.path)) files.files.push_back(file);
  return files;
}

}  // namespace

std::string KneesPictureAlt(const StudyResults& results) {
  const Json joint = Find(results.Summary("comparison"), "joint");
  if (joint.is_null()) return "A frame of the exoskeleton trial with both knees";
  return fmt::format("A frame of the exoskeleton trial: knee and joint, {} apart", QuantityAt(joint, "rms_mm"));
}

bool NeedsHolding(const StudyResults& results, const Json& redesign) {
  if (const Json program = redesign.value("balance", Json()); program.is_object())
    return NumberAt(program, "margin_mm") < 0;
  if (!results.Has("loads")) return false;
  const Json balance = results.Summary("loads").at("balance");
  return NumberAt(balance, "slow/margin_mm") < 0 &&
         !(NumberAt(redesign, "after/program_duration_s") <= NumberAt(balance, "slowest_s"));
}

// Without a design for the person: what was measured, and the benchmark.
Section MeasuredResult(const StudyResults& results) {
  Section section{"Result", {}};
  Answers answers;
  if (results.Has("comparison")) answers.answers.push_back({"What is wrong", WrongText(results)});
  answers.answers.push_back(
      {"What is possible",
       fmt::format("The design problem allows a range of rotation of {} (benchmark, no person in it{}).",
                   QuantityAt(results.Summary("optimum"), "range_deg"),
                   RepetitionIn(results) == "stride" ? ", nor is it said to be quick enough for walking" : "")});
  answers.answers.push_back({"What fits", BodyText(results)});
  answers.answers.push_back({"What next", "Add a section reoptimize: to the study file for a design for this person."});
  if (results.Has("comparison")) answers.width = Width::kHalf;
  section.blocks.push_back(std::move(answers));
  if (results.Has("comparison")) {
    LineChart paths = KneePathsChart(ReadJsonFile(results.Folder() / "comparison/comparison.json"));
    paths.width = Width::kHalf;
    section.blocks.push_back(std::move(paths));
  }
  return section;
}

Section DetailsChapter(const StudyFile& study, const StudyResults& results) {
  const Json redesign = results.Summary("redesign");
  Answers answers;
  const auto add = [&](const char* question, std::string text) {
    if (!text.empty()) answers.answers.push_back({question, std::move(text)});
  };
  if (results.Has("comparison")) add("What is wrong", WrongText(results));
  add("Why new links", WhyNewLinks(study, results));
  add("What another program would give", OtherProgramText(redesign));
  if (results.Has("loads")) add("Can a person follow it", BalanceText(results, redesign));
  add("What to build for new links", BuildText(results, redesign));
  const Way way = WaysOf(study, results).back();
  add("What they give, what they cost", CostText(results, redesign, way));
  add("How sure it is", SureText(results, redesign));
  add("What next", NextText(results));
  return {"Why, and how sure",
          {RedesignFigures(results, redesign, way), std::move(answers), BuildFiles(study, results)}};
}

}  // namespace lake::study
