// The chapters of a study's report, each from what its steps wrote.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/linkage/wear.h"
#include "lake/report/report.h"
#include "lake/report/uncertain.h"
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

// A key of a summary ends in its unit, and the unit says with how many decimals its numbers are written where no
// interval is known, in sentences and tables alike: N with none, all others with one. What is made to measure (links,
// strokes) has two. With an interval: core/uncertain_text.h.
std::string UnitOf(const std::string& key);  // "mm/s" of "max_speed_mm_s"; empty where it has none
int DecimalsOf(const std::string& unit);
std::string Quantity(double value, const std::string& unit);           // "13.3 mm", "142.2°"
std::string QuantityAt(const Json& summary, const std::string& path);  // of the number there, in the unit of its key

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

// What stands before the first chapter: what is wrong and what to do first, the ways from the cheapest on, what forbids
// them, and the next steps; of a study without a design for the person MeasuredResult().
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
