#include "lake/problem/problem_options.h"

#include "lake/core/error.h"
#include "load_texts.h"

namespace lake::problem {

void DescribeLoad(SynthesisProblem& o, OptionList& options) {
  const auto add = [&](const char* name, const char* help, auto set) -> Option& {
    return options.AddCustom(name, help, [&o, set](const OptionTexts& texts, const std::string& said) {
      CheckTextCount(texts, 1, said);
      set(texts.front(), o);
    });
  };
  add("profile", "What the knee needs over a rise: loads.json, or the folder of lake-loads",
      [](const std::string& text, SynthesisProblem& problem) { problem.profile = ReadLoadProfile(text); })
      .Value("FILE")
      .Otherwise("a constant torque")
      .IsPath(Option::Path::kFile);
  options
      .AddCustom("assist", "The actuator's share of the moment of --profile, 0 to 1",
                 [&o](const OptionTexts& texts, const std::string& said) {
                   OptionField<std::optional<double>>::Set(texts, said, o.assist);
                 })
      .Value("SHARE")
      .Otherwise("1");
  add("actuator", "Actuator of the catalogue, or FILE.csv:NAME of another: lengths, force, speed, holding force",
      [](const std::string& text, SynthesisProblem& problem) { problem.actuator = FindActuator(text); })
      .Value("NAME|FILE");
  add("rest", "Where the actuator must hold its share at rest, if its holding force is known", SetRest)
      .Value("anywhere|standing")
      .Otherwise("anywhere");
  add("duration",
      "Longest duration of a rise; free: the shortest at which the actuator gives its share is sought, not the range",
      SetDuration)
      .Value("SECONDS|free")
      .Key("duration_s");
}

void DescribeClearances(SynthesisProblem& o, OptionList& options) {
  Clearances& asked = o.clearances;
  const auto add = [&options](const char* name, const char* help, auto set) -> Option& {
    return options.AddCustom(name, help, [set](const OptionTexts& texts, const std::string& said) {
      double number = 0;
      OptionField<double>::Set(texts, said, number);
      set(number);
    });
  };
  add("clear-seat", "Least distance of the linkage from the seat, the knee bent by 90 degrees",
      [&asked](double mm) { asked.seat_mm = mm; })
      .Unit("mm")
      .NotNegative();
  add("clear-limb", "Least distance of the actuator from thigh and shank over the used range, seen from the side",
      [&asked](double mm) { asked.thigh_mm = asked.shank_mm = mm; })
      .Unit("mm")
      .NotNegative();
  add("thigh", "The person's thigh, hip to knee, for --clear-*",
      [&asked](double mm) {
        asked.body.leg = {mm, asked.body.leg.value_or(linkage::LegLengths{}).shank_mm};
      })
      .Unit("mm")
      .Positive()
      .Otherwise("by body height");
  add("shank", "The person's shank, knee to ankle, for --clear-*",
      [&asked](double mm) {
        asked.body.leg = {asked.body.leg.value_or(linkage::LegLengths{}).thigh_mm, mm};
      })
      .Unit("mm")
      .Positive()
      .Otherwise("by body height");
  add("height", "Body height, for --clear-*", [&asked](double mm) { asked.body.height_mm = mm; })
      .Unit("mm")
      .Positive()
      .Otherwise("1800, or by thigh and shank");
  add("mass", "Body mass, for --clear-*", [&asked](double kg) { asked.body.mass_kg = kg; })
      .Unit("kg")
      .Positive()
      .Otherwise("80 at 1800 mm, else of the same BMI");
  add("seat-edge", "Knee to the seat's front edge, for --clear-seat", [&asked](double mm) { asked.seat_edge_mm = mm; })
      .Unit("mm")
      .NotNegative()
      .Otherwise("half the thigh");
  options.Check([&asked](const OptionList& list) {
    if (!list.IsGiven("height") || !asked.body.leg || list.IsGiven("thigh") || list.IsGiven("shank")) return;
    throw UsageError(fmt::format(
        "--height {} mm: the problem file has the person's own thigh and shank ({} and {} mm), which a height does not "
        "change; give --thigh and --shank too, or take thigh_mm and shank_mm out of the file",
        *asked.body.height_mm, asked.body.leg->thigh_mm, asked.body.leg->shank_mm));
  });
}

void CheckBody(const SynthesisProblem& problem) {
  const Clearances& clearances = problem.clearances;
  const linkage::BodySize& body = clearances.body;
  if (!clearances.AreAsked() && (body.height_mm || body.mass_kg || body.leg || clearances.seat_edge_mm > 0))
    throw UsageError(
        "a body (--height, --mass, --thigh, --shank, --seat-edge) is what clearances are to: give --clear-seat or "
        "--clear-limb too");
}

void CheckRest(const SynthesisProblem& problem) {
  if (!problem.rests_anywhere && !(problem.actuator && problem.HasLoadProfile()))
    throw UsageError(
        "rest says where an actuator must hold its share: give --actuator, --profile loads.json, and an --assist above "
        "0");
}

void Describe(SynthesisProblem& o, OptionList& options) {
  // The default is the problem's own, so none is shown.
  const auto add = [&options](const char* name, auto& field, const char* help) -> Option& {
    return options.AddCustom(name, help, [&field](const OptionTexts& texts, const std::string& said) {
      OptionField<std::remove_reference_t<decltype(field)>>::Set(texts, said, field);
    });
  };
  const auto set_start = [&o](const OptionTexts& texts, const std::string& said) {
    std::array<double, 6> links;
    OptionField<std::array<double, 6>>::Set(texts, said, links);
    o.start = linkage::Links::FromValues(links);
  };
  options.AddCustom("start", "Links to start from", set_start)
      .Unit("mm")
      .Key("start")
      .Value("l1,l2,l3,l4,l5,l6")
      .SplitAtCommas();
  add("grashof-margin", o.grashof_margin_mm, "Margin of Grashof's law").Unit("mm").NotNegative();
  add("singularity-margin", o.singularity_margin_mm, "Margin from the actuator singularity").Unit("mm").NotNegative();
  add("max-force", o.max_force_n, "Largest actuator force over the used range").Unit("N").Positive();
  add("max-pin-force", o.max_pin_force_n, "Largest force in a pin, at K, P, R and S").Unit("N").Positive();
  add("max-mount-force", o.max_mount_force_n, "Largest force of the mount on the thigh, at M").Unit("N").Positive();
  add("safety-factor", o.safety_factor, "Least safety factor of plates, pins and the actuator's rod, as strength.csv")
      .Key("safety_factor")
      .Value("FACTOR")
      .Positive();
  add("knee-torque", o.knee_torque_nm, "Knee torque that the actuator balances").Unit("N m").Positive();
  add("min-moment-arm", o.min_moment_arm_mm, "Smallest moment arm over the used range").Unit("mm per rad").Positive();
  add("min-transmission", o.min_transmission_deg,
      "Smallest transmission angle between coupler and shank link over the used range")
      .Unit("degrees");
  add("max-angle", o.max_angle_deg, "Anatomical cap on the knee angle").Unit("degrees");
  add("max-length", o.d_max_mm, "Longest stroke of the actuator; the knee must be straight by then").Unit("mm");
  add("robust", o.robust_mm,
      "Tolerance of every link and of the shortest stroke, play of the pins included: what is optimised is the worst "
      "such build, and requirements hold for all")
      .Unit("mm");
  DescribeLoad(o, options);
  DescribeClearances(o, options);
  Describe(o.parts, options);
  options.Check([&o](const OptionList&) {
    try {
      o.Check();
    } catch (const Error& error) {
      throw UsageError(fmt::format("the options contradict the problem: {}", error.what()));
    }
  });
}

}  // namespace lake::problem
