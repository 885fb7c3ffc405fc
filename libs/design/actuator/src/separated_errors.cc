#include "lake/actuator/separated_errors.h"

#include <algorithm>
#include <cmath>

#include "best_shift.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::actuator {
namespace {

constexpr std::size_t kLeastSamples = 10;

struct Size {
  double rms = 0, most = 0;
};

Size SizeOf(const std::vector<double>& errors) {
  Size size{RootMeanSquare(errors)};
  for (const double error : errors) size.most = std::max(size.most, std::abs(error));
  return size;
}

void RequireEnough(const StrokeSeries& strokes) {
  if (strokes.time_s.size() < kLeastSamples)
    throw Fail("{}: {} measured strokes; at least {} are needed", strokes.name, strokes.time_s.size(), kLeastSamples);
}

std::vector<double> StrokeErrors(const StrokeSchedule& plan, const StrokeSeries& strokes, double start_s) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < strokes.time_s.size(); ++i) {
    const double time_s = strokes.time_s[i] - start_s;
    if (time_s >= 0 && time_s <= plan.Duration()) errors.push_back(strokes.stroke_mm[i] - plan.StrokeAt(time_s));
  }
  return errors;
}

// Against all samples, at rest before the start and after the end, so that no overlap is too short to count.
double RmsAt(const StrokeSchedule& plan, const StrokeSeries& strokes, double start_s) {
  double sum = 0;
  for (std::size_t i = 0; i < strokes.time_s.size(); ++i)
    sum += std::pow(strokes.stroke_mm[i] - plan.StrokeAt(strokes.time_s[i] - start_s), 2);
  return std::sqrt(sum / static_cast<double>(strokes.time_s.size()));
}

double BestStart(const StrokeSchedule& plan, const StrokeSeries& strokes) {
  const auto rms_at = [&](double start_s) { return RmsAt(plan, strokes, start_s); };
  return LeastErrorShift(strokes.time_s.front() - plan.Duration(), strokes.time_s.back(), rms_at, rms_at);
}

void FillActuator(const StrokeSchedule& plan, const StrokeSeries& strokes, SeparatedErrors& separated) {
  separated.program_start_s = BestStart(plan, strokes);
  const std::vector<double> errors = StrokeErrors(plan, strokes, separated.program_start_s);
  if (errors.size() < kLeastSamples)
    throw Fail("{}: {} measured strokes within the program; at least {} are needed", strokes.name, errors.size(),
               kLeastSamples);
  const Size size = SizeOf(errors);
  separated.actuator_rms_mm = size.rms;
  separated.actuator_max_mm = size.most;
  separated.actuator_end_mm = errors.back();
}

double Interpolated(const StrokeSeries& strokes, double time_s) {
  const auto after = std::upper_bound(strokes.time_s.begin() + 1, strokes.time_s.end() - 1, time_s);
  const auto i = static_cast<std::size_t>(after - strokes.time_s.begin());
  const double part = (time_s - strokes.time_s[i - 1]) / (strokes.time_s[i] - strokes.time_s[i - 1]);
  return std::lerp(strokes.stroke_mm[i - 1], strokes.stroke_mm[i], std::clamp(part, 0.0, 1.0));
}

}  // namespace

SeparatedErrors SeparateErrorsByLog(const StrokeSchedule& plan, const StrokeSeries& strokes,
                                    const std::vector<AngleSample>& angles) {
  RequireEnough(strokes);
  StrokeSchedule measured = plan;
  measured.knots.clear();
  for (std::size_t i = 0; i < strokes.time_s.size(); ++i)
    measured.knots.push_back({strokes.time_s[i] - strokes.time_s.front(), strokes.stroke_mm[i]});
  const Validation linkage = ValidatePrototype(measured, angles);
  SeparatedErrors separated{.linkage_rms_deg = linkage.rms_deg, .linkage_max_deg = linkage.max_deg};
  FillActuator(plan, strokes, separated);
  return separated;
}

SeparatedErrors SeparateErrorsByVideo(const StrokeSchedule& plan, const StrokeSeries& lengths,
                                      const std::vector<AngleSample>& angles) {
  RequireEnough(lengths);
  std::vector<std::pair<double, double>> pairs;  // length, angle
  std::vector<double> offsets;
  for (const AngleSample& angle : angles) {
    if (angle.time_s < lengths.time_s.front() || angle.time_s > lengths.time_s.back()) continue;
    const auto stroke = linkage::StrokeForAngle(plan.links, plan.limits.used, RadiansFromDegrees(angle.knee_deg));
    const double length = Interpolated(lengths, angle.time_s);
    pairs.emplace_back(length, angle.knee_deg);
    if (stroke) offsets.push_back(length - *stroke);
  }
  if (offsets.size() < kLeastSamples)
    throw Fail("{}: {} frames have a length and an angle that the linkage has; at least {} are needed", lengths.name,
               offsets.size(), kLeastSamples);
  SeparatedErrors separated;
  separated.stroke_offset_mm = Median(offsets);
  std::vector<double> errors;
  for (const auto& [length, angle] : pairs) {
    const double stroke = std::clamp(length - separated.stroke_offset_mm, plan.limits.used.stroke.lower_mm,
                                     plan.limits.used.stroke.upper_mm);
    errors.push_back(angle - KneeDegAt(plan.links, stroke));
  }
  const Size size = SizeOf(errors);
  separated.linkage_rms_deg = size.rms;
  separated.linkage_max_deg = size.most;
  StrokeSeries strokes = lengths;
  for (double& stroke : strokes.stroke_mm) stroke -= separated.stroke_offset_mm;
  FillActuator(plan, strokes, separated);
  return separated;
}

StrokeSeries ReadMeasuredStrokes(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  if (!table.Has("measured_mm"))
    throw Fail("{}: no column measured_mm; a firmware without potentiometer measures no stroke (--feedback pot)",
               path.string());
  const std::size_t time = table.Column("time_s"), state = table.Column("state"), stroke = table.Column("measured_mm");
  StrokeSeries strokes{path.string(), {}, {}};
  for (std::size_t i = 0; i < table.Rows(); ++i) {
    if (table.Text(i, state) != "running") continue;
    strokes.time_s.push_back(table.RequiredNumber(i, time));
    strokes.stroke_mm.push_back(table.RequiredNumber(i, stroke));
  }
  return strokes;
}

}  // namespace lake::actuator
