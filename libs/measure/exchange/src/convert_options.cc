#include "lake/exchange/convert_options.h"

namespace lake::exchange {

void Describe(ConvertOptions& o, OptionList& options) {
  options.Add("map", o.reading.names, "Keep these markers only, under these names; A+B is the midpoint of two")
      .Value("NAME=MARKER,...");
  DescribeUp(o.reading, options);
  options.Add("forward", o.reading.forward, "Turn a 3-D trial so that this axis of the file is x, up is y, right is z")
      .Value("AXIS")
      .Otherwise("axes as they are");
  DescribeUnit("unit", o.reading.mm_per_unit, options);
  Describe(o.picture, options);
  DescribeRate(o.reading.rate_hz, options);
  DescribeView(o.reading.view, options);
  DescribeValues(o.reading, options);
  using Units = OptionList::Choices<std::string>;
  options.AddChoice("out-unit", o.unit, Units{{"mm", "mm"}, {"cm", "cm"}, {"m", "m"}}, "Length unit of a .trc output");
  options.Add("crop", o.crop_s, "Keep only this time span").Unit("s").Value("START,END");
  using Sides = OptionList::Choices<motion::Side>;
  options
      .AddChoice("leg", o.leg, Sides{{"left", motion::Side::kLeft}, {"right", motion::Side::kRight}},
                 "Leg that the knee angle is of: knee_angle_l or knee_angle_r (.mot)")
      .Otherwise("the one that lake track or lake gait found");
  options.Add("flexion-negative", o.flexion_negative,
              "Write the knee angle negative in flexion, as OpenSim's older models expect (.mot)");
}

Option& DescribeRate(double& rate_hz, OptionList& options) {
  return options.Add("rate", rate_hz, "Frame rate of files without times (DLTdv, DeepLabCut, SLEAP)")
      .Unit("Hz")
      .Positive()
      .Otherwise("none");
}

}  // namespace lake::exchange
