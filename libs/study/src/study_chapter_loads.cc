#include <fmt/ranges.h>

#include <cmath>

#include "lake/core/counted.h"
#include "lake/core/uncertain_text.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

std::string NeedText(const Json& loads) {
  const Uncertain peak_nm = UncertainOf(loads.at("peak_knee_nm"), loads.at("peak_knee_nm_interval"));
  const double of_mass = NumberAt(loads, "peak_knee_nm_kg");
  return fmt::format(
      "One leg extends its knee with {} N m at most (95 % interval {} N m), {} N m per kg of body mass, at a "
      "knee angle of {}; mean of {}, {}.",
      peak_nm.Text(), peak_nm.IntervalText(), KnownText(of_mass, peak_nm.HalfWidth() * of_mass / peak_nm.value, 2),
      QuantityAt(loads, "peak_knee_deg"), Counted(loads.at("rises").size(), "rise"),
      loads.at("method") == "bottom-up" ? "from the ground's forces" : "without force plates");
}

// Of a summary of one actuator.
std::string LiftText(const Json& assistance) {
  const Json &actuator = assistance.at("actuator"), &force = assistance.at("force_n");
  const double lifts_n = NumberAt(actuator, "lifting_force_n");
  return fmt::format("{} gives {:.0f} % of that with {}; {}.", actuator.at("name").get<std::string>(),
                     100 * NumberAt(assistance, "assist"),
                     force.is_object() ? "at most " + Quantity(std::abs(NumberAt(force, "value")), "N") : "no force",
                     std::isfinite(lifts_n) ? "it lifts " + Quantity(lifts_n, "N") : "what it lifts is not known");
}

std::string SpeedText(const Json& assistance) {
  const double shortest_s = NumberAt(assistance, "shortest_duration_s"),
               any_s = NumberAt(assistance, "any_linkage_duration_s");
  if (!std::isfinite(shortest_s)) return "Its speed is not known.";
  std::string text = fmt::format(
      "With links that are the best for it, in {} or longer, where the person takes {}: its speed is the limit, at "
      "{:.0f} % of the rise.",
      Quantity(shortest_s, "s"), QuantityAt(assistance, "own_duration_s"), NumberAt(assistance, "limiting_percent"));
  if (assistance.at("shortest_is_lower_bound").get<bool>())
    text += " Its speed under load is not known, so this is a lower bound.";
  else if (std::isfinite(any_s))
    text += fmt::format(" With its power no linkage could be faster than {}.", Quantity(any_s, "s"));
  return text;
}

// Why the new design's rise takes so long on the first screen; empty without one.
std::string OwnTimeText(const StudyResults& results) {
  if (!results.Has("redesign")) return "";
  const Json redesign = results.Summary("redesign");
  const double own_s = NumberAt(redesign, "after/program_duration_s");
  if (!std::isfinite(own_s)) return "";
  return fmt::format(
      " The new design's own time, {}, is that of its stroke program, with the study's actuator and its limit of "
      "{} mm/s.",
      Quantity(own_s, "s"), SignificantText(NumberAt(redesign, "stroke_program/max_speed_mm_s"), 4));
}

// How the person leans for the new design's program, and what the knee then needs; empty without one.
std::string LeanText(const StudyResults& results) {
  const Json program = results.Has("redesign") ? Find(results.Summary("redesign"), "balance") : Json();
  if (!program.is_object()) return "";
  const Json own = results.Summary("loads").at("balance").at("own");
  const double trunk_deg = NumberAt(program, "trunk_lean_deg"), margin_mm = NumberAt(program, "margin_mm");
  const std::string lean = std::abs(trunk_deg) < 1
                               ? "as in"
                               : fmt::format("up to {} farther {} than in", Quantity(std::abs(trunk_deg), "°"),
                                             trunk_deg < 0 ? "back" : "forward");
  return fmt::format(
      "In the new design's rise of {} the trunk leans {} the person's own, which takes {}. The ground's force then "
      "acts {} {} the foot{}, and the knee needs at most {} of what it needs in the person's own rise.",
      QuantityAt(program, "duration_s"), lean, QuantityAt(own, "rise_s"), Quantity(std::abs(margin_mm), "mm"),
      margin_mm < 0 ? "outside" : "or more inside", margin_mm < 0 ? ", where the person must be held" : "",
      Quantity(PeakPercent(program, own), "%"));
}

// With the links that are the best for the actuator, and with those of the study's design.
Answers LiftAnswers(const StudyResults& results, const Json& assistance, const std::string& need) {
  Answers answers{{{"What the knee needs", need},
                   {"Will it lift me?", LiftText(assistance)},
                   {"How fast?", SpeedText(assistance) + OwnTimeText(results)}}};
  const Json simulation = results.Summary("simulation");
  if (results.Has("redesign") && simulation.contains("assistance"))
    answers.answers.push_back(
        {"And with the new design?", simulation.at("assistance").at("text").get<std::string>() + "."});
  if (std::string lean = LeanText(results); !lean.empty())
    answers.answers.push_back({"Leaning how far?", std::move(lean)});
  return answers;
}

