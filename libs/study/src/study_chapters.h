// The chapters of a study's report, each from what its steps wrote.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/report/report.h"
#include "lake/study/study_file.h"

namespace lake::study {

// The folders of a study's steps: of those that it has, whatever else stands there.
class StudyResults {
 public:
  StudyResults(std::filesystem::path out, std::vector<std::string> steps)
      : out_(std::move(out)), steps_(std::move(steps)) {}

  const std::filesystem::path& Folder() const { return out_; }
  bool Has(const std::string& step) const;
  bool HasFile(const std::filesystem::path& name) const;  // "exo/overlay.mp4"
  Json Summary(const std::string& step) const { return ReadJsonFile(out_ / step / "summary.json"); }

  // The picture, if it was made.
  void AddPicture(const std::filesystem::path& name, const std::string& alt, const std::string& caption,
                  report::Width width, report::Section& section) const;

 private:
  std::filesystem::path out_;
  std::vector<std::string> steps_;
};

// One rounding for each unit where no interval is known, in sentences and tables alike: % and s have two decimals, mm,
// ° and N m one, N and the place of a joint none. What is made to measure (links, strokes) has two. With an interval:
// core/uncertain_text.h.
int DecimalsOf(const std::string& unit);
std::string Quantity(double value, const std::string& unit);  // "13.3 mm", "142.2°"

report::LineChart PathsChart(const StudyResults& results);

// The Pareto front of the design's own program; empty if none was asked for.
struct TradePoint {
  double range_deg = 0, misalignment_percent = 0;
};
std::vector<TradePoint> OwnFront(const Json& redesign);

// Over the used range, N; NaN where it has no bound.
double LargestForce(const StudyResults& results);

// What the stroke program's board is given, in the folder of results; nullopt where the study has no stroke program.
std::optional<report::Files::File> FirmwareOf(const StudyFile& study);

// In the folder of results: a frame of the exoskeleton trial with both knees and the distance between them.
inline constexpr const char* kKneesPicture = "comparison/knees.png";
std::string KneesPictureAlt(const StudyResults& results);

// The knee's peak moment at one pace against that at another: the same body and path, so that what is uncertain of each
// (the headline's interval) cancels.
double PeakPercent(const Json& pace, const Json& other);

// Along the measured path in the program's time the ground's force leaves the foot.
bool NeedsHolding(const StudyResults& results, const Json& redesign);

// What stands before the first chapter (first_screen.h); of a study without a design for the person MeasuredResult().
report::Section ResultChapter(const StudyFile& study, const StudyResults& results);
report::Section MeasuredResult(const StudyResults& results);
// What a terminal shows of it, a line each: where the joint is and what to do first, then the misalignment of each way;
// empty without a design for the person.
std::string ResultText(const StudyFile& study, const StudyResults& results);
// The same in words, with every number; needs a design for the person.
report::Section DetailsChapter(const StudyFile& study, const StudyResults& results);
report::Section TrialsChapter(const StudyFile& study, const StudyResults& results);
report::Section MisalignmentChapter(const StudyFile& study, const StudyResults& results);
report::Section OptimumChapter(const StudyFile& study, const StudyResults& results);
report::Section RedesignChapter(const StudyFile& study, const StudyResults& results);
report::Section StrokeChapter(const StudyFile& study, const StudyResults& results);
report::Section LoadsChapter(const StudyFile& study, const StudyResults& results);
report::Section SimulationChapter(const StudyFile& study, const StudyResults& results);

}  // namespace lake::study
