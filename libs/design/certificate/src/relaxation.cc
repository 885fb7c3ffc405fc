#include "relaxation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lake/certificate/certificate.h"

namespace lake::certificate {
namespace {

Interval KappaOfAngle(double theta_rad) {
  return kPiInterval - Interval(theta_rad);
}

// The rows of a requirement under a load.
void AddRows(const problem::Requirement& requirement, const problem::PoseLoad& load, std::vector<PoseRow>& rows) {
  const problem::LimitInfo& info = requirement.Info();
  const Interval limit =
      info.is_sine ? Sin(Interval(requirement.limit) / 180.0 * kPiInterval) : Interval(requirement.limit);
  const double scale = info.is_relative ? requirement.limit : 1;
  problem::VisitLimit(requirement.row, [&](const auto& row) {
    row.parts(load, [&](const char*, auto ratio) {
      rows.emplace_back([=](const SlopeQuantities& pose) {
        return problem::MarginOf(info, limit, problem::Ratio<Slope>(ratio(pose)), scale);
      });
    });
  });
}

}  // namespace

SeatRows::SeatRows(const problem::SynthesisProblem& problem)
    : wear_(problem.Wear()), clearance_mm_(*problem.clearances.seat_mm) {
  const Interval theta = problem.SeatedAngle_rad();
  const linkage::Seat seat = linkage::SeatOf(person::BodyOf(problem.clearances.body), wear_);
  const auto& [forward, up] = wear_.placement_mm;  // linkage::PutOnBody
  surface_mm_ = seat.surface_mm + forward * Cos(theta) + up * Sin(theta);
  edge_mm_ = seat.edge_mm + forward * Sin(theta) - up * Cos(theta);
}

SeatRows::Place SeatRows::PlaceOf(linkage::Pin pin, const PoseSlopes& pose) const {
  const auto& l = pose.links;
  const auto [x, y] = problem::PinAt<Slope>(pin, l.data(), {l[1] * Sin(pose.phi), l[1] * Cos(pose.phi)},
                                            {l[3] * Sin(pose.kappa), l[3] * Cos(pose.kappa)});
  return {surface_mm_ - x, edge_mm_ - y};
}

Interval SeatRows::Directions(const Place& from, const Place& to, double distance_mm) {
  constexpr int kCells = 64;
  Interval directions{1, 0};
  for (int cell = 0; cell < kCells; ++cell) {
    const Interval direction = Interval(cell, cell + 1) * kPiInterval / Interval(2 * kCells);
    const auto may_be_clear = [&](const Place& pin) {
      return (Cos(direction) * pin.below.value + Sin(direction) * pin.behind.value).upper >= distance_mm;
    };
    if (may_be_clear(from) && may_be_clear(to))
      directions = directions.IsEmpty() ? direction : Hull(directions, direction);
  }
  return directions;
}

std::optional<std::vector<SeatRows::Row>> SeatRows::Over(const PoseSlopes& pose, const PoseSlopes& at_anchor) const {
  std::vector<Row> rows;
  for (const linkage::WornPart& part : linkage::WornPartsOf(wear_)) {
    const Interval distance = Interval(clearance_mm_) + part.radius_mm;
    const Interval directions = Directions(PlaceOf(part.from, pose), PlaceOf(part.to, pose), distance.lower);
    if (directions.IsEmpty()) return std::nullopt;
    const Interval middle = directions.Middle(), cosine = Cos(middle), sine = Sin(middle);
    for (const linkage::Pin pin : {part.from, part.to}) {
      const Place place = PlaceOf(pin, pose), at = PlaceOf(pin, at_anchor);
      // What another of the directions may have more.
      const Interval more =
          (Cos(directions) - cosine) * place.below.value + (Sin(directions) - sine) * place.behind.value;
      const Interval offset = more.upper - distance;
      rows.push_back({cosine * place.below + sine * place.behind + offset,
                      cosine * at.below.value + sine * at.behind.value + offset});
    }
  }
  return rows;
}

// Cuts of one region, and which of them give how much away.
struct Relaxation::Cuts {
  std::vector<Cut> all;
  std::optional<Cut> goal;
  bool has_bar_angle = false;
  std::array<double, kAxes> phi_spread{};  // then: of phi at d_min, by the links

