#include "lake/actuator/prototype_validation.h"

#include <ceres/tiny_solver.h>

#include <Eigen/Core>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <span>

#include "lake/actuator/duty_calibration.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {
namespace {

constexpr std::size_t kFewestSamples = 10;  // of angles or strokes
constexpr double kLeastCovered = 0.25;
constexpr double kLeastChange_deg = 5;

// The shift within low .. high with the least error: on a grid of `coarse`, then about its best by Brent's method on
// `fine`, as precision is relative: some nanoseconds. Throws Interrupted on a signal.
template <typename Coarse, typename Fine>
double LeastErrorShift(double low, double high, const Coarse& coarse, const Fine& fine) {
  constexpr int kSteps = 1000;
  const double step = (high - low) / kSteps;
  double best = low, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    ThrowIfInterrupted();
    const double shift = low + i * step;
    if (const double error = coarse(shift); error < least) {
      least = error;
      best = shift;
    }
  }
  constexpr int kBits = std::numeric_limits<double>::digits / 2;
  const auto fine_about = [&](double later) { return fine(best + later); };
  return best + boost::math::tools::brent_find_minima(fine_about, -step, step, kBits).first;
}

void CheckSamples(const std::vector<AngleSample>& samples) {
  if (samples.size() < kFewestSamples)
    throw Fail("{} frames with a knee angle; the comparison needs at least {}", samples.size(), kFewestSamples);
  double low = samples.front().knee_deg, high = low;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && !(samples[i].time_s > samples[i - 1].time_s))
      throw Fail("the times must ascend; {} s after {} s does not", samples[i].time_s, samples[i - 1].time_s);
    low = std::min(low, samples[i].knee_deg);
    high = std::max(high, samples[i].knee_deg);
  }
  if (high - low < kLeastChange_deg)
    throw Fail("the tracked knee angle changes by {}° only, which cannot be aligned with a program",
               SignificantText(high - low, 3));
}

// A prototype that runs its program open loop, `factor` as fast as planned, from `shift_s` on.
struct OwnSpeed {
  double shift_s, factor = 1;
};

double AngleOf(const StrokeSchedule& schedule, const OwnSpeed& own, double time_s) {
  const double start = schedule.knots.front().stroke_mm;
  const double stroke = start + own.factor * (schedule.StrokeAt(time_s - own.shift_s) - start);
  const linkage::StrokeRange& used = schedule.limits.used.stroke;
  return KneeDegAt(schedule.links, std::clamp(stroke, used.lower_mm, used.upper_mm));
}

std::vector<double> ErrorsOf(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples,
                             const OwnSpeed& own) {
  std::vector<double> errors;
  errors.reserve(samples.size());
  for (const AngleSample& sample : samples) errors.push_back(sample.knee_deg - AngleOf(schedule, own, sample.time_s));
  return errors;
}

// Evenly thinned, for the coarse search.
std::vector<AngleSample> Few(const std::vector<AngleSample>& samples) {
  constexpr std::size_t kMost = 200;
  const std::size_t step = samples.size() / kMost + 1;
  std::vector<AngleSample> few;
  for (std::size_t i = 0; i < samples.size(); i += step) few.push_back(samples[i]);
  return few;
}

// The shift with the least of `size` of the errors.
double BestShift(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples,
                 double (*size)(std::span<const double>)) {
  const std::vector<AngleSample> few = Few(samples);
  return LeastErrorShift(
      samples.front().time_s - schedule.Duration(), samples.back().time_s,
      [&](double shift) { return size(ErrorsOf(schedule, few, {shift})); },
      [&](double shift) { return size(ErrorsOf(schedule, samples, {shift})); });
}

// The best shift when the measured angle may have a constant offset.
void FitOffset(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples, Validation& v) {
  const double shift = BestShift(schedule, samples, StandardDeviation);
  const std::vector<double> errors = ErrorsOf(schedule, samples, {shift});
  v.offset_deg = Mean(errors);
  v.rms_with_offset_deg = StandardDeviation(errors);
}

// The errors over start and speed, with differences for derivatives, as ceres::TinySolver asks for them.
struct OwnSpeedErrors {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 2 };
  const StrokeSchedule& schedule;
  const std::vector<AngleSample>& samples;

  static OwnSpeed From(const double* x) { return {x[0], std::clamp(x[1], 0.1, 10.0)}; }
  int NumResiduals() const { return static_cast<int>(samples.size()); }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    ThrowIfInterrupted();
    constexpr double kStep_s = 1e-3, kStep = 1e-4;
    const auto errors_of = [&](const OwnSpeed& own) -> Eigen::VectorXd {
      const std::vector<double> errors = ErrorsOf(schedule, samples, own);
      return Eigen::Map<const Eigen::VectorXd>(errors.data(), NumResiduals());
    };
    const OwnSpeed own = From(x);
    Eigen::Map<Eigen::VectorXd> errors(residuals, NumResiduals());
    errors = errors_of(own);
    if (!jacobian) return true;
    Eigen::Map<Eigen::MatrixX2d> slopes(jacobian, NumResiduals(), 2);
    slopes.col(0) = (errors_of({own.shift_s + kStep_s, own.factor}) - errors) / kStep_s;
    slopes.col(1) = (errors_of({own.shift_s, own.factor + kStep}) - errors) / kStep;
    return true;
  }
};

