#include "lake/problem/problem_options.h"

#include "lake/core/error.h"

namespace lake::problem {

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
  add("grashof-margin", o.grashof_margin_mm, "Margin of Grashof's law").Unit("mm");
  add("singularity-margin", o.singularity_margin_mm, "Margin from the actuator singularity").Unit("mm");
  add("max-force", o.max_force_n, "Largest actuator force over the used range").Unit("N");
  add("knee-torque", o.knee_torque_nm, "Knee torque that the actuator balances").Unit("N m");
  add("min-moment-arm", o.min_moment_arm_mm, "Smallest moment arm over the used range").Unit("mm per rad");
  add("min-transmission", o.min_transmission_deg,
      "Smallest transmission angle between coupler and shank link over the used range")
      .Unit("degrees");
  add("max-angle", o.max_angle_deg, "Anatomical cap on the knee angle").Unit("degrees");
  add("max-length", o.d_max_mm, "Longest stroke of the actuator; the knee must stand by then").Unit("mm");
  options.Check([&o](const OptionList&) {
    try {
      o.Check();
    } catch (const Error& error) {
      throw UsageError(fmt::format("the options contradict the problem: {}", error.what()));
    }
  });
}

}  // namespace lake::problem