  void Add(std::optional<Cut> cut) {
    if (cut) all.push_back(*cut);
  }
};

Relaxation::Relaxation(const problem::SynthesisProblem& problem, const RangeBound& range, double floor_rad)
    : range_(range), d_min_mm_(problem.d_min_mm), floor_rad_(floor_rad), margins_(range.Margin()) {
  AddPlaces(problem, floor_rad);
}

std::vector<PoseRow> Relaxation::RowsOverRange(const problem::SynthesisProblem& problem) const {
  std::vector<PoseRow> rows;
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem))
    if (requirement.IsFamily() && !requirement.along_profile && requirement.Info().place != problem::Place::kSeated)
      AddRows(requirement, problem.ConstantLoad(), rows);
  return rows;
}

namespace {

// No straighter than standing.
double StandingRad(const problem::SynthesisProblem& problem) {
  return std::max(0.0, (Interval(problem.standing_deg) / 180.0 * kPiInterval).upper);
}

}  // namespace

// A design that can stand has, at every knee angle from standing to the floor, a pose of its used range.
void Relaxation::AddPlaces(const problem::SynthesisProblem& problem, double floor_rad) {
  const std::vector<problem::Requirement> requirements = problem::RequirementsOf(problem);
  const bool stands = std::ranges::any_of(requirements, [](const auto& each) { return each.NeedsStanding(); });
  const double standing_rad = StandingRad(problem);
  if (!stands) return;
  at_shortest_ = RowsOverRange(problem);
  // Every design that satisfies the problem can sit, whatever the floor. Where a placement is sought, the seat says
  // nothing about the links alone.
  if (problem.clearances.seat_mm && !problem.clearances.placement_reach_mm) seat_.emplace(problem);
  seated_.kappa_rad = KappaOfAngle(problem.SeatedAngle_rad());
  for (const problem::Requirement& requirement : requirements)
    if (requirement.Info().place == problem::Place::kSeated) AddRows(requirement, problem.ConstantLoad(), seated_.rows);
  if (!(floor_rad > standing_rad)) return;
  constexpr int kSteps = 4;
  for (int i = 0; i <= kSteps; ++i) {
    const double theta = std::min(floor_rad, std::lerp(standing_rad, floor_rad, static_cast<double>(i) / kSteps));
    Place place{KappaOfAngle(theta), RowsOverRange(problem)};
    for (const problem::Requirement& requirement : requirements)  // past standing the stroke is only longer
      if (i == 0 && requirement.Info().place == problem::Place::kStanding)
        AddRows(requirement, problem.ConstantLoad(), place.rows);
    if (i == kSteps)
      place.rows.emplace_back(
          [d_min_mm = problem.d_min_mm](const SlopeQuantities& pose) { return pose.Stroke_mm() - d_min_mm; });
    places_.push_back(place);
  }
  if (problem.HasLoadProfile()) AddSamples(problem, requirements, floor_rad);
}

void Relaxation::AddSamples(const problem::SynthesisProblem& problem,
                            const std::vector<problem::Requirement>& requirements, double floor_rad) {
  constexpr std::size_t kMostSamples = 8;
  std::vector<const problem::LoadSample*> samples;
  for (const problem::LoadSample& sample : problem.profile->samples)
    if (sample.knee_rad >= StandingRad(problem) && sample.knee_rad <= floor_rad) samples.push_back(&sample);
  const std::size_t step = 1 + samples.size() / kMostSamples;
  for (std::size_t i = 0; i < samples.size(); i += step) {
    Place place{KappaOfAngle(samples[i]->knee_rad), {}};
    const problem::PoseLoad load = problem.LoadAt(*samples[i]);
    for (const problem::Requirement& requirement : requirements)
      if (requirement.along_profile && IsInBound(requirement, problem)) AddRows(requirement, load, place.rows);
    places_.push_back(place);
  }
}

