#include "lake/certificate/certificate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/progress.h"
#include "relaxation.h"

namespace lake::certificate {
namespace {

// Below the known range by more than CheckAgainstKnown() allows, so that it sees where nothing as good is left.
constexpr double kBelowKnown_deg = 1.5 * kKnownRangeTolerance_deg;

struct OpenBox {
  double bound_rad;
  LinkBox box;
  std::optional<std::size_t> widest;
  bool operator<(const OpenBox& other) const { return bound_rad < other.bound_rad; }
};

std::optional<OpenBox> Examined(const Relaxation& relaxation, const LinkBox& box, double parent_rad) {
  const std::optional<Relaxation::Result> result = relaxation.Examine(box);
  if (!result) return std::nullopt;
  return OpenBox{std::min(parent_rad, result->bound_rad), result->box, result->widest};
}

bool CanBeSplit(const Interval& length) {
  return length.lower < length.Middle() && length.Middle() < length.upper;
}

// Best-first. Boxes are taken in batches of one size and put back in the order in which they were taken, so that the
// outcome does not depend on the number of threads.
class Search {
 public:
  Search(const problem::SynthesisProblem& problem, std::optional<double> range_deg, const CertificateOptions& options)
      : range_(problem),
        floor_rad_(range_deg ? RadiansFromDegrees(*range_deg - kBelowKnown_deg) : -kInfinity),
        target_rad_(range_deg ? RadiansFromDegrees(*range_deg + options.gap_deg) : -kInfinity),
        relaxation_(problem, range_, floor_rad_),
        options_(options) {
    if (const auto& cap_deg = problem.limits["max_angle_deg"])
      cap_rad_ = (Interval(*cap_deg) / 180.0 * kPiInterval).upper;
    if (range_deg) best_ = fmt::format(", best {:.4f}°", *range_deg);
  }

  Certificate::End Run() {
    Progress progress("certificate", "boxes", options_.max_boxes, options_.quiet);
    LinkBox root = range_.Root();
    if (range_.Contract(root)) {
      if (const auto whole = Examined(relaxation_, root, cap_rad_))
        open_.push(*whole);
      else
        Close(floor_rad_);
    }
    boxes_ = 1;
    const auto start = std::chrono::steady_clock::now();
    while (CanLowerTheBound()) {
      if (boxes_ >= options_.max_boxes) return Certificate::End::kBoxes;
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      if (options_.time_s && taken.count() > *options_.time_s) return Certificate::End::kTime;
      ThrowIfInterrupted();
      const std::vector<OpenBox> batch = NextBatch();
      for (const Halved& halved : SplitAll(batch)) Keep(halved);
      boxes_ += static_cast<std::int64_t>(batch.size());
      progress.Note(fmt::format("bound {:.4f}°{}", DegreesFromRadians(BoundRad()), best_));
      progress.Advance(static_cast<std::int64_t>(batch.size()));
    }
    const bool is_known = std::isfinite(target_rad_);
    return is_known && BoundRad() <= target_rad_ ? Certificate::End::kGap : Certificate::End::kNothingToSplit;
  }

  std::int64_t Boxes() const { return boxes_; }
  // -infinity if no box is left: nothing is feasible.
  double BoundRad() const { return open_.empty() ? closed_rad_ : std::max(closed_rad_, open_.top().bound_rad); }

 private:
  struct Halved {
    std::vector<OpenBox> open;
    double closed_rad;  // bound of what is not split further
  };

  bool IsWorthSplitting(const OpenBox& box) const { return box.bound_rad > std::max(target_rad_, closed_rad_); }
  bool CanLowerTheBound() const { return !open_.empty() && IsWorthSplitting(open_.top()); }
  void Close(double bound_rad) { closed_rad_ = std::max(closed_rad_, bound_rad); }

  std::vector<OpenBox> NextBatch() {
    constexpr std::int64_t kBatch = 64;
    const auto size = static_cast<std::size_t>(std::min(kBatch, options_.max_boxes - boxes_));
    std::vector<OpenBox> batch;
    while (batch.size() < size && CanLowerTheBound()) {
      batch.push_back(open_.top());
      open_.pop();
    }
    return batch;
  }

  // A box is split along the link that contributes most to the bound's excess, or else along the relatively widest.
  std::optional<std::size_t> AxisOf(const OpenBox& parent) const {
    if (parent.widest && CanBeSplit(parent.box[*parent.widest])) return parent.widest;
    std::optional<std::size_t> axis;
    double most = 0;
    for (std::size_t link = 0; link < parent.box.size(); ++link) {
      if (!CanBeSplit(parent.box[link])) continue;
      const double width = parent.box[link].Width() / range_.Root()[link].Width();
      if (width <= most) continue;
      most = width;
      axis = link;
    }
    return axis;
  }

