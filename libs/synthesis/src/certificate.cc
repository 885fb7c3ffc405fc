#include "lake/synthesis/certificate.h"

#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <queue>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "range_bound.h"

namespace lake {
namespace {

using Clock = std::chrono::steady_clock;

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
// widest of all.
std::vector<OpenBox> Split(const RangeBound& range, const OpenBox& parent) {
  constexpr double kLowered_rad = 1e-9;
  const LinkBox root = range.Root();
  std::vector<OpenBox> best;
  double best_score = -1;
  for (std::size_t link = 1; link < parent.box.size(); ++link) {  // l1 is eliminated
    if (!(parent.box[link].Width() > 0)) continue;
    std::vector<OpenBox> halves = Halves(range, parent, link);
    const bool lowers = std::all_of(halves.begin(), halves.end(), [&](const OpenBox& half) {
      return half.bound_rad < parent.bound_rad - kLowered_rad;
    });
    const double width = parent.box[link].Width() / root[link].Width();  // at most 1
    const double score = lowers ? 1 + width : width;
    if (score > best_score) best_score = score, best = std::move(halves);
  }
  return best;
}

}  // namespace

void CertificateOptions::Check() const {
  if (!(gap_deg > 0)) throw Fail("the gap to certify must be above 0 deg, not {}", gap_deg);
  if (!(max_seconds > 0)) throw Fail("the time limit of the certificate must be above 0 s, not {}", max_seconds);
  if (threads < 1 || max_boxes < 1) throw Fail("the certificate needs at least one thread and one box");
}

Certificate CertifyRange(const SynthesisProblem& problem, double range_deg, const CertificateOptions& options) {
  problem.Check();
  options.Check();
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const RangeBound range(problem);
  const double target_rad = RadiansFromDegrees(range_deg + options.gap_deg);
  Progress progress("certificate", "boxes", std::nullopt, options.quiet);

  Certificate certificate;
  std::priority_queue<OpenBox> open;
  OpenBox root{std::numbers::pi, range.Root()};
  if (range.Contract(root.box)) open.push({range.UpperBound(root.box), root.box});
  certificate.feasible_set_empty = open.empty();
  while (!open.empty() && open.top().bound_rad > target_rad && seconds() < options.max_seconds &&
         static_cast<std::int64_t>(open.size()) < options.max_boxes) {
    ThrowIfInterrupted();
    constexpr std::size_t kBatch = 256;
    std::vector<OpenBox> batch;
    while (!open.empty() && batch.size() < kBatch && open.top().bound_rad > target_rad)
      batch.push_back(open.top()), open.pop();
    const auto work = [&](std::size_t first) {
      std::vector<OpenBox> halves;
      for (std::size_t i = first; i < batch.size(); i += options.threads)
        for (OpenBox& half : Split(range, batch[i])) halves.push_back(half);
      return halves;
    };
    std::vector<std::future<std::vector<OpenBox>>> parts;
    for (int thread = 1; thread < options.threads; ++thread)
      parts.push_back(std::async(std::launch::async, work, thread));
    for (OpenBox& half : work(0)) open.push(half);
    for (auto& part : parts)
      for (OpenBox& half : part.get()) open.push(half);
    certificate.boxes += static_cast<std::int64_t>(batch.size());
    progress.Advance(static_cast<std::int64_t>(batch.size()));
    if (open.empty()) certificate.feasible_set_empty = true;
  }
  certificate.upper_bound_deg = certificate.feasible_set_empty
                                    ? -std::numeric_limits<double>::infinity()
                                    : (Interval(open.top().bound_rad) * 180.0 / kPiInterval).upper;
  if (problem.max_angle_deg)
    certificate.upper_bound_deg = std::min(certificate.upper_bound_deg, *problem.max_angle_deg);
  certificate.gap_deg = certificate.upper_bound_deg - range_deg;
  certificate.reached = certificate.gap_deg <= options.gap_deg * (1 + 1e-12);
  certificate.seconds = seconds();
  return certificate;
}

}  // namespace lake
