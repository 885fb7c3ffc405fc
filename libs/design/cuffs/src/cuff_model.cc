#include "lake/cuffs/cuff_model.h"

#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <locale>
#include <sstream>
#include <tuple>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "segment_axes.h"

namespace lake::cuffs {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

// Unknowns: how far the hinge moves from where it would be on the shank (leg frame, mm), and how far the thigh's and
// the shank's link turn against their segments (rad, forward).
constexpr int kUnknowns = 4;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using SlipRows = Eigen::Matrix<double, 2, kUnknowns>;

// A turn forward moves what is above forward, and what is in front down.
Matrix2d TurnForward(double rad) {
  return AxesOf(DegreesFromRadians(rad));
}

struct Link {
  Matrix2d axes;
  int turn;            // which unknown is its turn
  double side;         // +1: above the knee
  Vector2d hinge_mm;   // against the knee, in the segment's axes
  Vector2d offset_mm;  // how far its hinge is from the shank's before the links move, in the leg frame
  double mass_kg;
  const std::vector<Cuff>& cuffs;

  // In the segment's axes.
  Vector2d FromHinge(const Cuff& cuff) const { return Vector2d(0, side * cuff.from_knee_mm) - hinge_mm; }

  // Half way from the hinge to the outermost cuff.
  Vector2d CentreOfMass() const { return FromHinge(*std::ranges::max_element(cuffs, {}, &Cuff::from_knee_mm)) / 2; }
};

// How a point of a link moves against its segment, in the leg frame: how far, per unknown, and twice per turn.
struct Movement {
  Vector2d mm;
  SlipRows per_unknown;
  Vector2d per_turn_turn;
};

Movement MovementOf(const Link& link, const Vector2d& from_hinge_mm, const Vector& pose) {
  const Vector2d from_hinge = link.axes * from_hinge_mm, turned = TurnForward(pose[link.turn]) * from_hinge;
  Movement movement{pose.head<2>() + link.offset_mm + turned - from_hinge, SlipRows::Zero(), -turned};
  movement.per_unknown.leftCols<2>().setIdentity();
  movement.per_unknown.col(link.turn) = Vector2d(turned.y(), -turned.x());
  return movement;
}

// At a pose, with its derivatives.
struct Energy {
  double n_mm = 0;
  Vector gradient = Vector::Zero();
  Matrix hessian = Matrix::Zero();
  Matrix without_turns = Matrix::Zero();  // the Hessian of movements that are linear in the turns: never negative

  // What yields by `movement` against these forces per mm.
  void AddSpring(const Movement& movement, const Matrix2d& stiffness, int turn) {
    const Vector2d force = stiffness * movement.mm;
    n_mm += movement.mm.dot(force) / 2;
    gradient += movement.per_unknown.transpose() * force;
    const Matrix linear = movement.per_unknown.transpose() * stiffness * movement.per_unknown;
    without_turns += linear;
    hessian += linear;
    hessian(turn, turn) += movement.per_turn_turn.dot(force);
  }

  void AddWeight(const Movement& movement, double weight_n, int turn) {
    n_mm += movement.mm.y() * weight_n;
    gradient += movement.per_unknown.row(1).transpose() * weight_n;
    hessian(turn, turn) += movement.per_turn_turn.y() * weight_n;
  }

  void AddTurn(double stiffness_n_mm, double rad, int turn) {
    n_mm += stiffness_n_mm * rad * rad / 2;
    gradient[turn] += stiffness_n_mm * rad;
    hessian(turn, turn) += stiffness_n_mm;
    without_turns(turn, turn) += stiffness_n_mm;
  }