  Halved Split(const OpenBox& parent) const {
    const std::optional<std::size_t> axis = AxisOf(parent);
    if (!axis) return {{}, parent.bound_rad};
    Halved halved{{}, floor_rad_};  // what is below is cut off
    const double middle = parent.box[*axis].Middle();
    for (const bool low : {true, false}) {
      LinkBox half = parent.box;
      (low ? half[*axis].upper : half[*axis].lower) = middle;
      if (!range_.Contract(half)) continue;
      if (const auto examined = Examined(relaxation_, half, parent.bound_rad)) halved.open.push_back(*examined);
    }
    return halved;
  }

  std::vector<Halved> SplitAll(const std::vector<OpenBox>& batch) const {
    std::vector<Halved> halved(batch.size());
    ForEachInThreads(batch.size(), options_.threads, [&](std::size_t i) { halved[i] = Split(batch[i]); });
    return halved;
  }

  void Keep(const Halved& halved) {
    Close(halved.closed_rad);
    for (const OpenBox& half : halved.open) open_.push(half);
  }

  const RangeBound range_;
  const double floor_rad_, target_rad_;
  const Relaxation relaxation_;
  const CertificateOptions& options_;
  double cap_rad_ = kPiInterval.upper;
  std::string best_;
  std::priority_queue<OpenBox> open_;
  double closed_rad_ = -kInfinity;  // the highest bound of what is not split
  std::int64_t boxes_ = 0;
};

void CheckAgainstKnown(double upper_bound_deg, double range_deg) {
  if (upper_bound_deg >= range_deg - kKnownRangeTolerance_deg) return;
  throw Fail(
      "certificate: no design within the limits has more than {:.6f} deg, yet one with {:.6f} deg is known; one of the "
      "two is wrong, so nothing is certified: evaluate the known design with the same problem",
      upper_bound_deg, range_deg);
}

}  // namespace

void CertificateOptions::Check() const {
  if (!(gap_deg > 0)) throw Fail("the gap to certify must be above 0 deg, not {}", gap_deg);
  if (time_s && !(*time_s > 0)) throw Fail("the certificate needs a time above 0 s, not {}", *time_s);
  if (threads < 1 || max_boxes < 1) throw Fail("the certificate needs at least one thread and one box");
}

bool IsInBound(const problem::Requirement& requirement, const problem::SynthesisProblem& problem) {
  const problem::LimitInfo& info = requirement.Info();
  if (info.obstacle == problem::Obstacle::kSeat) return !problem.clearances.placement_reach_mm;
  if (info.place == problem::Place::kAtRest && requirement.along_profile) return problem.rests_anywhere;
  return !requirement.IsClearance() && info.place != problem::Place::kProfile;
}

std::vector<std::string> NotInBound(const problem::SynthesisProblem& problem) {
  std::vector<std::string> names;
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem))
    if (!IsInBound(requirement, problem)) names.emplace_back(requirement.name);
  if (problem.robust_mm) names.emplace_back("tolerance");
  return names;
}

Certificate CertifyRange(const problem::SynthesisProblem& problem, std::optional<double> range_deg,
                         const CertificateOptions& options) {
  problem.Check();
  options.Check();
  if (range_deg && !std::isfinite(*range_deg)) throw Fail("certificate: a known range of {} deg", *range_deg);
  Search search(problem, range_deg, options);

  Certificate certificate;
  certificate.end = search.Run();
  certificate.boxes = search.Boxes();
  certificate.feasible_set_empty = search.BoundRad() == -kInfinity;
  certificate.upper_bound_deg =
      certificate.feasible_set_empty ? -kInfinity : (Interval(search.BoundRad()) * 180.0 / kPiInterval).upper;
  if (const auto& cap_deg = problem.limits["max_angle_deg"])
    certificate.upper_bound_deg = std::min(certificate.upper_bound_deg, *cap_deg);
  if (range_deg) CheckAgainstKnown(certificate.upper_bound_deg, *range_deg);
  certificate.range_deg = range_deg;
  certificate.gap_deg = certificate.upper_bound_deg - range_deg.value_or(std::numeric_limits<double>::quiet_NaN());
  certificate.reached = certificate.gap_deg <= options.gap_deg * (1 + 1e-12);
  return certificate;
}

}  // namespace lake::certificate
