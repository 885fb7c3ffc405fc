#include "lake/certificate/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/progress.h"
#include "range_bound.h"

namespace lake::certificate {
namespace {

struct OpenBox {
  double bound_rad;
  LinkBox box;
  bool operator<(const OpenBox& other) const { return bound_rad < other.bound_rad; }
};

// The two halves along one link, contracted and bounded; those that are empty are left out.
std::vector<OpenBox> Halves(const RangeBound& range, const OpenBox& parent, std::size_t link) {
  std::vector<OpenBox> halves;
  const double middle = parent.box[link].Middle();
  for (const bool low : {true, false}) {
    OpenBox half = parent;
    (low ? half.box[link].upper : half.box[link].lower) = middle;
    if (!range.Contract(half.box)) continue;
    half.bound_rad = std::min(parent.bound_rad, range.UpperBound(half.box));
    halves.push_back(half);
  }
  return halves;
}

// Splits along the relatively widest of the links whose split lowers both halves' bounds; if there is none, along the
// widest of all. nullopt: no link can be split.
std::optional<std::vector<OpenBox>> Split(const RangeBound& range, const OpenBox& parent) {
  constexpr double kLowered_rad = 1e-9;
  const LinkBox root = range.Root();
  std::optional<std::vector<OpenBox>> best;
  double best_score = -1;
  for (std::size_t link = 1; link < parent.box.size(); ++link) {  // l1 is eliminated
    const Interval& length = parent.box[link];
    if (!(length.lower < length.Middle() && length.Middle() < length.upper)) continue;
    std::vector<OpenBox> halves = Halves(range, parent, link);
    const bool lowers = std::all_of(halves.begin(), halves.end(), [&](const OpenBox& half) {
      return half.bound_rad < parent.bound_rad - kLowered_rad;
    });
    const double width = length.Width() / root[link].Width();  // at most 1
    const double score = lowers ? 1 + width : width;
    if (score > best_score) {
      best_score = score;
      best = std::move(halves);
    }
  }
  return best;
}

// Best-first. Boxes are taken in batches of one size and put back in the order in which they were taken, so that the
// outcome does not depend on the number of threads.
class Search {
 public:
  Search(const problem::SynthesisProblem& problem, double target_rad, const CertificateOptions& options)
      : range_(problem), target_rad_(target_rad), options_(options) {}

  void Run() {
    Progress progress("certificate", "boxes", std::nullopt, options_.quiet);
    OpenBox root{std::numbers::pi, range_.Root()};
    if (range_.Contract(root.box)) open_.push({range_.UpperBound(root.box), root.box});
    boxes_ = 1;
    while (CanLowerTheBound() && boxes_ < options_.max_boxes) {
      ThrowIfInterrupted();
      const std::vector<OpenBox> batch = NextBatch();
      const std::vector<Halved> halved = SplitAll(batch);
      for (std::size_t i = 0; i < batch.size(); ++i) Keep(batch[i], halved[i]);
      boxes_ += static_cast<std::int64_t>(batch.size());
      progress.Advance(static_cast<std::int64_t>(batch.size()));
    }
  }

  std::int64_t Boxes() const { return boxes_; }
  // -infinity if no box is left: nothing is feasible.
  double Bound_rad() const { return open_.empty() ? leaf_rad_ : std::max(leaf_rad_, open_.top().bound_rad); }

 private:
  using Halved = std::optional<std::vector<OpenBox>>;

  bool IsWorthSplitting(const OpenBox& box) const { return box.bound_rad > std::max(target_rad_, leaf_rad_); }
  bool CanLowerTheBound() const { return !open_.empty() && IsWorthSplitting(open_.top()); }

  std::vector<OpenBox> NextBatch() {
    constexpr std::int64_t kBatch = 256;
    const auto size = static_cast<std::size_t>(std::min(kBatch, options_.max_boxes - boxes_));
    std::vector<OpenBox> batch;
    while (batch.size() < size && CanLowerTheBound()) {
      batch.push_back(open_.top());
      open_.pop();
    }
    return batch;
  }

  std::vector<Halved> SplitAll(const std::vector<OpenBox>& batch) const {
    std::vector<Halved> halved(batch.size());
    ForEachInThreads(batch.size(), options_.threads, [&](std::size_t i) { halved[i] = Split(range_, batch[i]); });
    return halved;
  }

  void Keep(const OpenBox& parent, const Halved& halved) {
    if (!halved)
      leaf_rad_ = std::max(leaf_rad_, parent.bound_rad);
    else
      for (const OpenBox& half : *halved) open_.push(half);
  }

  const RangeBound range_;
  const double target_rad_;
  const CertificateOptions& options_;
  std::priority_queue<OpenBox> open_;
  double leaf_rad_ = -std::numeric_limits<double>::infinity();  // the highest bound of the boxes that cannot be split
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
  if (threads < 1 || max_boxes < 1) throw Fail("the certificate needs at least one thread and one box");
}

Certificate CertifyRange(const problem::SynthesisProblem& problem, std::optional<double> range_deg,
                         const CertificateOptions& options) {
  problem.Check();
  options.Check();
  if (range_deg && !std::isfinite(*range_deg)) throw Fail("certificate: a known range of {} deg", *range_deg);
  Search search(problem, range_deg ? RadiansFromDegrees(*range_deg + options.gap_deg) : -kInfinity, options);
  search.Run();

  Certificate certificate;
  certificate.boxes = search.Boxes();
  certificate.feasible_set_empty = search.Bound_rad() == -kInfinity;
  certificate.upper_bound_deg =
      certificate.feasible_set_empty ? -kInfinity : (Interval(search.Bound_rad()) * 180.0 / kPiInterval).upper;
  if (problem.max_angle_deg)
    certificate.upper_bound_deg = std::min(certificate.upper_bound_deg, *problem.max_angle_deg);
  if (range_deg) CheckAgainstKnown(certificate.upper_bound_deg, *range_deg);
  certificate.gap_deg = certificate.upper_bound_deg - range_deg.value_or(std::numeric_limits<double>::quiet_NaN());
  certificate.reached = certificate.gap_deg <= options.gap_deg * (1 + 1e-12);
  return certificate;
}

}  // namespace lake::certificate
