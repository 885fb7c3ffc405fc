#include "lake/exchange/convert_options.h"

namespace lake::exchange {

void Describe(ConvertOptions& o, OptionList& options) {
  Describe(o.reading, options);
  DescribeRate(o.reading.rate_hz, options);
  using Units = OptionList::Choices<std::string>;
  options.AddChoice("out-unit", o.unit, Units{{"mm", "mm"}, {"cm", "cm"}, {"m", "m"}}, "Of a .trc that is written");
  options.Add("crop", o.crop_s, "Keep these seconds only").Value("START,END");
  options.Add("flexion-negative", o.flexion_negative, "Knee angle of a .mot as OpenSim's older models have it");
}

Option& DescribeRate(double& rate_hz, OptionList& options) {
  return options.Add("rate", rate_hz, "Of files without times (DLTdv)").Unit("Hz").NotNegative();
}

}  // namespace lake::exchange