  void AddMoment(double moment_n_mm, double rad, int turn) {
    n_mm -= moment_n_mm * rad;
    gradient[turn] -= moment_n_mm;
  }
};

void CheckStiffness(const Stiffness& stiffness) {
  if (!(stiffness.across_n_mm > 0) || !(stiffness.along_n_mm > 0))
    throw UsageError("a stiffness of {} and {} N/mm: give numbers above 0", stiffness.across_n_mm,
                     stiffness.along_n_mm);
}

// Of a cuff, N mm per rad.
double TurnStiffness(const Cuff& cuff, const Stiffness& stiffness) {
  return stiffness.across_n_mm * cuff.length_mm * cuff.length_mm / 12;
}

Energy EnergyAt(const Vector& pose, const std::array<Link, 2>& links, const Stiffness& stiffness, double moment_nm) {
  const Vector2d springs(stiffness.across_n_mm, stiffness.along_n_mm);
  Energy energy;
  for (const Link& link : links) {
    const Matrix2d in_leg = link.axes * springs.asDiagonal() * link.axes.transpose();
    for (const Cuff& cuff : link.cuffs) {
      energy.AddSpring(MovementOf(link, link.FromHinge(cuff), pose), in_leg, link.turn);
      energy.AddTurn(TurnStiffness(cuff, stiffness), pose[link.turn], link.turn);
    }
    energy.AddWeight(MovementOf(link, link.CentreOfMass(), pose), link.mass_kg * kGravity_m_s2, link.turn);
    // Extension: the thigh's link turns forward, the shank's back.
    energy.AddMoment(link.side * moment_nm * kMmPerM, pose[link.turn], link.turn);
  }
  return energy;
}

// The pose of least energy, by Newton's method; where the hinge is held, among those in which the shank's link turns by
// `held_rad` more than the thigh's.
Vector PoseOf(const std::function<Energy(const Vector&)>& energy_at, const std::optional<double>& held_rad) {
  Eigen::Matrix<double, kUnknowns, Eigen::Dynamic, 0, kUnknowns, kUnknowns> free = Matrix::Identity();
  Vector pose = Vector::Zero();
  if (held_rad) {
    free.conservativeResize(Eigen::NoChange, 3);
    free(3, 2) = 1;
    pose[3] = *held_rad;
  }
  constexpr int kMostSteps = 100;
  constexpr double kSmall = 1e-11;     // mm, rad
  constexpr double kRounding = 1e-12;  // of an energy
  for (int i = 0; i < kMostSteps; ++i) {
    const Energy energy = energy_at(pose);
    const Eigen::LLT<Eigen::MatrixXd> newton(free.transpose() * energy.hessian * free);
    const Eigen::LDLT<Eigen::MatrixXd> linear(free.transpose() * energy.without_turns * free);
    const Eigen::VectorXd downhill = -free.transpose() * energy.gradient;
    const Eigen::VectorXd down =
        newton.info() == Eigen::Success ? newton.solve(downhill).eval() : linear.solve(downhill).eval();
    const Vector step = free * down;
    if (!(step.norm() > kSmall)) break;  // also where the misfit is unknown
    double part = 1;
    const double most_n_mm = energy.n_mm + kRounding * (1 + std::abs(energy.n_mm));
    while (part > kSmall && energy_at(pose + part * step).n_mm > most_n_mm) part /= 2;
    pose += part * step;
  }
  return pose;
}

}  // namespace

LegLoad LoadOnLeg(const LegState& leg, const CuffOptions& options, const Stiffness& stiffness) {
  CheckCuffs(options);
  CheckStiffness(stiffness);
  const Vector2d misfit_mm = MisfitOf(leg.hinge_on_shank_mm, leg.hinge_on_thigh_mm, leg.thigh_deg, leg.shank_deg);
  const std::array<Link, 2> links = {
      Link{AxesOf(leg.thigh_deg), 2, 1, leg.hinge_on_thigh_mm, -misfit_mm, options.thigh_link_kg, options.thigh},
      Link{AxesOf(leg.shank_deg), 3, -1, leg.hinge_on_shank_mm, Vector2d::Zero(), options.shank_link_kg,
           options.shank}};
  const auto energy_at = [&](const Vector& pose) { return EnergyAt(pose, links, stiffness, leg.moment_nm); };
  const std::optional<double> held_rad =
      leg.held_error_deg ? std::optional(RadiansFromDegrees(*leg.held_error_deg)) : std::nullopt;
  const Vector pose = PoseOf(energy_at, held_rad);
  LegLoad load;
  Vector2d on_shank = Vector2d::Zero();
  for (const Link& link : links)
    for (const Cuff& cuff : link.cuffs) {
      CuffLoad one;
      one.slip_mm = link.axes.transpose() * MovementOf(link, link.FromHinge(cuff), pose).mm;
      one.force_n = Vector2d(stiffness.across_n_mm, stiffness.along_n_mm).cwiseProduct(one.slip_mm);
      one.moment_nm = TurnStiffness(cuff, stiffness) * pose[link.turn] / kMmPerM;
      double& largest_n = link.side > 0 ? load.largest_thigh_n : load.largest_shank_n;
      largest_n = LargerOrNaN(largest_n, one.force_n.norm());
      if (link.side < 0) on_shank += one.force_n;
      (link.side > 0 ? load.thigh : load.shank).push_back(one);
    }
  load.knee_shear_n = std::abs(on_shank.x());
  return load;
}

