#include "lake/redesign/program_options.h"

namespace lake::redesign {

void Describe(ProgramLimits& o, OptionList& options) {
  using Kind = linkage::StrokeProgram::Kind;
  options.AddChoice("program", o.kind, OptionList::Choices<Kind>{{"constant", Kind::kConstant}, {"free", Kind::kFree}},
                    "Stroke program: constant (one speed) or free; of walking always free");
  options.Add("max-speed", o.max_speed_mm_s, "Speed of the actuator").Unit("mm/s").Positive();
  options.Add("duration", o.duration_s, "Longest duration of a rise, or of a stride")
      .Unit("s")
      .Positive()
      .Otherwise("no limit; of walking the person's stride");
  options.Add("free-ends", o.free_ends, "The ends of a constant program's stroke are sought too");
  options.Add("monotone", o.monotone, "A free program must not reverse");
  options.Add("knots", o.knots, "Number of knots of a free program");
}

}  // namespace lake::redesign
