// What the figures of a recording mean for who records: good, poor, unfit, with what to change.
#pragma once

#include <string>
#include <vector>

#include "lake/tracking/recording_quality.h"

namespace lake::tracking {

enum class Verdict { kGood, kPoor, kUnfit, kNotJudged };

std::string ToString(Verdict verdict);  // good, poor, unfit, not judged

// One property that was judged, with what to change where it is not good.
struct CheckItem {
  std::string name;   // of the figure in the summary
  std::string shown;  // the figure in words
  Verdict verdict = Verdict::kGood;
  std::string advice = {};
};

// What every program says of a knee that is hidden in more than this part of the frames.
inline constexpr double kOftenHidden = 0.1;
inline constexpr const char* kHiddenKneeAdvice =
    "two markers on the shank would replace it (the manual's page on the hidden knee)";
inline constexpr const char* kRebuiltKneeAdvice =
    "lake track --technical shank=A,B rebuilds it if two of the further markers are on the shank (the manual's page on "
    "the hidden knee)";

// Every figure of a check, judged.
std::vector<CheckItem> JudgeRecording(const RecordingCheck& check, int markers);

}  // namespace lake::tracking
