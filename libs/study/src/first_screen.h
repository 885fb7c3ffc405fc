// What a study's report says before its first chapter: what is wrong and what to do first, the ways from the
// cheapest on, what forbids them, and the next steps.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "lake/linkage/wear.h"
#include "lake/report/uncertain.h"
#include "study_chapters.h"

namespace lake::study {

// "2.6 % (1.4–4.0)", "4.3° (3.1–5.5)", rounded to the interval; `otherwise`: decimals where there is none.
std::string UncertainText(const report::Uncertain& of, const std::string& unit, int otherwise = 1);

// Of a prediction: how far the knee angle is from the human's, RMS, as well as the human's own mean is known.
report::Uncertain KneeAngleError(const StudyResults& results, const Json& design);

// "rise" or, of a person who walks, "stride".
std::string RepetitionIn(const StudyResults& results);

// Onset to standing in the exoskeleton trial, s: the mean of its rises.
report::Uncertain RecordedRise(const StudyResults& results);

// How well it is known where the joint is against the knee, half of the 95 % interval along x and y of the shank, mm:
// where one trial shows both, with all sources of the comparison's budget; else by the offset between the trials.
// NaN without a comparison.
Eigen::Vector2d PlacementHalfWidth(const StudyResults& results);

// One way to wear an exoskeleton: as it was worn, repaired, or built anew.
struct Way {
  std::string name;
  std::string design;                      // its key in the redesign's summary
  report::Uncertain misalignment_percent;  // RMS of the path difference
  report::Uncertain rise_s;
  std::string build;                            // what has to be built for it
  bool misalignment_is_limit = false;           // asked for in the study file, and reached
  bool time_is_limit = false;                   // likewise
  bool time_is_set = false;                     // by a stroke program: exact
  bool mends_joint = false;                     // moves a joint that is known to be off the knee
  std::optional<linkage::WearCheck> on_body{};  // absent: not known
};
// Which limits the worn links do not keep, with what they have of each; empty if they keep all, or are not known.
std::string WhyNewLinks(const StudyFile& study, const StudyResults& results);

// As worn, with the joint moved, new; those that there are.
std::vector<Way> WaysOf(const StudyFile& study, const StudyResults& results);

}  // namespace lake::study
