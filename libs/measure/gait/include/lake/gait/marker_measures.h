// Angles, distances and speeds of any markers, with their standard deviations: for who measures something else than a
// leg.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/gait/leg_view.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

struct MarkerMeasure {
  enum class Kind {
    kAngle,     // at the second of three markers, 0 to 180 degrees
    kDistance,  // of two
    kSpeed,     // of one
  };
  Kind kind = Kind::kAngle;
  std::string name;
  std::vector<std::string> markers;
};

// --angle NAME=A,B,C, --distance NAME=A,B, --speed NAME=A, each any number of times.
void Describe(std::vector<MarkerMeasure>& measures, OptionList& options);

// "angle", "distance", "speed": the options' names.
const char* ToString(MarkerMeasure::Kind kind);

// From {"kind": "angle", "name": "knee", "markers": ["ankle", "knee", "hip"]}, and back. Throws UsageError for another
// kind or number of markers, or an empty name.
MarkerMeasure MeasureFrom(const Json& json);
Json MeasureJson(const MarkerMeasure& measure);

// What is measured of markers that are no leg where nobody says it: each one's speed, the distance of each two that
// follow one another, and the angle of each three.
std::vector<MarkerMeasure> UsualMeasures(const std::vector<std::string>& markers);

std::vector<std::string> MarkerNames(const motion::MarkerRecording& recording);

// Throws UsageError for a marker that is not among these.
void CheckMarkers(const std::vector<MarkerMeasure>& measures, const std::vector<std::string>& markers);

// Every known sample in the plane frame, as it was recorded.
motion::MarkerRecording InPlane(const motion::MarkerRecording& recorded, const LegView& view);

// One value per frame; NaN where one of the markers was not seen. The SDs are those of the smoothed paths, from the
// markers' sigmas, or, where the file does not say them, from the scatter of their paths.
struct MeasuredCourse {
  MarkerMeasure measure;
  std::vector<double> value = {}, sd = {};  // degrees, the recording's unit, or that per s
  std::vector<double> rate = {},
                      rate_sd = {};  // of angles, degrees per s; of distances, the unit per s; of speeds empty
};

// Of a recording in the plane, px or mm. Each marker's path is smoothed by itself (smoothing_spline.h); what was filled
// in is not used.
std::vector<MeasuredCourse> MeasureMarkers(const motion::MarkerRecording& recording,
                                           const std::vector<MarkerMeasure>& measures);

// measures.csv: frame,time_s, then NAME_deg,NAME_sd_deg,NAME_deg_s,NAME_sd_deg_s of an angle,
// NAME_U,NAME_sd_U,NAME_U_s, NAME_sd_U_s of a distance, NAME_U_s,NAME_sd_U_s of a speed, U the recording's unit.
void WriteMeasuresCsv(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::vector<MeasuredCourse>& courses);

// By name: smallest, largest, mean and when, for summaries.
Json MeasuresJson(const motion::MarkerRecording& recording, const std::vector<MeasuredCourse>& courses);

// "deg", "mm", "px", "mm_s", "px_s".
std::string UnitOf(const MeasuredCourse& course, motion::LengthUnit unit);
std::string UnitForPeople(const std::string& unit_of_column);  // °, mm, mm/s

}  // namespace lake::gait