namespace {

void SetCuffs(const OptionTexts& texts, const std::string& said, std::vector<Cuff>& cuffs) {
  cuffs.clear();
  for (const std::string& text : texts) {
    Cuff cuff;
    char colon = 0, rest = 0;
    std::istringstream words(text);
    words.imbue(std::locale::classic());
    if (!(words >> cuff.from_knee_mm >> colon >> cuff.length_mm) || colon != ':' || words >> rest ||
        cuff.from_knee_mm <= 0 || cuff.length_mm < 0)
      throw UsageError("{} '{}': give DISTANCE:LENGTH in mm, as 200:80", said, text);
    cuffs.push_back(cuff);
  }
}

std::string CuffsText(const std::vector<Cuff>& cuffs) {
  std::vector<std::string> texts;
  for (const Cuff& cuff : cuffs) texts.push_back(fmt::format("{}:{}", cuff.from_knee_mm, cuff.length_mm));
  return fmt::format("{}", fmt::join(texts, " "));
}

}  // namespace

std::vector<CuffPlace> PlacesOf(const CuffOptions& options) {
  std::vector<CuffPlace> places;
  places.reserve(options.thigh.size() + options.shank.size());
  for (const bool on_thigh : {true, false})
    for (std::size_t k = 0; k < (on_thigh ? options.thigh : options.shank).size(); ++k) places.push_back({on_thigh, k});
  return places;
}

const Cuff& CuffAt(const CuffOptions& options, const CuffPlace& place) {
  return (place.on_thigh ? options.thigh : options.shank).at(place.number);
}

void CheckCuffs(const CuffOptions& o) {
  for (const auto* cuffs : {&o.thigh, &o.shank}) {
    if (cuffs->empty()) throw UsageError("a segment without a cuff: each needs one at least");
    for (const Cuff& cuff : *cuffs)
      if (!(cuff.from_knee_mm > 0) || !(cuff.length_mm >= 0))
        throw UsageError("a cuff {} mm from the knee, {} mm long: give a distance above 0", cuff.from_knee_mm,
                         cuff.length_mm);
  }
}

void CheckStiffnesses(const CuffOptions& o) {
  if (!(o.softest_n_mm <= o.stiffest_n_mm))
    throw UsageError("--cuff-softest {} is above --cuff-stiffest {}: give the softest and the stiffest", o.softest_n_mm,
                     o.stiffest_n_mm);
}

void DescribePlaces(CuffOptions& o, OptionList& options) {
  for (const auto& [name, segment, cuffs] :
       {std::tuple("thigh-cuff", "thigh", &o.thigh), std::tuple("shank-cuff", "shank", &o.shank)}) {
    Option& option =
        options
            .AddCustom(
                name, fmt::format("A cuff on the {}: its middle's distance from the knee, and its length, mm", segment),
                [cuffs = cuffs](const OptionTexts& texts, const std::string& said) { SetCuffs(texts, said, *cuffs); },
                [cuffs = cuffs] { return CuffsText(*cuffs); })
            .Value("DISTANCE:LENGTH")
            .Repeats();
    if (cuffs->empty()) option.Otherwise("none");
  }
}

void Describe(CuffOptions& o, OptionList& options) {
  DescribePlaces(o, options);
  options.Add("cuff-softest", o.softest_n_mm, "The least stiffness of cuff and flesh that is expected")
      .Unit("N/mm")
      .Positive();
  options.Add("cuff-stiffest", o.stiffest_n_mm, "The largest stiffness of cuff and flesh that is expected")
      .Unit("N/mm")
      .Positive();
  options.Check([&o](const OptionList&) { CheckStiffnesses(o); });
}

Vector2d MisfitOf(const Vector2d& place_shank_mm, const Vector2d& place_thigh_mm, double thigh_deg, double shank_deg) {
  return AxesOf(thigh_deg) * place_thigh_mm - AxesOf(shank_deg) * place_shank_mm;
}

}  // namespace lake::cuffs
