// The work of lake-check: the quality of a recording, before the subject goes home.
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

enum class Verdict { kGood, kPoor, kUnfit };

// One figure, its verdict, and advice where it is not good.
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

// A recording as it was measured and judged.
struct JudgedRecording {
  tracking::RecordingCheck check;
  std::vector<CheckItem> items;

  bool IsFit() const;  // nothing makes it unfit
};

// For the summary.
Json JudgedJson(const JudgedRecording& recording);

// Writes check.png.
JudgedRecording RunCheck(const CheckRunOptions& options, Run& run);

}  // namespace lake::commands