OwnSpeed FitOwnSpeed(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples, const OwnSpeed& start) {
  Eigen::Vector2d best(start.shift_s, start.factor);
  ceres::TinySolver<OwnSpeedErrors>().Solve({schedule, samples}, &best);
  return OwnSpeedErrors::From(best.data());
}

// Two starts, as a slow prototype that is aligned at its planned speed may sit in a valley of its own.
void FitTravel(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples, Validation& v) {
  double least = std::numeric_limits<double>::infinity();
  OwnSpeed best{};
  for (const double shift_s : {v.shift_s, BestShift(schedule, samples, StandardDeviation)}) {
    const OwnSpeed own = FitOwnSpeed(schedule, samples, {shift_s});
    const double rms = RootMeanSquare(ErrorsOf(schedule, samples, own));
    if (rms < least) {
      least = rms;
      best = own;
    }
  }
  std::vector<AngleSample> moving;
  for (const AngleSample& sample : samples)
    if (const double t = sample.time_s - best.shift_s; t >= 0 && t <= schedule.Duration()) moving.push_back(sample);
  v.travel_factor = best.factor;
  v.start_with_factor_s = best.shift_s;
  v.rms_with_factor_deg = RootMeanSquare(ErrorsOf(schedule, moving.empty() ? samples : moving, best));
  v.drift_mm = (best.factor - 1) * (schedule.knots.back().stroke_mm - schedule.knots.front().stroke_mm);
}

void Summarise(Validation& v) {
  std::vector<double> errors;
  for (const ValidatedSample& sample : v.samples) {
    if (!sample.moving) continue;
    errors.push_back(sample.Error());
    if (std::abs(sample.Error()) > v.max_deg) {
      v.max_deg = std::abs(sample.Error());
      v.max_time_s = sample.time_s;
    }
  }
  v.rms_deg = RootMeanSquare(errors);
}

// Strokes that the measured angles stand for, over time; the ends are left out, where noise leaves the range.
void MeasureSpeed(const StrokeSchedule& schedule, Validation& v) {
  v.speed_mm_s = v.speed_se_mm_s = std::numeric_limits<double>::quiet_NaN();
  if (schedule.knots.size() != 2) return;
  std::vector<double> times, strokes;
  for (const ValidatedSample& sample : v.samples) {
    const double part = sample.program_time_s / schedule.Duration();
    if (part < 0.1 || part > 0.9) continue;
    const auto stroke =
        linkage::StrokeForAngle(schedule.links, schedule.limits.used, RadiansFromDegrees(sample.measured_deg));
    if (stroke) {
      times.push_back(sample.time_s);
      strokes.push_back(*stroke);
    }
  }
  const RobustSlope fit = FitRobustSlope(times, strokes);
  v.speed_mm_s = fit.slope;
  v.speed_se_mm_s = fit.standard_error;
}

struct Size {
  double rms = 0, most = 0;
};

Size SizeOf(const std::vector<double>& errors) {
  Size size{RootMeanSquare(errors)};
  for (const double error : errors) size.most = std::max(size.most, std::abs(error));
  return size;
}

void RequireEnough(const StrokeSeries& strokes) {
  if (strokes.knots.size() < kFewestSamples)
    throw Fail("{}: {} measured strokes; at least {} are needed", strokes.name, strokes.knots.size(), kFewestSamples);
}

// Of all strokes, or of those within the program alone, which begins at `start_s`.
std::vector<double> StrokeErrors(const StrokeSchedule& plan, const StrokeSeries& strokes, double start_s, bool all) {
  std::vector<double> errors;
  for (const linkage::StrokeProgram::Knot& knot : strokes.knots)
    if (const double time_s = knot.time_s - start_s; all || (time_s >= 0 && time_s <= plan.Duration()))
      errors.push_back(knot.stroke_mm - plan.StrokeAt(time_s));
  return errors;
}

// By all strokes, at rest before the start and after the end, so that no overlap is too short to count.
double BestStart(const StrokeSchedule& plan, const StrokeSeries& strokes) {
  const auto rms_at = [&](double start_s) { return RootMeanSquare(StrokeErrors(plan, strokes, start_s, true)); };
  return LeastErrorShift(strokes.knots.front().time_s - plan.Duration(), strokes.knots.back().time_s, rms_at, rms_at);
}

