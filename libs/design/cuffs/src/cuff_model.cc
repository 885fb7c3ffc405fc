#include "lake/cuffs/cuff_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <tuple>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"

namespace lake::cuffs {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

constexpr double kGravity_m_s2 = 9.80665;

// Unknowns: how far the hinge moves from where it would be on the shank (leg frame, mm), and how far the thigh's and
// the shank's link turn against their segments (rad, forward).
constexpr int kUnknowns = 4;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using SlipRows = Eigen::Matrix<double, 2, kUnknowns>;

// Columns: across the segment (anterior) and along it (up), in the leg frame.
Matrix2d AxesOf(double lean_deg) {
  const double lean = RadiansFromDegrees(lean_deg);
  Matrix2d axes;
  axes << std::cos(lean), std::sin(lean), -std::sin(lean), std::cos(lean);
  return axes;
}

struct Link {
  Matrix2d axes;
  int turn;            // which unknown is its turn
  double side;         // +1: above the knee
  Vector2d offset_mm;  // how far its hinge is from the shank's before the links move, in the leg frame
  double mass_kg;
  const std::vector<Cuff>& cuffs;

  // A point of the link at a distance from the hinge moves by rows · unknowns + offset against its segment.
  SlipRows MovesAt(double from_knee_mm) const {
    SlipRows rows = SlipRows::Zero();
    rows.leftCols<2>().setIdentity();
    rows.col(turn) = side * from_knee_mm * axes.col(0);  // a turn forward moves what is above the hinge forward
    return rows;
  }
};

void Check(const CuffOptions& o, const Stiffness& stiffness) {
  for (const auto* cuffs : {&o.thigh, &o.shank}) {
    if (cuffs->empty()) throw UsageError("a segment without a cuff: each needs one at least");
    for (const Cuff& cuff : *cuffs)
      if (!(cuff.from_knee_mm > 0) || !(cuff.length_mm >= 0))
        throw UsageError(fmt::format("a cuff {} mm from the knee, {} mm long: give a distance above 0",
                                     cuff.from_knee_mm, cuff.length_mm));
  }
  if (!(stiffness.across_n_mm > 0) || !(stiffness.along_n_mm > 0))
    throw UsageError(fmt::format("a stiffness of {} and {} N/mm: give numbers above 0", stiffness.across_n_mm,
                                 stiffness.along_n_mm));
}

// The pose of least energy where the shank's link turns by `error_rad` more than the thigh's.
Vector HeldPose(const Matrix& stiff, const Vector& pull, double error_rad) {
  Eigen::Matrix<double, kUnknowns, 3> of_three = Eigen::Matrix<double, kUnknowns, 3>::Identity();
  of_three(3, 2) = 1;
  const Vector apart(0, 0, 0, error_rad);
  const Eigen::Matrix3d held = of_three.transpose() * stiff * of_three;
  return of_three * held.ldlt().solve(of_three.transpose() * (pull - stiff * apart)) + apart;
}

double MiddleOf(const std::vector<Cuff>& cuffs) {
  return std::ranges::max_element(cuffs, {}, &Cuff::from_knee_mm)->from_knee_mm / 2;
}

}  // namespace

LegLoad LoadOnLeg(const LegState& leg, const CuffOptions& options, const Stiffness& stiffness) {
  Check(options, stiffness);
  const Link links[] = {
      {AxesOf(leg.thigh_deg), 2, 1, -leg.misfit_mm, options.thigh_link_kg, options.thigh},
      {AxesOf(leg.shank_deg), 3, -1, Vector2d::Zero(), options.shank_link_kg, options.shank},
  };
  const Vector2d springs(stiffness.across_n_mm, stiffness.along_n_mm);
  const auto turn_stiffness = [&](const Cuff& cuff) {  // N mm per rad
    return stiffness.across_n_mm * cuff.length_mm * cuff.length_mm / 12;
  };
  Matrix stiff = Matrix::Zero();
  Vector pull = Vector::Zero();
  for (const Link& link : links) {
    for (const Cuff& cuff : link.cuffs) {
      const SlipRows rows = link.axes.transpose() * link.MovesAt(cuff.from_knee_mm);
      stiff += rows.transpose() * springs.asDiagonal() * rows;
      stiff(link.turn, link.turn) += turn_stiffness(cuff);
      pull -= rows.transpose() * springs.cwiseProduct(link.axes.transpose() * link.offset_mm);
    }
    pull -= link.MovesAt(MiddleOf(link.cuffs)).row(1).transpose() * link.mass_kg * kGravity_m_s2;
  }
  // Extension: the thigh's link turns forward, the shank's back.
  pull[2] += leg.moment_nm * kMmPerM;
  pull[3] -= leg.moment_nm * kMmPerM;
  const Vector pose = leg.held_error_deg ? HeldPose(stiff, pull, RadiansFromDegrees(*leg.held_error_deg))
                                         : Vector(stiff.ldlt().solve(pull));
  LegLoad load;
  Vector2d on_shank = Vector2d::Zero();
  for (const Link& link : links)
    for (const Cuff& cuff : link.cuffs) {
      CuffLoad one;
      one.slip_mm = link.axes.transpose() * (link.MovesAt(cuff.from_knee_mm) * pose + link.offset_mm);
      one.force_n = springs.cwiseProduct(one.slip_mm);
      one.moment_nm = turn_stiffness(cuff) * pose[link.turn] / kMmPerM;
      double& largest_n = link.side > 0 ? load.largest_thigh_n : load.largest_shank_n;
      largest_n = LargerOrNaN(largest_n, one.force_n.norm());
      if (link.side < 0) on_shank += one.force_n;
      (link.side > 0 ? load.thigh : load.shank).push_back(one);
    }
  load.knee_shear_n = std::abs(on_shank.x());
  load.knee_axial_n = on_shank.y();
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
      throw UsageError(fmt::format("{} '{}': give DISTANCE:LENGTH in mm, as 200:80", said, text));
    cuffs.push_back(cuff);
  }
}

std::string CuffsText(const std::vector<Cuff>& cuffs) {
  std::vector<std::string> texts;
  for (const Cuff& cuff : cuffs) texts.push_back(fmt::format("{}:{}", cuff.from_knee_mm, cuff.length_mm));
  return fmt::format("{}", fmt::join(texts, " "));
}

}  // namespace

void CheckStiffnesses(const CuffOptions& o) {
  if (!(o.softest_n_mm <= o.stiffest_n_mm))
    throw UsageError(fmt::format("--cuff-softest {} is above --cuff-stiffest {}: give the softest and the stiffest",
                                 o.softest_n_mm, o.stiffest_n_mm));
}

void Describe(CuffOptions& o, OptionList& options) {
  for (const auto& [name, segment, cuffs] :
       {std::tuple("thigh-cuff", "thigh", &o.thigh), std::tuple("shank-cuff", "shank", &o.shank)})
    options
        .AddCustom(
            name, fmt::format("A cuff on the {}: its middle's distance from the knee, and its length, mm", segment),
            [cuffs = cuffs](const OptionTexts& texts, const std::string& said) { SetCuffs(texts, said, *cuffs); },
            [cuffs = cuffs] { return CuffsText(*cuffs); })
        .Value("DISTANCE:LENGTH")
        .Repeats();
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
