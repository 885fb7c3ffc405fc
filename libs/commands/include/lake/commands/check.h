// The work of lake-check: what a recording is worth, before the subject goes home.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/tracking/recording_quality.h"

namespace lake::commands {

struct CheckRunOptions {
  std::filesystem::path video;
  tracking::RecordingCheckOptions check;
};

void Describe(CheckRunOptions& o, OptionList& options);

enum class Verdict { kGood, kPoor, kUnfit, kNotJudged };

// One thing that was looked at, with what to change where it is not good.
struct CheckItem {
  std::string name;   // of the figure in the summary
  std::string shown;  // the figure in words
  Verdict verdict = Verdict::kGood;
  std::string advice = {};
};

// Every figure of a check, judged.
std::vector<CheckItem> JudgeRecording(const tracking::RecordingCheck& check, int markers);

// The figures of markers, as both lake-check's and lake-track's summary have them.
Json FiguresJson(const tracking::MarkerFigures& figures);

// Writes check.png and returns the results for the summary; `fit` there is false if anything makes the recording unfit,
// or if its markers cannot be named and so are not judged.
Json RunCheck(const CheckRunOptions& options, Run& run);

// What a person wants to read of the summary.
std::string CheckReport(const Json& summary);

}  // namespace lake::commands
