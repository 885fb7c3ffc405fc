// The positions of markers, frame by frame: the output of tracking and the input of every later stage.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace lake::motion {

enum class SampleStatus {
  kMissing,   // no value
  kDetected,  // measured in this frame
  kFilled,    // not seen; inferred, with a larger sigma
};

std::string_view ToString(SampleStatus status);

enum class LengthUnit { kPx, kMm };

// "px" or "mm", as in the names of columns.
std::string_view ToString(LengthUnit unit);

struct MarkerSample {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // meaningless when missing
  double sigma = 0;                                    // one standard deviation per axis, unit of the position
  SampleStatus status = SampleStatus::kMissing;

  bool IsKnown() const { return status != SampleStatus::kMissing; }
};

struct MarkerTrack {
  std::string name;
  std::vector<MarkerSample> samples;  // one per frame of the recording
};

// Positions in px are in the image frame (x right, y down, distorted as recorded, centre of the top-left pixel at (0,
// 0)); in mm they are in the plane frame (x right in the image, y up).
struct MarkerRecording {
  LengthUnit unit = LengthUnit::kPx;
  std::vector<std::int64_t> frame;  // numbers of the whole file, from 0
  std::vector<double> time_s;       // presentation time stamps, increasing
  std::vector<MarkerTrack> markers;
  // 1 where technical markers replace the hidden knee, one value per frame: the column knee_rebuilt; empty: none do.
  std::vector<char> knee_rebuilt = {};

  std::size_t Frames() const { return frame.size(); }
  const MarkerTrack* Find(std::string_view name) const;  // nullptr if there is none
};

// The median distance of two markers over the frames in which both are known, in the recording's unit; NaN if there is
// none.
double MedianDistance(const MarkerRecording& recording, std::string_view marker, std::string_view other);

// The detected samples alone, without the inferred ones.
MarkerRecording Measurements(MarkerRecording recording);

// tracks.csv or trajectory.csv, by the recording's unit: frame,time_s, then per marker M_x_U,M_y_U,M_sigma_U,M_status.
void WriteMarkerCsv(const std::filesystem::path& path, const MarkerRecording& recording);

// trajectory.csv: a fit's estimates in those columns, and behind each marker's the measurement that the frame itself
// holds, M_raw_x_U,M_raw_y_U,M_raw_sigma_U, empty where there is none. Frames, markers and unit are the same in both.
void WriteTrajectoryCsv(const std::filesystem::path& path, const MarkerRecording& estimates,
                        const MarkerRecording& measurements);

// Which values to read from a table that holds both.
enum class MarkerValues {
  kMeasured,   // what further fits and filters start from; status detected or missing
  kEstimated,  // a fit's
};

// Reads either table; the columns' names give the unit. A table that holds one kind of values gives those. Tables of
// other programs may lack columns: without `frame`, frames count from 0; without M_status, an empty cell is a missing
// sample; without M_sigma_U, the sigma is 0 (unknown). Throws Error naming file, line and column, also for times that
// do not increase.
MarkerRecording ReadMarkerCsv(const std::filesystem::path& path, MarkerValues values = MarkerValues::kMeasured);

}  // namespace lake::motion
