#include "lake/problem/problem_options.h"

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "load_texts.h"

namespace lake::problem {

namespace {

std::string TextOf(const std::optional<LinearActuator>& actuator) {
  if (!actuator) return "";
  return actuator->file.empty() ? actuator->name : fmt::format("{}:{}", actuator->file.string(), actuator->name);
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
  add("rest", "Where the actuator must hold its share at rest, if its holding force is known", SetRest, [&o] {
    return o.rests_anywhere ? "anywhere" : "standing";
  }).Value("anywhere|standing");
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

void CheckRest(const SynthesisProblem& problem) {
  if (!problem.rests_anywhere && !(problem.actuator && problem.HasLoadProfile()))
    throw UsageError(
        "rest says where an actuator must hold its share: give --actuator, --profile loads.json, and an --assist above "
        "0");
}

namespace {

// The options of the mount, of clearances and of the body.
void DescribeClearances(SynthesisProblem& o, OptionList& options) {
  DescribeMount(o.mount, options);
  Clearances& asked = o.clearances;
  options.Add("clear-seat", asked.seat_mm, "Least distance of the linkage from the seat, the knee bent by 90 degrees")
      .Unit("mm")
      .NotNegative();
  const auto set_limb = [&asked](const OptionTexts& texts, const std::string& said) {
    OptionField<std::optional<double>>::Set(texts, said, asked.thigh_mm);
    asked.shank_mm = asked.thigh_mm;
  };
  options
      .AddCustom(
          "clear-limb",
          "Least distance of the actuator from thigh and shank over the used range, seen from the side, for --mount "
          "behind",
          set_limb, [&asked] { return OptionField<std::optional<double>>::Text(asked.thigh_mm); })
      .Unit("mm")
      .NotNegative();
  DescribeBody(o, options);
}

}  // namespace

void Describe(SynthesisProblem& o, OptionList& options) {
  const auto set_start = [&o](const OptionTexts& texts, const std::string& said) {
    std::array<double, 6> links;
    OptionField<std::array<double, 6>>::Set(texts, said, links);
    o.start = linkage::Links::FromValues(links);
  };
  const auto tell_start = [&o] { return OptionField<std::array<double, 6>>::Text(o.start.Values()); };
  options.AddCustom("start", "Links to start from", set_start, tell_start)
      .Unit("mm")
      .Key("start")
      .Value("l1,l2,l3,l4,l5,l6")
      .SplitAtCommas();
  options.Add("grashof-margin", o.grashof_margin_mm, "Margin of Grashof's law").Unit("mm").NotNegative();
  options.Add("singularity-margin", o.singularity_margin_mm, "Margin from the actuator singularity")
      .Unit("mm")
      .NotNegative();
  options.Add("knee-torque", o.knee_torque_nm, "Knee torque that the actuator balances").Unit("N m").Positive();
  for (const LimitInfo& info : kLimitInfos) {
    if (!*info.option) continue;
    Option& option = options.Add(info.option, o.limits[info.key], info.help);
    if (*info.option_unit)
      option.Unit(info.option_unit);
    else
      option.Key(info.key).Value("FACTOR");
    if (info.below == kInfinity) option.Positive();
  }
  options
      .Add("robust", o.robust_mm,
           "Tolerance of every link and of the shortest stroke, play of the pins included: what is optimised is the "
           "worst such build, and requirements hold for all")
      .Unit("mm");
  DescribeLoad(o, options);
  DescribeClearances(o, options);
  Describe(o.parts, options);
  options.Check([&o](const OptionList&) {
    try {
      o.Check();
    } catch (const Error& error) {
      throw UsageError("the options contradict the problem: {}", error.what());
    }
  });
}

}  // namespace lake::problem