std::string ReasonOf(const Json& actuator) {
  std::vector<std::string> limits = actuator.at("limits").get<std::vector<std::string>>();
  if (!limits.empty()) return fmt::format("fails: {}", fmt::join(limits, ", "));
  if (!actuator.at("speed_is_known").get<bool>()) return "its speed is not known";
  return actuator.at("speed_under_load_is_known").get<bool>() ? "" : "lower bound: its speed under load is not known";
}

// Of a summary of a catalogue.
Table ActuatorsTable(const Json& assistance) {
  Table table{fmt::format("Actuators; the person's own rise takes {}", QuantityAt(assistance, "own_duration_s")),
              {{"Actuator"}, {"Largest share (%)", 0}, {"Rise time (s)", 1}, {"Beyond that share"}},
              {}};
  for (const Json& actuator : assistance.at("actuators")) {
    const Json& points = actuator.at("points");
    const Json last = points.empty() ? Json() : points.back();
    table.rows.push_back({actuator.at("name").get<std::string>(),
                          last.is_null() ? std::nan("") : 100 * NumberAt(last, "assist"),
                          last.is_null() ? std::nan("") : NumberAt(last, "shortest_duration_s"), ReasonOf(actuator)});
  }
  return table;
}

// To two significant digits, as of a mean whose uncertainty is not known.
std::string TwoDigits(double value) {
  return RoundedText(value, value == 0 ? 0 : 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
}

// How a person gets off the seat: the means of the rises. Empty where it is not known: loads of an earlier version have
// no momentum.
std::string MomentumText(const Json& momentum) {
  if (momentum.is_null() || std::isnan(NumberAt(momentum, "com_forward_max_mm_s"))) return "";
  const auto quantity = [&](const char* name) {
    return fmt::format("{} {}", TwoDigits(NumberAt(momentum, name)), UnitOf(name));
  };
  const double before_mm = NumberAt(momentum, "com_seat_off_mm");
  const std::string place = std::isnan(before_mm)
                                ? ""
                                : fmt::format("is {:.0f} mm {} the ankle at seat-off; it ", std::abs(before_mm),
                                              before_mm < 0 ? "behind" : "before");
  return fmt::format("The body's centre of mass {}moves forward with at most {} ({}) and upward with at most {} ({}).",
                     place, quantity("com_forward_max_mm_s"), quantity("com_forward_max_ns"),
                     quantity("com_upward_max_mm_s"), quantity("com_upward_max_ns"));
}

// Of the measured path, gone along at two paces.
Table BalanceTable(const Json& balance) {
  Table table{"Balance along the measured path: how far inside the foot the ground's force acts (negative: outside)",
              {{"Pace"},
               {"Rise time (s)", 1},
               {"Margin (mm)", 1},
               {"At % of the rise", 0},
               {"Knee moment, peak (% of the person's own rise's)", 0}}};
  const auto add = [&](const char* name, const Json& pace, double rise_s) {
    table.rows.push_back({name, rise_s, NumberAt(pace, "margin_mm"), NumberAt(pace, "at_percent"),
                          PeakPercent(pace, balance.at("own"))});
  };
  add("the person's own", balance.at("own"), NumberAt(balance, "own/rise_s"));
  add("in a very slow rise", balance.at("slow"), std::nan(""));
  table.rows.push_back(
      {"the slowest in balance", NumberAt(balance, "slowest_s"), std::nan(""), std::nan(""), std::nan("")});
  return table;
}

}  // namespace

double PeakPercent(const Json& pace, const Json& other) {
  return 100 * NumberAt(pace, "peak_knee_nm") / NumberAt(other, "peak_knee_nm");
}

Section LoadsChapter(const StudyFile&, const StudyResults& results) {
  const std::string need = NeedText(results.Summary("loads"));
  Section section{"Loads", {}};
  const Json assistance = results.Has("assistance") ? results.Summary("assistance") : Json();
  if (assistance.contains("assistance"))
    section.blocks.push_back(LiftAnswers(results, assistance.at("assistance"), need));
  else
    section.blocks.push_back(Paragraph{need});
  results.AddPicture(
      "loads/loads.svg", "Moments over the rise",
      "The knee's moment over the rises with its 95 % band; grey, until the seat is left: between all "
      "weight on it and none. Right: the joints' means, where the ground's force acts, the knee's power.",
      Width::kFull, section);
  results.AddPicture("assistance/assistance.svg", "Force, speed and power of the actuator over the rise",
                     "The actuator's force, speed and power in a rise as long as its title says, with its limits.",
                     Width::kFull, section);
  if (const std::string text = MomentumText(Find(results.Summary("loads"), "momentum")); !text.empty())
    section.blocks.push_back(Paragraph{text});
  section.blocks.push_back(BalanceTable(results.Summary("loads").at("balance")));
  if (assistance.contains("actuators")) section.blocks.push_back(ActuatorsTable(assistance));
  results.AddPicture("assistance/actuators_front.svg", "Shortest rise against the share of the knee's moment",
                     "The shortest rise with each actuator, its links the best for it, against the share of the knee's "
                     "moment that it gives.",
                     Width::kFull, section);
  return section;
}

}  // namespace lake::study