void FillActuator(const StrokeSchedule& plan, const StrokeSeries& strokes, SeparatedErrors& separated) {
  separated.program_start_s = BestStart(plan, strokes);
  const std::vector<double> errors = StrokeErrors(plan, strokes, separated.program_start_s, false);
  if (errors.size() < kFewestSamples)
    throw Fail("{}: {} measured strokes within the program; at least {} are needed", strokes.name, errors.size(),
               kFewestSamples);
  const Size size = SizeOf(errors);
  separated.actuator_rms_mm = size.rms;
  separated.actuator_max_mm = size.most;
  separated.actuator_end_mm = errors.back();
}

}  // namespace

Validation ValidatePrototype(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples) {
  CheckSamples(samples);
  Validation v;
  v.shift_s = BestShift(schedule, samples, RootMeanSquare);
  for (const AngleSample& sample : samples) {
    const double program_time = sample.time_s - v.shift_s;
    const double stroke = schedule.StrokeAt(program_time);
    v.samples.push_back({.time_s = sample.time_s,
                         .program_time_s = program_time,
                         .stroke_mm = stroke,
                         .predicted_deg = KneeDegAt(schedule.links, stroke),
                         .measured_deg = sample.knee_deg,
                         .moving = program_time >= 0 && program_time <= schedule.Duration()});
  }
  const double seen =
      std::min(schedule.Duration(), v.samples.back().program_time_s) - std::max(0.0, v.samples.front().program_time_s);
  v.covered = std::max(0.0, seen) / schedule.Duration();
  if (v.covered < kLeastCovered)
    throw Fail("where the video fits best it shows {:.0f} % of the program of {} s; is the speed right?",
               100 * v.covered, SignificantText(schedule.Duration(), 3));
  Summarise(v);
  FitOffset(schedule, samples, v);
  FitTravel(schedule, samples, v);
  MeasureSpeed(schedule, v);
  return v;
}

Verdict Judge(const Validation& validation, double tolerance_deg) {
  if (validation.rms_deg <= tolerance_deg) return Verdict::kFollows;
  return validation.rms_with_factor_deg <= tolerance_deg ? Verdict::kOtherSpeed : Verdict::kOtherAngles;
}

void WriteValidationCsv(const std::filesystem::path& path, const Validation& validation) {
  CsvWriter table(
      {"time_s", "program_time_s", "stroke_mm", "predicted_knee_deg", "measured_knee_deg", "error_deg", "moving"});
  for (const ValidatedSample& s : validation.samples)
    table.AddRow(s.time_s, s.program_time_s, s.stroke_mm, s.predicted_deg, s.measured_deg, s.Error(), s.moving);
  table.Write(path);
}

SeparatedErrors SeparateErrorsByLog(const StrokeSchedule& plan, const StrokeSeries& strokes,
                                    const std::vector<AngleSample>& angles) {
  RequireEnough(strokes);
  StrokeSchedule measured = plan;
  measured.knots = strokes.knots;
  for (auto& knot : measured.knots) knot.time_s -= strokes.knots.front().time_s;
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
    if (angle.time_s < lengths.knots.front().time_s || angle.time_s > lengths.knots.back().time_s) continue;
    const auto stroke = linkage::StrokeForAngle(plan.links, plan.limits.used, RadiansFromDegrees(angle.knee_deg));
    const double length = linkage::StrokeAt(lengths.knots, angle.time_s);
    pairs.emplace_back(length, angle.knee_deg);
    if (stroke) offsets.push_back(length - *stroke);
  }
  if (offsets.size() < kFewestSamples)
    throw Fail("{}: {} frames have a length and an angle that the linkage has; at least {} are needed", lengths.name,
               offsets.size(), kFewestSamples);
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
  for (auto& knot : strokes.knots) knot.stroke_mm -= separated.stroke_offset_mm;
  FillActuator(plan, strokes, separated);
  return separated;
}

StrokeSeries ReadMeasuredStrokes(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  if (!table.Has("measured_mm"))
    throw Fail("{}: no column measured_mm; a firmware without potentiometer measures no stroke (--feedback pot)",
               path.string());
  const std::size_t time = table.Column("time_s"), state = table.Column("state"), stroke = table.Column("measured_mm");
  StrokeSeries strokes{path.string(), {}};
  for (std::size_t i = 0; i < table.Rows(); ++i)
    if (table.Text(i, state) == "running")
      strokes.knots.push_back({table.RequiredNumber(i, time), table.RequiredNumber(i, stroke)});
  return strokes;
}

}  // namespace lake::actuator
