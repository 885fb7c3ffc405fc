#include "lake/overlay/head_blur.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "lake/core/cross.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::overlay {
namespace {

// As parts of the leg's length, 0.491 of the stature; head and neck: Drillis & Contini.
constexpr double kHead = 0.825;           // from the hip to the middle of the head
constexpr double kRadiusShoulder = 0.42;  // the head, nodding by 45° either way, what the shoulder moves on the trunk
constexpr double kRadiusWaist = 0.62;     // and how differently spines bend
constexpr double kLimb = 0.1, kMarker = 0.1;  // half the width of what is left as it is
constexpr double kSpine = 1.25;
constexpr double kLongestGap_s = 1;

std::optional<Eigen::Vector2d> Place(const motion::MarkerRecording& tracks, std::string_view name, std::size_t row) {
  const motion::MarkerTrack* track = tracks.Find(name);
  if (!track || !track->samples[row].IsKnown()) return std::nullopt;
  return track->samples[row].position;
}

std::optional<Eigen::Vector2d> Segment(const motion::MarkerRecording& tracks, std::string_view from,
                                       std::string_view to, std::size_t row) {
  const auto a = Place(tracks, from, row), b = Place(tracks, to, row);
  if (!a || !b || (*b - *a).norm() == 0) return std::nullopt;
  return *b - *a;
}

// By which the second must be turned to point as the first, (−π, π].
double Turn(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(Cross(from, to), from.dot(to));
}

// Cells of one grey each, then smooth between them.
cv::Mat Coarse(const cv::Mat& picture, double cell_px) {
  const auto cells = [&](int side) { return std::max(1, static_cast<int>(side / cell_px)); };
  cv::Mat small, coarse;
  cv::resize(picture, small, {cells(picture.cols), cells(picture.rows)}, 0, 0, cv::INTER_AREA);
  cv::resize(small, coarse, picture.size(), 0, 0, cv::INTER_LINEAR);
  return coarse;
}

constexpr int kCellsAcross = 20;  // of a whole picture

// Y, then Cb and Cr, in OpenCV's I420 layout.
cv::Mat PlaneOf(cv::Mat& i420, int plane) {
  const int width = i420.cols, height = i420.rows / 3 * 2;
  if (plane == 0) return i420.rowRange(0, height);
  const std::size_t offset =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * (plane == 1 ? 4 : 5) / 4;
  return cv::Mat(height / 2, width / 2, CV_8UC1, i420.data + offset);
}

cv::Point PixelOf(const Eigen::Vector2d& place, double scale) {
  return {static_cast<int>(std::lround(place.x() * scale)), static_cast<int>(std::lround(place.y() * scale))};
}

}  // namespace

HeadBlur::HeadBlur(const motion::MarkerRecording& tracks) : tracks_(tracks) {
  if (tracks_.unit != motion::LengthUnit::kPx) throw Fail("blurring a head needs tracks in px");
  for (const char* name : {"ankle", "knee", "hip"})
    if (!tracks_.Find(name)) throw Fail("the head's position needs a marker '{}'", name);
  if (!tracks_.Find("waist") && !tracks_.Find("shoulder"))
    throw Fail("the head's position needs a marker 'waist' or 'shoulder'");
  FindLeg();
  FindHeads();
  BridgeGaps();
}

// How long it is; and where it stands, how the waist lies on the trunk.
void HeadBlur::FindLeg() {
  std::vector<double> lengths, flexions;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < tracks_.Frames(); ++row) {
    const auto shank = Segment(tracks_, "ankle", "knee", row), thigh = Segment(tracks_, "knee", "hip", row);
    if (!shank || !thigh) continue;
    lengths.push_back(shank->norm() + thigh->norm());
    flexions.push_back(std::abs(Turn(*shank, *thigh)));
    rows.push_back(row);
  }
  if (lengths.empty()) return;
  leg_px_ = Quantile(lengths, 0.9);
  constexpr double kStraightest = 30 * std::numbers::pi / 180, kNearly = 8 * std::numbers::pi / 180;
  const double straight = *std::min_element(flexions.begin(), flexions.end());
  if (straight > kStraightest) return;
  Eigen::Vector2d legs(0, 0), waists(0, 0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (flexions[i] > straight + kNearly) continue;
    const auto leg = Segment(tracks_, "ankle", "hip", rows[i]), waist = Segment(tracks_, "hip", "waist", rows[i]);
    if (leg && waist) {
      legs += leg->normalized();
      waists += waist->normalized();
    }
  }
  if (legs.norm() == 0 || waists.norm() == 0) return;
  upright_ = legs.normalized();
  waist_turn_ = Turn(upright_, waists);
}

std::optional<Eigen::Vector2d> HeadBlur::Trunk(std::size_t row) const {
  if (const auto shoulder = Segment(tracks_, "hip", "shoulder", row)) return shoulder->normalized();
  const auto waist = Segment(tracks_, "hip", "waist", row);
  if (!waist || !waist_turn_) return std::nullopt;
  const Eigen::Rotation2Dd as_standing(-*waist_turn_);
  return Eigen::Rotation2Dd(kSpine * Turn(upright_, as_standing * *waist)) * upright_;
}