bool Relaxation::IsInSet(const AxisPoint& at) const {
  for (const problem::Requirement& row : range_.Linear()) {
    Interval sum = 0;
    for (std::size_t i = 0; i < 6; ++i)
      if (row.Info().coefficients[i] != 0) sum = sum + Interval(row.Info().coefficients[i]) * at[i];
    if (!(sum.lower >= row.limit - kRounding_mm)) return false;
  }
  const Interval l7 = Sqrt(Square(Interval(at[kL5])) + Square(Interval(at[kL6])));
  return (Interval(at[kL2]) + d_min_mm_ - l7).lower >= margins_.singularity_mm - kRounding_mm;
}

std::optional<AxisPoint> Relaxation::AnchorIn(const AxisBox& box, const AxisPoint& towards) const {
  AxisPoint at = towards;
  const auto move = [&](std::size_t axis, double by) {
    const double before = at[axis];
    at[axis] = std::clamp(before + by, box[axis].lower, box[axis].upper);
    return at[axis] - before;
  };
  // Moves of the same length along each link of a row that can still move.
  const auto meet = [&](const problem::Requirement& row) {
    double missing = row.limit;
    for (std::size_t i = 0; i < 6; ++i) missing -= row.Info().coefficients[i] * at[i];
    for (int pass = 0; pass < 3 && missing > 0; ++pass) {
      int free = 0;
      for (std::size_t i = 0; i < 6; ++i) {
        const double end = row.Info().coefficients[i] > 0 ? box[i].upper : box[i].lower;
        free += row.Info().coefficients[i] != 0 && at[i] != end;
      }
      if (free == 0) return;
      const double step = missing / free;
      for (std::size_t i = 0; i < 6; ++i)
        if (row.Info().coefficients[i] != 0)
          missing -= row.Info().coefficients[i] * move(i, row.Info().coefficients[i] * step);
    }
  };
  constexpr int kSweeps = 40;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    if (IsInSet(at)) return at;
    for (const problem::Requirement& row : range_.Linear()) meet(row);
    const double l7 = std::hypot(at[kL5], at[kL6]);
    const double missing = l7 + margins_.singularity_mm - at[kL2] - d_min_mm_;
    if (missing <= 0) continue;
    for (const auto& [axis, slope] : {std::pair{kL2, 1.0}, {kL5, -at[kL5] / l7}, {kL6, -at[kL6] / l7}})
      move(axis, missing * slope);
  }
  return IsInSet(at) ? std::optional(at) : std::nullopt;
}

void Relaxation::AddLinear(const AxisBox& box, Cuts& cuts) const {
  for (const problem::Requirement& row : range_.Linear()) {
    Cut cut;
    Interval constant = -row.limit;
    for (std::size_t i = 0; i < 6; ++i) {
      constant = constant + Interval(row.Info().coefficients[i]) * box[i].lower;
      cut.coefficients[i] = row.Info().coefficients[i];
    }
    cut.constant = constant.upper;
    cuts.all.push_back(cut);
  }
}

// False if a row holds nowhere in the region.
bool Relaxation::AddPose(const PoseSlopes& pose, const std::optional<PoseSlopes>& at_anchor,
                         const std::vector<PoseRow>& rows, const Region& region, Cuts& cuts) const {
  const SlopeQuantities quantities(pose);
  for (const PoseRow& row : rows) {
    const Slope slope = row(quantities);
    if (slope.value.upper < 0) return false;
    if (slope.value.lower < 0 && at_anchor)
      cuts.Add(UpperCut(slope, row(SlopeQuantities(*at_anchor)).value, *region.anchor, region.box));
  }
  return true;
}

namespace {

// The region shrunk to one of its points.
Region PointOf(const Region& region, const AxisPoint& at) {
  return {BoxOf(at), region.anchor};
}

// theta <= pi - phi, or kappa >= phi: as l1 >= l4 - (l2 - l3) and l4 >= l2,
//   cos beta2 = (l8^2 + l4^2 - l1^2) / (2 l8 l4) <= (l8^2 + l2^2 - l3^2) / (2 l8 l2) = cos(phi - beta1).
Cut GoalOfBarAngle(const AxisBox& box) {
  Cut goal;
  goal.constant = (kPiInterval - box[kPhi].lower).upper;
  goal.coefficients[kPhi] = -1;
  return goal;
}

LinkBox LinksOf(const AxisBox& box) {
  LinkBox links;
  std::copy_n(box.begin(), links.size(), links.begin());
  return links;
}

}  // namespace

