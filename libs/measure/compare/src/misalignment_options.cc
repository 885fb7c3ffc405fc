#include "lake/compare/misalignment_options.h"

#include "lake/core/plausible.h"

namespace lake::compare {

void DescribeReplacement(double& sd_mm, OptionList& options) {
  options
      .Add("replacement-sd", sd_mm,
           "Standard deviation, per axis, of putting a marker back on its place on the skin between trials; 0 if both "
           "are in one recording")
      .Unit("mm")
      .Between(kPlausibleMarkerDeviation.low, kPlausibleMarkerDeviation.high);
}

void Describe(MisalignmentOptions& o, OptionList& options) {
  DescribeReplacement(o.replacement_sd_mm, options);
}

void DescribeJointAt(std::array<double, 2>& joint_at_mm, OptionList& options) {
  options
      .Add("joint-at", joint_at_mm,
           "Where that marker is on the exoskeleton, seen from the joint's axis: anterior, up along the shank")
      .Unit("mm")
      .Value("X,Y")
      .Between(kPlausibleJointMarker.low, kPlausibleJointMarker.high);
}

}  // namespace lake::compare
