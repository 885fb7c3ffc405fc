#include "second_trial.h"

namespace lake::commands {

void DescribeSecond(const std::string& prefix, const std::string& whose, TrialReading first, TrialReading second,
                    OptionList& options) {
  const std::string map = prefix + "-map", unit = prefix + "-unit";
  options.Add(map, second.file.names, "--map of " + whose).Value("NAME=MARKER,...").Otherwise("as --map");
  exchange::DescribeUnit(unit, second.file.mm_per_unit, options).Otherwise("as --unit");
  gait::DescribeOther(prefix, whose, second.picture, options);
  options.Check([=](const OptionList& list) {
    exchange::TrialOptions file = first.file;
    if (list.IsGiven(map)) file.names = second.file.names;
    if (list.IsGiven(unit)) file.mm_per_unit = second.file.mm_per_unit;
    second.file = file;
    if (!second.picture.IsGiven()) second.picture = first.picture;
    second.picture.depths = first.picture.depths;
  });
}

}  // namespace lake::commands