// The angle and length of the mount, which are smooth everywhere: expanded about any point.
void Relaxation::AddMount(const AxisBox& box, const Interval& phi_rad, const AxisPoint& at, Cuts& cuts) const {
  const AxisBox point = BoxOf(at);
  const Slope axis = Slope::Axis(kPhi, box[kPhi]), mount = MountAngle(box);
  const double least_between = std::max(0.0, (Interval(phi_rad.lower) - mount.value).lower);
  cuts.Add(UpperCut(axis - mount, at[kPhi] - MountAngle(point).value - least_between, at, box));
  cuts.Add(UpperCut(ActuatorSlack(box, d_min_mm_), ActuatorSlack(point, d_min_mm_).value - margins_.singularity_mm, at,
                    box));
}

// phi at d_min is what the links make it.
void Relaxation::AddBarAngle(const Region& region, const Interval& phi_rad, Cuts& cuts) const {
  const AxisBox& box = region.box;
  const Slope axis = Slope::Axis(kPhi, box[kPhi]), bar = BarAngleAtShortestStroke(box, phi_rad, d_min_mm_, margins_);
  const Interval bar_at = BarAngleOfPoint(BoxOf(*region.anchor), d_min_mm_);
  if (bar_at.IsEmpty()) return;
  const Interval above_at = Interval((*region.anchor)[kPhi]) - bar_at;
  const auto above = UpperCut(axis - bar, above_at, *region.anchor, box);
  cuts.Add(above);
  cuts.Add(UpperCut(bar - axis, -above_at, *region.anchor, box));
  cuts.has_bar_angle = above.has_value();
  if (above) cuts.phi_spread = above->spread;
}

bool Relaxation::AddSeated(const Region& region, const std::optional<Region>& point, Cuts& cuts) const {
  // Sitting may be the pose at d_min itself, so the stroke is not held against it: rounding would cut designs off.
  const auto pose = PoseAtAngle(region, seated_.kappa_rad, 0, margins_);
  if (!pose) return false;
  const auto pose_at = point ? PoseAtAngle(*point, seated_.kappa_rad, 0, margins_) : std::nullopt;
  if (!AddPose(*pose, pose_at, seated_.rows, region, cuts)) return false;
  if (!seat_) return true;
  const auto rows = seat_->Over(*pose, pose_at.value_or(*pose));
  if (!rows) return false;
  for (const SeatRows::Row& row : *rows) {
    if (row.over_box.value.upper < 0) return false;
    if (row.over_box.value.lower < 0 && pose_at)
      cuts.Add(UpperCut(row.over_box, row.at_anchor, *region.anchor, region.box));
  }
  return true;
}

// False if nothing of the region is left.
bool Relaxation::AddCuts(const Region& region, const Interval& phi_rad, Cuts& cuts) const {
  std::optional<Region> point;
  if (region.anchor) {
    point = PointOf(region, *region.anchor);
    AddBarAngle(region, phi_rad, cuts);
  }
  const auto pose = PoseAtShortestStroke(region, d_min_mm_, margins_);
  if (!pose) return false;
  const auto pose_at = point ? PoseAtShortestStroke(*point, d_min_mm_, margins_) : std::nullopt;
  if (pose_at)
    cuts.goal =
        UpperCut(Slope(kPiInterval) - pose->kappa, kPiInterval - pose_at->kappa.value, *region.anchor, region.box);
  if (!AddPose(*pose, pose_at, at_shortest_, region, cuts)) return false;
  if ((seat_ || !seated_.rows.empty()) && !AddSeated(region, point, cuts)) return false;
  for (const Place& place : places_) {
    const auto used = PoseAtAngle(region, place.kappa_rad, d_min_mm_, margins_);
    if (!used) return false;
    const auto used_at = point ? PoseAtAngle(*point, place.kappa_rad, 0, margins_) : std::nullopt;
    if (!AddPose(*used, used_at, place.rows, region, cuts)) return false;
  }
  return true;
}

