#include <algorithm>
#include <cctype>
#include <cmath>
#include <random>
#include <set>

#include "lake/camera/calibration_quality.h"
#include "lake/camera/plane_fit.h"
#include "lake/core/error.h"

namespace lake::camera {
namespace {

constexpr std::size_t kLeastOfGroup = 3;  // of a group
constexpr double kLowersRms = 1.15;       // by which two cameras lower the RMS, …
constexpr double kTwice = 2;              // … and where that is certain without the names
constexpr double kLeastPx = 0.05;         // root of what two cameras explain of the mean square: a corner's own error

using Groups = std::vector<char>;  // 0 or 1 per view

struct Fitted {
  Groups groups;
  Camera first, second;
  double rms_px = 0;  // of all corners
};

std::vector<BoardView> InGroup(const std::vector<BoardView>& views, const Groups& groups, char group) {
  std::vector<BoardView> chosen;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (groups[i] == group) chosen.push_back(views[i]);
  return chosen;
}

class Splitter {
 public:
  Splitter(const Board& board, const std::vector<BoardView>& views, const CalibrationResult& one,
           const CalibrationOptions& options)
      : board_(board), views_(views), options_(options), camera_(one.camera), scale_px_(3 * one.sigma_px) {}

  // Each group with a camera of its own; nullopt where one fixes none.
  std::optional<Fitted> Fit(const Groups& groups) const {
    const std::vector<BoardView> first = InGroup(views_, groups, 0), second = InGroup(views_, groups, 1);
    if (first.size() < kLeastOfGroup || second.size() < kLeastOfGroup) return std::nullopt;
    try {
      const CalibrationResult a = Calibrate(first), b = Calibrate(second);
      return Fitted{.groups = groups, .first = a.camera, .second = b.camera, .rms_px = Rms(a, b)};
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  // From these groups on, until each view is in the group whose camera fits it.
  std::optional<Fitted> Settle(const Groups& groups) const {
    constexpr int kRounds = 8;
    std::optional<Fitted> fitted = Fit(groups);
    for (int round = 1; fitted && round < kRounds; ++round) {
      const Groups better = Assign(fitted->first, fitted->second);
      if (better == fitted->groups) break;
      fitted = Fit(better);
    }
    return fitted;
  }

 private:
  CalibrationResult Calibrate(const std::vector<BoardView>& views) const {
    return CalibrateCamera(board_, views, camera_.image_width, camera_.image_height, options_);
  }

  // Cauchy's loss, as the calibration's.
  double Cost(const Camera& camera, const BoardView& view) const {
    double sum = 0;
    for (const Eigen::Vector2d& residual : FitPlaneToBoard(camera, board_, view).residual_px)
      sum += std::log1p(residual.squaredNorm() / (scale_px_ * scale_px_));
    return sum;
  }

  Groups Assign(const Camera& a, const Camera& b) const {
    Groups groups;
    for (const BoardView& view : views_) groups.push_back(Cost(b, view) < Cost(a, view));
    return groups;
  }

  static double Rms(const CalibrationResult& a, const CalibrationResult& b) {
    double sum = 0;
    std::size_t count = 0;
    for (const CalibrationResult* result : {&a, &b})
      for (const auto& view : result->residual_px)
        for (const Eigen::Vector2d& residual : view) {
          sum += residual.squaredNorm();
          ++count;
        }
    return std::sqrt(sum / static_cast<double>(count));
  }

  const Board& board_;
  const std::vector<BoardView>& views_;
  const CalibrationOptions& options_;
  const Camera& camera_;
  const double scale_px_;
};

std::string WithoutDigits(std::string name) {
  std::erase_if(name, [](unsigned char c) { return std::isdigit(c); });
  return name;
}

// One for each kind of name: its views, and all others.
std::vector<Groups> ByName(const std::vector<BoardView>& views) {
  std::set<std::string> kinds;
  for (const BoardView& view : views) kinds.insert(WithoutDigits(view.name));
  std::vector<Groups> all;
  for (const std::string& kind : kinds) {
    Groups groups;
    for (const BoardView& view : views) groups.push_back(WithoutDigits(view.name) == kind);
    all.push_back(groups);
  }
  if (all.size() == 2) all.pop_back();  // the other way round
  return kinds.size() == 1 ? std::vector<Groups>{} : all;
}

Groups CutAt(std::size_t views, std::size_t cut) {
  Groups groups(views, 0);
  std::fill(groups.begin() + static_cast<std::ptrdiff_t>(cut), groups.end(), 1);
  return groups;
}

std::vector<Groups> Starts(const std::vector<BoardView>& views) {
  constexpr int kByChance = 4;
  std::vector<Groups> starts = ByName(views);
  starts.push_back(CutAt(views.size(), views.size() / 2));
  Groups alternating;
  for (std::size_t i = 0; i < views.size(); ++i) alternating.push_back(i % 2);
  starts.push_back(alternating);
  std::mt19937_64 random(1);
  for (int start = 0; start < kByChance; ++start) {
    Groups groups;
    for (std::size_t i = 0; i < views.size(); ++i) groups.push_back(random() % 2);
    starts.push_back(groups);
  }
  return starts;
}

// But for one view of ten, and either way round.
bool AreAlike(const Groups& a, const Groups& b) {
  std::size_t differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i) differ += a[i] != b[i];
  return 10 * std::min(differ, a.size() - differ) <= a.size();
}

// All groups of the first so many views, and of the others.
std::vector<Groups> ByOrder(const std::vector<BoardView>& views) {
  std::vector<Groups> all;
  for (std::size_t cut = kLeastOfGroup; cut + kLeastOfGroup <= views.size(); ++cut)
    all.push_back(CutAt(views.size(), cut));
  return all;
}

}  // namespace

std::optional<TwoCameras> FindTwoCameras(const Board& board, const std::vector<BoardView>& views,
                                         const CalibrationResult& result, const CalibrationOptions& options) {
  if (views.size() < 2 * kLeastOfGroup) return std::nullopt;
  const Splitter splitter(board, views, result, options);
  std::optional<Fitted> best;
  for (const Groups& start : Starts(views)) {
    const std::optional<Fitted> fitted = splitter.Settle(start);
    if (fitted && (!best || fitted->rms_px < best->rms_px)) best = fitted;
  }
  const auto explains = [&result](const std::optional<Fitted>& two) {
    return two && result.rms_px > kLowersRms * two->rms_px &&
           std::pow(result.rms_px, 2) - std::pow(two->rms_px, 2) > kLeastPx * kLeastPx;
  };
  if (!explains(best)) return std::nullopt;
  TwoCameras cameras;
  cameras.is_certain = result.rms_px > kTwice * best->rms_px;
  // A view or two that either camera fits do not hide whose groups these are. Names say more than the order does.
  std::optional<Fitted> expected;
  for (const std::vector<Groups>& candidates : {ByName(views), ByOrder(views)}) {
    for (const Groups& groups : candidates) {
      if (!AreAlike(groups, best->groups)) continue;
      const std::optional<Fitted> fitted = splitter.Fit(groups);
      if (explains(fitted) && (!expected || fitted->rms_px < expected->rms_px)) expected = fitted;
    }
    if (expected) break;
  }
  if (expected) {
    best = expected;
    cameras.is_certain = true;
  }
  for (std::size_t i = 0; i < views.size(); ++i)
    (best->groups[i] == best->groups.front() ? cameras.first : cameras.second).push_back(i);
  cameras.rms_one_px = result.rms_px;
  cameras.rms_two_px = best->rms_px;
  return cameras;
}

std::string Describe(const TwoCameras& cameras, const std::vector<BoardView>& views) {
  const auto names = [&views](const std::vector<std::size_t>& group) {
    constexpr std::size_t kShown = 8;
    std::vector<std::string> shown;
    for (std::size_t k = 0; k < std::min(group.size(), kShown); ++k) shown.push_back(views[group[k]].name);
    return fmt::format("{}{}", fmt::join(shown, ", "),
                       group.size() > kShown ? fmt::format(" … ({} in all)", group.size()) : "");
  };
  return fmt::format("{} and {} as views of two cameras leave {:.2f} px RMS, as views of one {:.2f} px",
                     names(cameras.first), names(cameras.second), cameras.rms_two_px, cameras.rms_one_px);
}

}  // namespace lake::camera
