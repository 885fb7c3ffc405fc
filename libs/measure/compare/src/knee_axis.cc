#include "lake/compare/knee_axis.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <span>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"

namespace lake::compare {
namespace {

struct Node {
  double knee_rad, value_m;  // flexion negative
};

constexpr std::array<Node, 12> kX = {{{-2.0944, -.0032},
                                      {-1.74533, .00179},
                                      {-1.39626, .00411},
                                      {-1.0472, .0041},
                                      {-.698132, .00212},
                                      {-.349066, -.001},
                                      {-.174533, -.0031},
                                      {.197344, -.005227},
                                      {.337395, -.005435},
                                      {.490178, -.005574},
                                      {1.52146, -.005435},
                                      {2.0944, -.00525}}};
constexpr std::array<Node, 7> kY = {{{-2.0944, -.4226},
                                     {-1.22173, -.4082},
                                     {-.523599, -.399},
                                     {-.349066, -.3976},
                                     {-.174533, -.3966},
                                     {.159149, -.395264},
                                     {2.0944, -.396}}};

// A natural cubic spline through a table.
class NaturalSpline {
 public:
  explicit NaturalSpline(std::span<const Node> nodes) : nodes_(nodes) {
    const auto count = static_cast<Eigen::Index>(nodes.size());
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
    system(0, 0) = system(count - 1, count - 1) = 1;
    for (std::size_t i = 1; i + 1 < nodes.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double before = Step(i - 1), after = Step(i);
      system(row, row - 1) = before;
      system(row, row) = 2 * (before + after);
      system(row, row + 1) = after;
      right[row] =
          6 * ((nodes[i + 1].value_m - nodes[i].value_m) / after - (nodes[i].value_m - nodes[i - 1].value_m) / before);
    }
    bend_ = system.colPivHouseholderQr().solve(right);
  }

  double At(double knee_rad) const {
    std::size_t i = 0;
    while (i + 2 < nodes_.size() && knee_rad > nodes_[i + 1].knee_rad) ++i;
    const double h = Step(i), a = (nodes_[i + 1].knee_rad - knee_rad) / h, b = 1 - a;
    const auto k = static_cast<Eigen::Index>(i);
    return a * nodes_[i].value_m + b * nodes_[i + 1].value_m +
           ((a * a * a - a) * bend_[k] + (b * b * b - b) * bend_[k + 1]) * h * h / 6;
  }

 private:
  double Step(std::size_t i) const { return nodes_[i + 1].knee_rad - nodes_[i].knee_rad; }

  std::span<const Node> nodes_;  // not owned
  Eigen::VectorXd bend_;         // second derivatives
};

// femur_from_tibia's rotation; flexion turns the tibia backward.
Eigen::Matrix2d TibiaInFemur(double knee_deg) {
  return Eigen::Rotation2D<double>(-RadiansFromDegrees(knee_deg)).toRotationMatrix();
}

}  // namespace

Eigen::Vector2d TibiaOriginInFemur(double knee_deg) {
  if (!(knee_deg >= -90 && knee_deg <= 120))
    throw UsageError("knee model: {}° is outside −90..120°", SignificantText(knee_deg, 4));
  static const NaturalSpline x(kX), y(kY);
  const double knee_rad = -RadiansFromDegrees(knee_deg);
  return kMmPerM * Eigen::Vector2d(x.At(knee_rad), y.At(knee_rad));
}

FixedPivot BestFixedPivot(double from_deg, double to_deg) {
  constexpr int kAngles = 181;
  Eigen::MatrixXd system(2 * kAngles, 4);
  Eigen::VectorXd right(2 * kAngles);
  const auto angle = [&](int i) { return std::lerp(from_deg, to_deg, static_cast<double>(i) / (kAngles - 1)); };
  for (int i = 0; i < kAngles; ++i) {  // gap = t + R c_tibia − c_femur
    system.block<2, 2>(2 * i, 0) = -Eigen::Matrix2d::Identity();
    system.block<2, 2>(2 * i, 2) = TibiaInFemur(angle(i));
    right.segment<2>(2 * i) = -TibiaOriginInFemur(angle(i));
  }
  const Eigen::Vector4d solution = system.colPivHouseholderQr().solve(right);
  const Eigen::VectorXd gaps = system * solution - right;
  FixedPivot pivot{solution.head<2>(), solution.tail<2>()};
  for (int i = 0; i < kAngles; ++i) {
    const double gap = gaps.segment<2>(2 * i).norm();
    pivot.gap_rms_mm += gap * gap / kAngles;
    if (gap > pivot.gap_max_mm) {
      pivot.gap_max_mm = gap;
      pivot.most_gap_deg = angle(i);
    }
  }
  pivot.gap_rms_mm = std::sqrt(pivot.gap_rms_mm);
  return pivot;
}

double OffsetGap(double offset_mm, double knee_deg) {
  return 2 * offset_mm * std::sin(0.5 * RadiansFromDegrees(knee_deg));
}

}  // namespace lake::compare