// The link by which the bound gives most away. That of phi goes to the links that it follows from: as their cut has it,
// or by their widths where phi is known no better than by its own range.
std::size_t Relaxation::WidestOf(const Cuts& cuts, const LinearBound& bound, const AxisBox& box) const {
  std::array<double, kAxes> given = cuts.goal->spread;
  for (std::size_t i = 0; i < cuts.all.size(); ++i)
    for (std::size_t j = 0; j < kAxes; ++j) given[j] += bound.multipliers[i] * cuts.all[i].spread[j];
  std::array<double, kAxes> shares = cuts.phi_spread;
  if (!cuts.has_bar_angle) {
    given[kPhi] += std::abs(cuts.goal->coefficients[kPhi]) * box[kPhi].Width();
    for (const Axis j : {kL2, kL5, kL6}) shares[j] = box[j].Width();
  }
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (std::size_t j = 0; j < kPhi && total > 0; ++j) given[j] += given[kPhi] * shares[j] / total;
  return static_cast<std::size_t>(std::max_element(given.begin(), given.begin() + kPhi) - given.begin());
}

// Removes what violates a cut, or is below the floor; false if nothing is left.
bool Relaxation::ContractBy(const Cuts& cuts, const LinearBound& bound, AxisBox& box) const {
  const AxisBox cut_for = box;
  if (std::isfinite(floor_rad_))
    for (Cut goal : {bound.combined, *cuts.goal}) {
      goal.constant = (Interval(goal.constant) - floor_rad_).upper;
      if (!Contract(goal, cut_for, box)) return false;
    }
  for (const Cut& cut : cuts.all)
    if (!Contract(cut, cut_for, box)) return false;
  LinkBox links = LinksOf(box);
  if (!range_.Contract(links)) return false;
  std::copy(links.begin(), links.end(), box.begin());
  return true;
}

std::optional<Relaxation::Result> Relaxation::Examine(const LinkBox& links) const {
  Result result{links, range_.UpperBound(links), std::nullopt};
  if (result.bound_rad < floor_rad_) return std::nullopt;
  AxisBox box;
  std::copy(links.begin(), links.end(), box.begin());
  box[kPhi] = {0, kPiInterval.upper};
  AxisPoint towards;
  for (std::size_t i = 0; i < kAxes; ++i) towards[i] = box[i].Middle();
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const RangeBound::BarAngle angle = range_.BarAngleOf(result.box);
    // Past phi = pi, which the relaxation does not follow, theta <= 0.
    if (!(floor_rad_ > 0) && angle.phi.upper > kPiInterval.lower) return result;
    const Interval phi_of_links{angle.least, angle.phi.upper};
    box[kPhi] = Intersection(box[kPhi], phi_of_links);
    if (box[kPhi].IsEmpty()) return std::nullopt;

    for (std::size_t i = 0; i < kAxes; ++i) towards[i] = std::clamp(towards[i], box[i].lower, box[i].upper);
    const Region region{box, AnchorIn(box, towards)};
    Cuts cuts;
    AddLinear(box, cuts);
    AddMount(box, phi_of_links, region.anchor.value_or(towards), cuts);
    if (!AddCuts(region, phi_of_links, cuts)) return std::nullopt;
    if (!cuts.goal) cuts.goal = GoalOfBarAngle(box);
    const LinearBound bound = BoundBy(*cuts.goal, cuts.all, box);
    if (bound.upper == -kInfinity) return std::nullopt;  // whatever the floor
    result.bound_rad = std::min(result.bound_rad, bound.upper);
    if (result.bound_rad < floor_rad_) return std::nullopt;
    result.widest = WidestOf(cuts, bound, box);

    const AxisBox before = box;
    if (!ContractBy(cuts, bound, box)) return std::nullopt;
    result.box = LinksOf(box);
    double shrink = 1;
    for (std::size_t i = 0; i < kAxes; ++i) {
      towards[i] = before[i].lower + bound.optimum[i] * before[i].Width();
      if (before[i].Width() > 0) shrink = std::min(shrink, box[i].Width() / before[i].Width());
    }
    constexpr double kHardlySmaller = 0.8;  // the second round is worth it for its better anchor alone
    if (round > 0 && shrink > kHardlySmaller) break;
  }
  return result;
}

}  // namespace lake::certificate
