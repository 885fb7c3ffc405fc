// A trial from any known file: what lake-gait, lake-compare and lake convert read.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/exchange/formats.h"
#include "lake/gait/leg_view.h"

namespace lake::exchange {

struct TrialOptions {
  std::map<std::string, std::string> names;  // own name → the file's; "A+B" is the middle of two markers
  std::optional<char> up;                    // x, y or z of a 3-D file; default: the file's own, TRC y, C3D z
  std::string forward;                       // "x", "+x", "-z", …; empty: the plane is fitted to the leg's motion
  // Of another trial (Trial), if this one is to be seen as that; no option.
  std::optional<Eigen::Matrix3d> plane_from_space = {};
  double mm_per_unit = 1;  // of files that do not say their unit
  double rate_hz = 0;      // of files without times (DLTdv, DeepLabCut, SLEAP)
  // Of a trajectory.csv, which holds both.
  motion::MarkerValues values = motion::MarkerValues::kMeasured;
  std::string view = {};  // the camera of a file with the points of several

  ReadOptions Reading() const { return {mm_per_unit, rate_hz, values, view}; }
};

// All but the rate, which only `lake convert` takes.
void Describe(TrialOptions& o, OptionList& options);
// What a file does not say, but for its unit: the vertical, which values of a trajectory.csv are read, the camera.
void DescribeReading(TrialOptions& o, OptionList& options);

// The camera of a file that holds several.
Option& DescribeView(std::string& view, OptionList& options);

// The unit of files that do not say theirs: its name, or its length in mm.
Option& DescribeUnit(const std::string& name, double& mm_per_unit, OptionList& options);

// An option that has no effect on a file of this kind.
struct UnusedOption {
  std::string option, why;  // "--unit", "its lengths are in mm"
};

// The given options among unit, vertical, rate and --smoothed that have no effect on this file or folder; none for a
// missing file.
std::vector<UnusedOption> UnusedOptions(const std::filesystem::path& path, const TrialOptions& options);

// Throws UsageError that names the first, if there is one, and why it has no effect on the file.
void CheckNoneIsUnused(const std::filesystem::path& path, const std::vector<UnusedOption>& unused);

struct Trial {
  std::filesystem::path file;         // that was read: of a folder, its trajectory.csv or tracks.csv
  motion::MarkerRecording recording;  // in the sagittal plane, or in px
  std::optional<double> mm_per_px;
  double pixel_aspect = 1;            // of a recording in px: width over height of a pixel, as a folder's summary says
  std::optional<bool> faces_right;    // known if `forward` was given
  std::optional<Eigen::Vector2d> up;  // in the plane, where a folder's own summary says it; else the plane's y
  std::optional<motion::Side> leg;    // as the markers' names in the file or a folder's own summary say
  bool known_sigmas = false;          // measurements whose sigmas hold, as a folder's own summary says
  double lasting_share = 0;           // of their errors, for some frames (gait::LegFitOptions), as it says, too
  std::optional<gait::PlaneSight> sight;  // of a recording in mm, as it says, too
  double out_of_plane_mm = 0;             // 3-D files: RMS of the leg's lateral movement
  // 3-D files: x and y of the plane from the file's axes, and its normal, towards the one who sees x to the right.
  std::optional<Eigen::Matrix3d> plane_from_space;
  // 3-D files whose points do not lie in one plane: each marker's lateral coordinate in each frame (to the right of a
  // person who faces along the plane), NaN where missing.
  std::map<std::string, std::vector<double>> lateral_mm;
  std::vector<ModelOutput> outputs;  // of another program's model, in the same frames
  std::vector<std::string> warnings;
};

// Width over height of the pixels that a table in px counts, as the summary beside it says; 1 where it says nothing.
// Throws Error naming the summary for a ratio that no pixel has.
double PixelAspectBeside(const std::filesystem::path& table);

// The key of the leg in summaries: left or right.
inline constexpr const char* kLegKey = "leg";
std::optional<motion::Side> LegInSummary(const Json& summary);

// Whatever ReadPoints (formats.h) reads. Three dimensions are projected onto the vertical plane that holds `forward`,
// or that fits the movement of the segments between ankle, knee and hip best, and a warning says so; Tracker's projects
// with a scale come in mm along their own axes. Throws Error: a file of an unknown kind, a name that is not in it (the
// message lists those that are).
Trial ReadTrial(const std::filesystem::path& path, const TrialOptions& options = {});

// 3-D points as read from a file, named by the options and seen from the side: kPlane, x along `options.forward`, the
// fitted direction (the fit needs the names ankle, knee and hip) or across the knee's axis where a lateral and a medial
// marker give it. The RMS lateral movement goes to `out_of_plane_mm`.
PointRecording ProjectOntoSagittalPlane(const PointRecording& read, const TrialOptions& options,
                                        const std::filesystem::path& path, double* out_of_plane_mm);

// 3-D points in the axes that OpenSim's models stand in: x where the subject faces (`options.forward`), y up, z to the
// right. Throws UsageError if `forward` is the vertical.
PointRecording PointsFacing(const PointRecording& points, const TrialOptions& options);

// Only the named points, under their own names.
PointRecording RenamePoints(const PointRecording& points, const std::map<std::string, std::string>& names,
                            const std::filesystem::path& path);

}  // namespace lake::exchange
