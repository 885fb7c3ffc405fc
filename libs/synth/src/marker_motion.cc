#include "lake/synth/marker_motion.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// Second derivatives at the knots of the natural cubic spline (Press et al., Numerical Recipes, section 3.3): a
// tridiagonal system.
std::vector<Vector3d> SplineCurvature(const std::vector<double>& t, const std::vector<Vector3d>& p) {
  const std::size_t n = t.size();
  std::vector<Vector3d> right(n, Vector3d::Zero()), curvature(n, Vector3d::Zero());
  std::vector<double> above(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
    const double pivot = 2 * (h0 + h1) - h0 * above[i - 1];
    above[i] = h1 / pivot;
    right[i] = (6 * ((p[i + 1] - p[i]) / h1 - (p[i] - p[i - 1]) / h0) - h0 * right[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvature[i] = right[i] - above[i] * curvature[i + 1];
  return curvature;
}

class TableMotion : public MarkerMotion {
 public:
  explicit TableMotion(const MotionTable& table)
      : time_s_(table.time_s),
        names_(table.names),
        duration_s_(table.time_s.back() - table.after_s),
        facing_(FacingOf(table)) {
    for (std::size_t m = 0; m < names_.size(); ++m) {
      std::vector<Vector3d>& path = positions_.emplace_back();
      for (std::size_t i = 0; i < time_s_.size(); ++i) {
        const Vector2d& place = table.positions[m][i];
        path.emplace_back(place.x(), place.y(), table.depth_mm.empty() ? 0 : table.depth_mm[m][i]);
      }
      curvature_.push_back(SplineCurvature(time_s_, path));
    }
  }

  const std::vector<std::string>& Names() const override { return names_; }
  motion::Facing FacingInImage() const override { return facing_; }
  double DurationS() const override { return duration_s_; }

  std::vector<Vector2d> At(double time_s) const override {
    std::vector<Vector2d> markers;
    for (std::size_t m = 0; m < names_.size(); ++m) markers.emplace_back(Place(m, time_s).head<2>());
    return markers;
  }

  std::vector<double> DepthsAt(double time_s) const override {
    std::vector<double> depths;
    for (std::size_t m = 0; m < names_.size(); ++m) depths.push_back(Place(m, time_s).z());
    return depths;
  }

 private:
  Vector3d Place(std::size_t m, double time_s) const {
    const auto& t = time_s_;
    const double time = std::clamp(time_s, t.front(), t.back());
    const std::size_t i = static_cast<std::size_t>(std::upper_bound(t.begin() + 1, t.end() - 1, time) - t.begin());
    const double h = t[i] - t[i - 1], a = (t[i] - time) / h, b = 1 - a;
    return a * positions_[m][i - 1] + b * positions_[m][i] +
           h * h / 6 * ((a * a * a - a) * curvature_[m][i - 1] + (b * b * b - b) * curvature_[m][i]);
  }

  std::vector<double> time_s_;
  std::vector<std::string> names_;
  std::vector<std::vector<Vector3d>> positions_, curvature_;  // mm and, at the knots, mm/s²
  double duration_s_;
  motion::Facing facing_;
};

int IndexOf(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

}  // namespace

std::vector<double> MarkerMotion::DepthsAt(double) const {
  return std::vector<double>(Names().size(), 0.0);
}

std::vector<Vector3d> MarkerMotion::InSpace(double time_s) const {
  const std::vector<Vector2d> places = At(time_s);
  const std::vector<double> depths = DepthsAt(time_s);
  std::vector<Vector3d> markers;
  for (std::size_t m = 0; m < places.size(); ++m) markers.emplace_back(places[m].x(), places[m].y(), depths[m]);
  return markers;
}

int IndexOfMarker(const MarkerMotion& motion, std::string_view name) {
  return IndexOf(motion.Names(), name);
}

motion::Facing FacingOf(const MotionTable& table) {
  const int ankle = IndexOf(table.names, "ankle"), knee = IndexOf(table.names, "knee"),
            hip = IndexOf(table.names, "hip");
  if (ankle < 0 || knee < 0 || hip < 0) return motion::Facing::kRight;
  double side = 0;  // z of AH × AK: negative when the knee is to the right of the line from ankle up to hip
  for (std::size_t i = 0; i < table.time_s.size(); ++i) {
    const Vector2d ak = table.positions[knee][i] - table.positions[ankle][i];
    const Vector2d ah = table.positions[hip][i] - table.positions[ankle][i];
    side += Cross(ah, ak);
  }
  return side <= 0 ? motion::Facing::kRight : motion::Facing::kLeft;
}

double KneeAngleDeg(const Vector2d& ankle, const Vector2d& knee, const Vector2d& hip, motion::Facing facing) {
  const Vector2d ak = knee - ankle, kh = hip - knee;
  const double cross = Cross(ak, kh);  // positive: KH turns to the left of AK
  return DegreesFromRadians(std::atan2(facing == motion::Facing::kRight ? cross : -cross, ak.dot(kh)));
}

MotionTable ReadMotionTable(const std::filesystem::path& path) {
  const CsvTable csv = CsvTable::Read(path);
  MotionTable table;
  std::vector<std::pair<std::size_t, std::size_t>> columns;
  constexpr std::string_view kX = "_x_mm";
  for (const std::string& name : csv.Header()) {
    if (!name.ends_with(kX) || name.size() == kX.size()) continue;
    const std::string marker = name.substr(0, name.size() - kX.size());
    table.names.push_back(marker);
    columns.emplace_back(csv.Column(name), csv.Column(marker + "_y_mm"));
  }
  if (table.names.empty()) throw Fail("{}: no column M_x_mm; a motion table has time_s, M_x_mm, M_y_mm", path.string());
  table.positions.resize(table.names.size());
  const std::size_t time = csv.Column("time_s");
  for (std::size_t row = 0; row < csv.Rows(); ++row) {
    table.time_s.push_back(csv.RequiredNumber(row, time));
    if (row > 0 && !(table.time_s[row] > table.time_s[row - 1]))
      throw Fail("{}: time_s {} does not come after {}", csv.Where(row), table.time_s[row], table.time_s[row - 1]);
    for (std::size_t m = 0; m < columns.size(); ++m)
      table.positions[m].emplace_back(csv.RequiredNumber(row, columns[m].first),
                                      csv.RequiredNumber(row, columns[m].second));
  }
  if (table.time_s.size() < 3) throw Fail("{}: {} rows; a motion needs at least 3", path.string(), table.time_s.size());
  return table;
}

std::unique_ptr<MarkerMotion> MakeTableMotion(MotionTable table, bool mirror) {
  if (table.time_s.size() < 3 || table.names.empty() || table.positions.size() != table.names.size())
    throw Fail("a motion needs at least 3 times and one marker");
  const double start = table.time_s.front() + table.before_s;
  for (std::size_t i = 0; i < table.time_s.size(); ++i) {
    table.time_s[i] -= start;
    if (i > 0 && !(table.time_s[i] > table.time_s[i - 1])) throw Fail("a motion's times must increase (row {})", i);
  }
  for (auto& track : table.positions) {
    if (track.size() != table.time_s.size()) throw Fail("a motion needs one position per time and marker");
    if (mirror)
      for (Vector2d& position : track) position.x() = -position.x();
  }
  return std::make_unique<TableMotion>(table);
}

}  // namespace lake::synth
