#include "lake/problem/problem_options.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::problem {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const std::optional<LinearActuator>& actuator) {
  if (!actuator) return "";
  return actuator->file.empty() ? actuator->name : fmt::format("{}:{}", actuator->file.string(), actuator->name);
}

// "free" or seconds.
void SetDuration(const std::string& text, SynthesisProblem& problem) {
  const bool is_free = text == "free";
  const std::optional<double> number = is_free ? std::nullopt : ParseNumber(text);
  if (!is_free && !(number && *number > 0 && *number <= SynthesisProblem::kLongestDuration_s))
    throw UsageError("a duration (--duration, duration_s) is free or a number of seconds above 0, at most {}, not '{}'",
                     SynthesisProblem::kLongestDuration_s, text);
  problem.duration_s = number;
  problem.goal = is_free ? SynthesisProblem::Goal::kDuration : SynthesisProblem::Goal::kRange;
}

}  // namespace

void DescribeLoad(SynthesisProblem& o, OptionList& options) {
  const auto add = [&](const char* name, const char* help, auto set, const TellOption& tell) -> Option& {
    const auto set_one = [&o, set](const OptionTexts& texts, const std::string& said) {
      CheckTextCount(texts, 1, said);
      set(texts.front(), o);
    };
    return options.AddCustom(name, help, set_one, tell);
  };
  add(
      "profile", "What the knee needs over a rise: loads.json, or the folder of lake-loads",
      [](const std::string& text, SynthesisProblem& problem) { problem.profile = ReadLoadProfile(text); },
      [&o] { return o.profile ? o.profile->file.string() : ""; })
      .Value("FILE")
      .Otherwise("a constant torque")
      .IsPath(Option::Path::kFile);
  options.Add("assist", o.assist, "The actuator's share of the moment of --profile, 0 to 1")
      .Value("SHARE")
      .Otherwise("1");
  add(
      "actuator", "Actuator of the catalogue, or FILE.csv:NAME of another: lengths, force, speed, holding force",
      [](const std::string& text, SynthesisProblem& problem) { problem.actuator = FindActuator(text); },
      [&o] { return TextOf(o.actuator); })
      .Value("NAME|FILE");
  options.AddChoice("rest", o.rests_anywhere, OptionList::Choices<bool>{{"anywhere", true}, {"standing", false}},
                    "Where the actuator must hold its share at rest, if its holding force is known");
  add("duration",
      "Longest duration of a rise; free: the shortest at which the actuator gives its share is sought, not the range",
      SetDuration, [&o] { return o.SeeksDuration() ? "free" : OptionField<std::optional<double>>::Text(o.duration_s); })
      .Value("SECONDS|free")
      .Key("duration_s");
}

void DescribeParts(SynthesisProblem& o, OptionList& options) {
  parts::Describe(o.parts, options);
}

void DescribeBody(SynthesisProblem& o, OptionList& options) {
  Describe(o.clearances.body, options);
  options.Add("seat-edge", o.clearances.seat_edge_mm, "Knee to the seat's front edge, for --clear-seat")
      .Unit("mm")
      .NotNegative()
      .Otherwise("half the thigh");
}

void CheckBody(const SynthesisProblem& problem) {
  const Clearances& clearances = problem.clearances;
  const person::BodySize& body = clearances.body;
  if (!clearances.AreAsked() && (body.height_mm || body.mass_kg || body.leg || clearances.seat_edge_mm > 0))
    throw UsageError(
        "a body (--height, --mass, --thigh, --shank, --seat-edge) is what clearances are to: give --clear-seat or "
        "--clear-limb too");
}

void CheckMount(const SynthesisProblem& problem) {
  const Clearances& clearances = problem.clearances;
  if (problem.mount == linkage::Mount::kBeside && (clearances.thigh_mm || clearances.shank_mm))
    throw UsageError(
        "a clearance to thigh and shank (limb_mm, --clear-limb) is for a linkage behind the leg: one beside it passes "
        "them; give mount: behind (--mount behind) too, or leave the clearance out");
}

std::string WithFile(const Option& option, const std::string& text,
                     const std::function<fs::path(const fs::path&)>& place) {
  const ActuatorPlace named = option.PathKind() == Option::Path::kNone ? PlaceOf(text) : ActuatorPlace{text, ""};
  if (named.file.empty()) return text;
  return place(named.file).string() + (named.name.empty() ? "" : ":" + named.name);
}

