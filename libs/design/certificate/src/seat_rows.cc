#include "seat_rows.h"

namespace lake::certificate {

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

}  // namespace lake::certificate