void HeadBlur::FindHeads() {
  heads_.assign(tracks_.Frames(), std::nullopt);
  bool from_waist = false, any = false;
  for (std::size_t row = 0; row < tracks_.Frames(); ++row) {
    const auto hip = Place(tracks_, "hip", row);
    const auto trunk = Trunk(row);
    if (!hip || !trunk) continue;
    heads_[row] = *hip + kHead * leg_px_ * *trunk;
    any = true;
    from_waist |= !Place(tracks_, "shoulder", row).has_value();
  }
  if (any) radius_px_ = (from_waist ? kRadiusWaist : kRadiusShoulder) * leg_px_;
}

void HeadBlur::BridgeGaps() {
  std::optional<std::size_t> before;
  for (std::size_t row = 0; row < heads_.size(); ++row) {
    if (!heads_[row]) continue;
    if (before && tracks_.time_s[row] - tracks_.time_s[*before] <= kLongestGap_s)
      for (std::size_t gap = *before + 1; gap < row; ++gap) {
        const double share =
            (tracks_.time_s[gap] - tracks_.time_s[*before]) / (tracks_.time_s[row] - tracks_.time_s[*before]);
        heads_[gap] = (1 - share) * *heads_[*before] + share * *heads_[row];
      }
    before = row;
  }
}

std::optional<std::size_t> HeadBlur::Row(std::int64_t frame) const {
  const auto at = std::lower_bound(tracks_.frame.begin(), tracks_.frame.end(), frame);
  if (at == tracks_.frame.end() || *at != frame) return std::nullopt;
  return static_cast<std::size_t>(at - tracks_.frame.begin());
}

std::optional<HeadDisc> HeadBlur::Head(std::int64_t frame) const {
  const auto row = Row(frame);
  if (!row || !heads_[*row]) return std::nullopt;
  return HeadDisc{*heads_[*row], radius_px_};
}

// 255 at the shank, the thigh and the markers, else 0.
cv::Mat HeadBlur::Kept(cv::Size size, double scale, std::optional<std::size_t> row) const {
  cv::Mat kept = cv::Mat::zeros(size, CV_8UC1);
  if (!row) return kept;
  const auto width_px = [&](double part) { return std::max(1, static_cast<int>(std::ceil(part * leg_px_ * scale))); };
  for (const auto& [from, to] : {std::pair{"ankle", "knee"}, std::pair{"knee", "hip"}}) {
    const auto a = Place(tracks_, from, *row), b = Place(tracks_, to, *row);
    if (a && b) cv::line(kept, PixelOf(*a, scale), PixelOf(*b, scale), 255, 2 * width_px(kLimb));
  }
  for (const motion::MarkerTrack& marker : tracks_.markers)
    if (marker.samples[*row].IsKnown())
      cv::circle(kept, PixelOf(marker.samples[*row].position, scale), width_px(kMarker), 255, cv::FILLED);
  return kept;
}

HeadBlur::Done HeadBlur::Blur(cv::Mat& i420, std::int64_t frame, int recorded_width) const {
  const std::optional<HeadDisc> head = Head(frame);
  bool beside_leg = false;
  for (const int plane : {0, 1, 2}) {
    cv::Mat picture = PlaneOf(i420, plane);
    const double scale = static_cast<double>(picture.cols) / recorded_width;
    const cv::Mat kept = Kept(picture.size(), scale, Row(frame));
    cv::Mat blurred = cv::Mat::zeros(picture.size(), CV_8UC1);
    cv::Rect area({0, 0}, picture.size());
    double cell_px = static_cast<double>(picture.cols) / kCellsAcross;
    if (head) {
      const cv::Point centre = PixelOf(head->centre, scale);
      const int radius = static_cast<int>(std::ceil(head->radius_px * scale));
      cv::circle(blurred, centre, radius, 255, cv::FILLED);
      area &= cv::Rect(centre.x - radius, centre.y - radius, 2 * radius + 1, 2 * radius + 1);
      cell_px = std::max(1.0, radius / 4.0);
      cv::Mat face = cv::Mat::zeros(picture.size(), CV_8UC1);
      cv::circle(face, centre, static_cast<int>(std::ceil(kRadiusShoulder * leg_px_ * scale)), 255, cv::FILLED);
      cv::bitwise_and(face, kept, face);
      beside_leg |= cv::countNonZero(face) > 0;
    } else {
      blurred.setTo(255);
    }
    if (area.empty()) continue;
    blurred.setTo(0, kept);
    Coarse(picture(area), cell_px).copyTo(picture(area), blurred(area));
  }
  return !head ? Done::kWhole : beside_leg ? Done::kHeadBesideLeg : Done::kHead;
}

void BlurWhole(cv::Mat& luma) {
  luma = Coarse(luma, static_cast<double>(luma.cols) / kCellsAcross);
}

}  // namespace lake::overlay