namespace {

// Each with its name on the command line, or in its section of a file.

void DescribeMargins(SynthesisProblem& o, OptionList& options, const std::string& ending) {
  options.Add("grashof" + ending, o.grashof_margin_mm, "Margin of Grashof's law").Unit("mm").NotNegative();
  options.Add("singularity" + ending, o.singularity_margin_mm, "Margin from the actuator singularity")
      .Unit("mm")
      .NotNegative();
}

void DescribeTorque(SynthesisProblem& o, OptionList& options) {
  options.Add("knee-torque", o.knee_torque_nm, "Knee torque that the actuator balances").Unit("N m").Positive();
}

// All limits, or by their keys those of one section.
void DescribeLimits(SynthesisProblem& o, OptionList& options, std::optional<std::string_view> section = {}) {
  for (const LimitInfo& info : kLimitInfos) {
    if (!*info.key || (section && *section != info.section)) continue;
    Option& option = options.Add(info.option, o.limits[info.key], info.help);
    if (*info.option_unit) option.Unit(info.option_unit);
    if (section || !*info.option_unit) option.Key(info.key);
    if (!*info.option_unit) option.Value("FACTOR");
    if (info.below == kInfinity) option.Positive();
  }
}

void DescribeRobust(SynthesisProblem& o, OptionList& options) {
  options
      .Add("robust", o.robust_mm,
           "Tolerance of every link and of the shortest stroke, play of the pins included: what is optimised is the "
           "worst such build, and requirements hold for all")
      .Unit("mm");
}

void DescribeClearances(SynthesisProblem& o, OptionList& options, const std::string& beginning) {
  Clearances& asked = o.clearances;
  options
      .Add(beginning + "seat", asked.seat_mm,
           "Least distance of the linkage from the seat, the knee bent by 90 degrees")
      .Unit("mm")
      .NotNegative();
  const auto set_limb = [&asked](const OptionTexts& texts, const std::string& said) {
    OptionField<std::optional<double>>::Set(texts, said, asked.thigh_mm);
    asked.shank_mm = asked.thigh_mm;
  };
  options
      .AddCustom(beginning + "limb",
                 "Least distance of the actuator from thigh and shank over the used range, seen from the side, for "
                 "--mount behind",
                 set_limb, [&asked] { return OptionField<std::optional<double>>::Text(asked.thigh_mm); })
      .Unit("mm")
      .NotNegative();
}

// Several numbers that are not held as an array.
template <std::size_t kCount>
Option& DescribeNumbers(const std::string& name, const std::string& help, const std::array<double*, kCount>& fields,
                        OptionList& options) {
  const auto set = [fields](const OptionTexts& texts, const std::string& said) {
    CheckTextCount(texts, kCount, said);
    for (std::size_t i = 0; i < kCount; ++i) OptionField<double>::Set({texts[i]}, said, *fields[i]);
  };
  const auto text = [fields] {
    std::array<double, kCount> values;
    std::ranges::transform(fields, values.begin(), [](const double* field) { return *field; });
    return OptionField<std::array<double, kCount>>::Text(values);
  };
  return options.AddCustom(name, help, set, text).SplitAtCommas();
}

std::array<double*, 6> LengthsOf(linkage::Links& links) {
  return {&links.l1, &links.l2, &links.l3, &links.l4, &links.l5, &links.l6};
}

}  // namespace

void Describe(SynthesisProblem& o, OptionList& options) {
  DescribeNumbers("start", "Links to start from", LengthsOf(o.start), options)
      .Unit("mm")
      .Key("start")
      .Value("l1,l2,l3,l4,l5,l6");
  DescribeMargins(o, options, "-margin");
  DescribeTorque(o, options);
  DescribeLimits(o, options);
  DescribeRobust(o, options);
  DescribeLoad(o, options);
  DescribeMount(o.mount, options);
  DescribeClearances(o, options, "clear-");
  DescribeBody(o, options);
  DescribeParts(o, options);
  options.Check([&o](const OptionList&) {
    try {
      o.Check();
    } catch (const Error& error) {
      throw UsageError("the options contradict the problem: {}", error.what());
    }
  });
}

std::vector<ProblemSection> SectionsOf(SynthesisProblem& o) {
  OptionList whole, bounds, start, margins, body, clearances, parts, load, of_load;
  whole.Add("d-min", o.d_min_mm, "The actuator's shortest stroke").Unit("mm");
  whole.Add("standing", o.standing_deg, "Knee angle at which the used range ends").Unit("degrees");
  DescribeLimits(o, whole, "");
  DescribeRobust(o, whole);
  DescribeMount(o.mount, whole);
  constexpr const char* kLinks[] = {"coupler RS",    "slewing bar PR",           "thigh link KP",
                                    "shank link KS", "mount M behind the thigh", "mount M above the thigh pin P"};
  for (std::size_t i = 0; i < o.bounds.size(); ++i) {
    const std::array<double*, 2> both = {&o.bounds[i].lower, &o.bounds[i].upper};
    DescribeNumbers(LinkName(i), fmt::format("Bounds of the {}, mm", kLinks[i]), both, bounds);
    DescribeNumbers(LinkName(i), "Where the search starts, mm", std::array{LengthsOf(o.start)[i]}, start);
  }
  DescribeMargins(o, margins, "");
  DescribeBody(o, body);
  DescribeClearances(o, clearances, "");
  DescribeParts(o, parts);
  DescribeTorque(o, load);
  DescribeLimits(o, load, "load");
  DescribeLoad(o, load);
  DescribeLoad(o, of_load);
  return {{"", whole},
          {"bounds", bounds},
          {"start", start},
          {"margins", margins},
          {"body", body},
          {"clearances", clearances},
          {"parts", parts},
          {"load", load.Without({"actuator"})},
          {"", of_load.Without({"profile", "assist", "rest", "duration"})}};
}

}  // namespace lake::problem
