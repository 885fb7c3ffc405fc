#include "overlay_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>

#include "lake/core/colours.h"
#include "lake/core/deviation_text.h"
#include "lake/core/error.h"

namespace lake::overlay {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 3> kBones = {
    {{"ankle", "knee"}, {"knee", "hip"}, {"hip", "waist"}}};
constexpr double kEventShown_s = 1.0;
// In units.
constexpr double kMark = 10;          // what stays free about a marker
constexpr double kCross[] = {6, 15};  // a cross's arms begin and end so far from its centre
constexpr double kPanelWidth = 246, kPanelPadding = 10, kInsetSide = 120, kGap = 6;
constexpr double kLeastTold_px =
    0.05;  // a background that slopes, lens and compression leave as much: below it no SD is shown

cv::Rect2d Around(cv::Point2d a, cv::Point2d b, double margin) {
  return {std::min(a.x, b.x) - margin, std::min(a.y, b.y) - margin, std::abs(a.x - b.x) + 2 * margin,
          std::abs(a.y - b.y) + 2 * margin};
}

std::string ShownName(motion::StsEventKind kind) {
  std::string name(motion::ToString(kind));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

// B, G, R, x as cairo has it; black beyond the picture's edge.
cv::Mat CopyAround(const cv::Mat& luma, const cv::Rect& area) {
  cv::Mat copy(area.size(), CV_8UC4, cv::Scalar(0, 0, 0, 255));
  const cv::Rect inside = area & cv::Rect(0, 0, luma.cols, luma.rows);
  for (int y = inside.y; y < inside.y + inside.height; ++y)
    for (int x = inside.x; x < inside.x + inside.width; ++x) {
      const std::uint8_t grey = luma.at<std::uint8_t>(y, x);
      copy.at<cv::Vec4b>(y - area.y, x - area.x) = {grey, grey, grey, 255};
    }
  return copy;
}

// Fills `square` of the layer with what lies within `half_px` of `centre` (px of the recording, pixel centres at whole
// numbers); black beyond its edge.
void DrawMagnified(OverlayLayer& layer, const cv::Mat& luma, const Eigen::Vector2d& centre, double half_px,
                   const cv::Rect2d& square) {
  constexpr int kRoom_px = 2;  // for interpolation at the edges
  const int side = 2 * (static_cast<int>(std::ceil(half_px)) + kRoom_px) + 1;
  const cv::Rect area(static_cast<int>(std::lround(centre.x())) - side / 2,
                      static_cast<int>(std::lround(centre.y())) - side / 2, side, side);
  cv::Mat piece = CopyAround(luma, area);
  cairo_t* draw = layer.Context();
  cairo_surface_t* surface = cairo_image_surface_create_for_data(piece.data, CAIRO_FORMAT_RGB24, piece.cols, piece.rows,
                                                                 static_cast<int>(piece.step));
  cairo_save(draw);
  cairo_rectangle(draw, square.x, square.y, square.width, square.height);
  cairo_clip(draw);
  // Pixel centres are at a half for cairo.
  cairo_translate(draw, square.x + square.width / 2, square.y + square.height / 2);
  cairo_scale(draw, square.width / (2 * half_px), square.height / (2 * half_px));
  cairo_set_source_surface(draw, surface, area.x - centre.x() - 0.5, area.y - centre.y() - 0.5);
  cairo_paint(draw);
  cairo_restore(draw);
  cairo_surface_destroy(surface);
  layer.Touch(square);
}

}  // namespace

OverlayScene::OverlayScene(const OverlayContent& content, const OverlayOptions& options,
                           const video::VideoInfo& recorded, cv::Size shown)
    : content_(content),
      options_(options),
      scale_(static_cast<double>(shown.width) / recorded.width, static_cast<double>(shown.height) / recorded.height),
      layer_(shown, recorded.bt709),
      draw_(layer_.Context()),
      labels_(shown),
      unit_px_(std::max(0.55, std::min(shown.width, shown.height) / 720.0)),
      line_height_px_(20 * unit_px_),
      inset_half_px_(std::max(8.0, std::min(recorded.width, recorded.height) / 60.0)) {
  cairo_select_font_face(draw_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(draw_, 14 * unit_px_);
  cairo_font_extents_t font;
  cairo_font_extents(draw_, &font);
  middle_to_base_px_ = (font.ascent - font.descent) / 2;
  ChooseDecimals();
  PlacePanelAndInsets();
}

void OverlayScene::DrawOnto(video::VideoFrame& frame) {
  const std::optional<std::size_t> row = TrackRow(frame.index);
  const motion::LegSample* leg = Leg(frame.index);
  const auto& markers = content_.tracks.markers;
  labels_.Begin();
  labels_.Avoid(panel_);
  for (const cv::Rect2d& inset : insets_) labels_.Avoid(inset);
  if (row) {
    for (const motion::MarkerTrack& marker : markers) DrawTrail(marker, *row);
    DrawSkeleton(*row);
    for (const motion::MarkerTrack& marker : markers)
      if (marker.samples[*row].IsKnown()) DrawMark(marker, marker.samples[*row]);
    if (leg) DrawAngle(*row, *leg);
    for (const motion::MarkerTrack& marker : markers)
      if (marker.samples[*row].IsKnown())
        DrawLabel(marker.name, marker.name, Shown(marker.samples[*row].position), (kCross[1] + 2) * unit_px_, 0.45);
  }
  DrawPanel(frame.index, frame.time_s, leg);
  for (std::size_t m = 0; m < markers.size(); ++m) DrawInset(m, row, frame.luma);
  layer_.BlendOnto(frame.preview);
}

OverlayScene::Colour OverlayScene::MarkerColour(const std::string& name) {
  const char* hex = name == "ankle"           ? colour::kAnkle
                    : name == "knee"          ? colour::kKnee
                    : name == "hip"           ? colour::kHip
                    : name == "waist"         ? colour::kWaist
                    : name.starts_with("exo") ? colour::kExoskeleton
                                              : colour::kOther;
  const long rgb = std::strtol(hex + 1, nullptr, 16);
  return {static_cast<double>(rgb >> 16) / 255, static_cast<double>(rgb >> 8 & 255) / 255,
          static_cast<double>(rgb & 255) / 255};
}

// Pixel centres are whole numbers for us, and at a half for cairo and for scaling.
cv::Point2d OverlayScene::Shown(const Eigen::Vector2d& recorded_px) const {
  return {(recorded_px.x() + 0.5) * scale_.x, (recorded_px.y() + 0.5) * scale_.y};
}

std::optional<std::size_t> OverlayScene::TrackRow(std::int64_t frame) const {
  const auto& frames = content_.tracks.frame;
  const auto found = std::lower_bound(frames.begin(), frames.end(), frame);
  if (found == frames.end() || *found != frame) return std::nullopt;
  return static_cast<std::size_t>(found - frames.begin());
}

const motion::LegSample* OverlayScene::Leg(std::int64_t frame) const {
  if (!content_.motion) return nullptr;
  const auto& frames = content_.motion->frame;
  const auto found = std::lower_bound(frames.begin(), frames.end(), frame);
  if (found == frames.end() || *found != frame) return nullptr;
  const motion::LegSample& leg = content_.motion->samples[static_cast<std::size_t>(found - frames.begin())];
  return std::isfinite(leg.knee_deg) ? &leg : nullptr;
}

std::optional<cv::Point2d> OverlayScene::Place(const char* marker, std::size_t row) const {
  const motion::MarkerTrack* track = content_.tracks.Find(marker);
  if (!track || !track->samples[row].IsKnown()) return std::nullopt;
  return Shown(track->samples[row].position);
}

const motion::StsEvent* OverlayScene::RecentEvent(double time_s) const {
  const motion::StsEvent* recent = nullptr;
  if (!content_.events) return recent;
  for (const motion::StsEvent& event : *content_.events) {
    const bool just_happened = event.time_s <= time_s && time_s < event.time_s + kEventShown_s;
    if (just_happened && (!recent || event.time_s > recent->time_s)) recent = &event;
  }
  return recent;
}

void OverlayScene::ChooseDecimals() {
  if (!content_.motion) return;
  std::vector<double> sigmas;
  for (const motion::LegSample& leg : content_.motion->samples)
    if (std::isfinite(leg.knee_sigma_deg)) sigmas.push_back(leg.knee_sigma_deg);
  if (sigmas.empty()) return;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  decimals_ = *middle < 0.1 ? 2 : 1;
}

// Panel and insets as one row or as one column, in the corner through which the fewest markers go.
void OverlayScene::PlacePanelAndInsets() {
  const double margin = 12 * unit_px_;
  const cv::Size2d picture(layer_.Size().width - 2 * margin, layer_.Size().height - 2 * margin);
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const double width : {picture.width, kPanelWidth * unit_px_}) {
    const std::vector<cv::Rect2d> areas = LayOut(width);
    cv::Rect2d block;
    for (const cv::Rect2d& area : areas) block |= area;
    for (const double right : {0.0, picture.width - block.width})
      for (const double below : {0.0, picture.height - block.height}) {
        const cv::Point2d corner(margin + right, margin + std::max(0.0, below));
        const std::size_t hits = MarkersWithin(block + corner);
        if (hits >= fewest) continue;
        fewest = hits;
        panel_ = areas.front() + corner;
        insets_.assign(areas.begin() + 1, areas.end());
        for (cv::Rect2d& inset : insets_) inset += corner;
      }
  }
}

// The panel and the insets after it, in rows of this width at most.
std::vector<cv::Rect2d> OverlayScene::LayOut(double width) const {
  const double gap = kGap * unit_px_, side = kInsetSide * unit_px_;
  const cv::Size2d inset(side, side + 2 * line_height_px_);
  std::vector<cv::Rect2d> areas = {
      {0, 0, kPanelWidth * unit_px_, (content_.motion ? 4 : 2) * line_height_px_ + 2 * kPanelPadding * unit_px_}};
  double left = areas.front().width + gap, top = 0, bottom = areas.front().height;
  for (std::size_t m = 0; m < content_.tracks.markers.size(); ++m) {
    if (left + inset.width > width + 1) {
      left = 0;
      top = bottom + gap;
    }
    areas.emplace_back(cv::Point2d(left, top), inset);
    bottom = std::max(bottom, top + inset.height);
    left += inset.width + gap;
  }
  return areas;
}

// How often a marker of the recording is there.
std::size_t OverlayScene::MarkersWithin(const cv::Rect2d& block) const {
  const cv::Rect2d area = Around(block.tl(), block.br(), 2 * kMark * unit_px_);
  std::size_t hits = 0;
  for (const motion::MarkerTrack& marker : content_.tracks.markers)
    for (const motion::MarkerSample& sample : marker.samples)
      hits += sample.IsKnown() && area.contains(Shown(sample.position));
  return hits;
}

// In steps of equal age, each with one strength.
void OverlayScene::DrawTrail(const motion::MarkerTrack& marker, std::size_t row) {
  constexpr int kSteps = 10;
  const auto& time_s = content_.tracks.time_s;
  cairo_set_line_width(draw_, 2 * unit_px_);
  cairo_set_line_cap(draw_, CAIRO_LINE_CAP_BUTT);
  cairo_set_line_join(draw_, CAIRO_LINE_JOIN_ROUND);
  const auto step = [&](std::size_t i) {
    return static_cast<int>((time_s[row] - time_s[i]) / options_.trail_s * kSteps);
  };
  std::size_t i = row;
  while (i > 0 && step(i) < kSteps) {
    const int strength = kSteps - step(i);
    bool any = false;
    for (const int now = step(i); i > 0 && step(i) == now; --i) {
      if (!marker.samples[i].IsKnown() || !marker.samples[i - 1].IsKnown()) continue;
      const cv::Point2d newer = Shown(marker.samples[i].position), older = Shown(marker.samples[i - 1].position);
      if (!cairo_has_current_point(draw_)) cairo_move_to(draw_, newer.x, newer.y);
      cairo_line_to(draw_, older.x, older.y);
      layer_.Touch(Around(newer, older, 3 * unit_px_));
      any = true;
    }
    SetColour(MarkerColour(marker.name), 0.9 * strength / kSteps);
    if (any) cairo_stroke(draw_);
  }
}

void OverlayScene::DrawSkeleton(std::size_t row) {
  cairo_set_line_cap(draw_, CAIRO_LINE_CAP_ROUND);
  const double ring = (kMark + 1.5) * unit_px_;
  for (const auto& [lower, upper] : kBones) {
    const auto a = Place(lower, row), b = Place(upper, row);
    if (!a || !b) continue;
    labels_.AvoidLine(*a, *b);
    const double length = cv::norm(*b - *a);
    if (length <= 2 * ring) continue;
    const cv::Point2d along = (*b - *a) * (ring / length);  // the markers themselves stay free
    SetColour({0, 0, 0}, 0.35);
    Stroke(*a + along, *b - along, 4.5 * unit_px_);
    SetColour({1, 1, 1}, 0.85);
    Stroke(*a + along, *b - along, 2 * unit_px_);
  }
}

// Thin, and open where the marker is, so that one sees what was measured.
void OverlayScene::DrawMark(const motion::MarkerTrack& marker, const motion::MarkerSample& sample) {
  const cv::Point2d centre = Shown(sample.position);
  const Colour colour = MarkerColour(marker.name);
  if (sample.status == motion::SampleStatus::kDetected) {
    DrawCross(centre, kCross[0], kCross[1], colour);
  } else {
    const double radius = kMark * unit_px_, dash = 2 * CV_PI * radius / 16;
    cairo_new_path(draw_);
    cairo_set_line_cap(draw_, CAIRO_LINE_CAP_BUTT);
    cairo_arc(draw_, centre.x, centre.y, radius, 0, 2 * CV_PI);
    SetColour(colour);
    cairo_set_line_width(draw_, 1.8 * unit_px_);
    cairo_set_dash(draw_, &dash, 1, 0);
    cairo_stroke(draw_);
    cairo_set_dash(draw_, nullptr, 0, 0);
    layer_.Touch(Around(centre, centre, radius + 2 * unit_px_));
  }
  labels_.Avoid(Around(centre, centre, (kCross[1] + 1) * unit_px_));
}

void OverlayScene::DrawCross(cv::Point2d centre, double inner, double outer, const Colour& colour) {
  cairo_set_line_cap(draw_, CAIRO_LINE_CAP_BUTT);
  for (const bool halo : {true, false}) {
    if (halo)
      SetColour({0, 0, 0}, 0.45);
    else
      SetColour(colour);
    for (const cv::Point2d& arm : {cv::Point2d(1, 0), cv::Point2d(-1, 0), cv::Point2d(0, 1), cv::Point2d(0, -1)})
      Stroke(centre + arm * (inner * unit_px_), centre + arm * (outer * unit_px_), (halo ? 3.6 : 1.8) * unit_px_);
  }
}

// Flexion: from the shank's own line beyond the knee to the thigh.
void OverlayScene::DrawAngle(std::size_t row, const motion::LegSample& leg) {
  const auto ankle = Place("ankle", row), knee = Place("knee", row), hip = Place("hip", row);
  if (!ankle || !knee || !hip) return;
  const cv::Point2d shank = *knee - *ankle, thigh = *hip - *knee;
  const double radius = std::clamp(0.35 * std::min(cv::norm(shank), cv::norm(thigh)), 18 * unit_px_, 52 * unit_px_);
  if (cv::norm(shank) < 1 || cv::norm(thigh) < 1) return;
  const cv::Point2d beyond = shank * (1.25 * radius / cv::norm(shank)),
                    inside = shank * ((kMark + 1.5) * unit_px_ / cv::norm(shank));
  const double from = std::atan2(shank.y, shank.x),
               turn = std::remainder(std::atan2(thigh.y, thigh.x) - from, 2 * CV_PI);

  const Colour knee_colour = MarkerColour("knee");
  const double dash = 4 * unit_px_;
  cairo_set_line_cap(draw_, CAIRO_LINE_CAP_BUTT);
  cairo_set_dash(draw_, &dash, 1, 0);
  SetColour({1, 1, 1}, 0.8);
  Stroke(*knee + inside, *knee + beyond, 1.5 * unit_px_);
  cairo_set_dash(draw_, nullptr, 0, 0);

  const auto arc = turn >= 0 ? cairo_arc : cairo_arc_negative;
  cairo_new_path(draw_);
  cairo_move_to(draw_, knee->x, knee->y);
  arc(draw_, knee->x, knee->y, radius, from, from + turn);
  cairo_close_path(draw_);
  SetColour(knee_colour, 0.18);
  cairo_fill(draw_);
  arc(draw_, knee->x, knee->y, radius, from, from + turn);
  SetColour(knee_colour);
  cairo_set_line_width(draw_, 2.5 * unit_px_);
  cairo_stroke(draw_);
  layer_.Touch(Around(*knee, *knee, 1.25 * radius + 4 * unit_px_));

  labels_.AvoidLine(*knee, *knee + beyond);
  const cv::Point2d bow(std::cos(from + turn / 2), std::sin(from + turn / 2));
  labels_.Avoid(Around(*knee + bow * radius, *knee + bow * radius, 6 * unit_px_));
  DrawLabel("knee angle", AngleText(leg), *knee + bow * radius, 12 * unit_px_, 0.6);
}

void OverlayScene::DrawLabel(const std::string& of, const std::string& text, cv::Point2d centre, double radius_px,
                             double alpha) {
  const double padding = 4 * unit_px_;
  const cv::Size2d size(TextWidth(text) + 2 * padding, line_height_px_);
  const cv::Rect2d box(labels_.Place(of, centre, radius_px, size), size);
  Box(box, {0, 0, 0}, alpha);
  Text(text, {box.x + padding, box.y + box.height / 2}, {1, 1, 1});
}

void OverlayScene::DrawPanel(std::int64_t frame, double time_s, const motion::LegSample* leg) {
  constexpr Colour kWhite = {1, 1, 1}, kDim = {0.72, 0.72, 0.72};
  Box(panel_, {0.05, 0.05, 0.07}, 0.62);
  const double left = panel_.x + kPanelPadding * unit_px_, right = panel_.x + panel_.width - kPanelPadding * unit_px_;
  double y = panel_.y + kPanelPadding * unit_px_ + line_height_px_ / 2;
  const std::string number = fmt::format("frame {}", frame);
  Text(fmt::format("{:.3f} s", time_s), {left, y}, kWhite);
  Text(number, {right - TextWidth(number), y}, kDim);
  y += line_height_px_;
  if (content_.motion) {
    const std::string angle = leg ? AngleText(*leg) : "unknown";
    Text("knee flexion", {left, y}, kDim);
    Text(angle, {right - TextWidth(angle), y}, leg ? MarkerColour("knee") : kDim);
    y += line_height_px_;
    DrawProgress(y, leg);
    y += line_height_px_;
  }
  if (const motion::StsEvent* event = RecentEvent(time_s)) {
    const std::string which = fmt::format("repetition {}", event->repetition);
    Text(ShownName(event->kind), {left, y}, {1, 0.85, 0.35});
    Text(which, {right - TextWidth(which), y}, kDim);
  } else if (!content_.note.empty()) {
    Text(content_.note, {left, y}, {1, 0.85, 0.35});
  }
}

void OverlayScene::DrawProgress(double y, const motion::LegSample* leg) {
  constexpr Colour kDim = {0.72, 0.72, 0.72};
  const double left = panel_.x + kPanelPadding * unit_px_, right = panel_.x + panel_.width - kPanelPadding * unit_px_;
  if (!leg || !leg->repetition || !std::isfinite(leg->percent)) {
    Text("between rises", {left, y}, kDim);
    return;
  }
  const std::string percent = fmt::format("{:.0f} %", leg->percent);
  Text(fmt::format("rising {}", *leg->repetition), {left, y}, kDim);
  Text(percent, {right - TextWidth(percent), y}, {1, 1, 1});
  const double start = left + 72 * unit_px_, end = right - 50 * unit_px_, height = 5 * unit_px_;
  const cv::Rect2d bar(start, y - height / 2, end - start, height);
  Box(bar, {1, 1, 1}, 0.25);
  const double done = std::clamp(leg->percent / 100, 0.0, 1.0);
  Box({bar.x, bar.y, std::max(height, bar.width * done), height}, MarkerColour("knee"), 1);
}

void OverlayScene::DrawInset(std::size_t marker, std::optional<std::size_t> row, const cv::Mat& luma) {
  constexpr Colour kWhite = {1, 1, 1}, kDim = {0.72, 0.72, 0.72}, kWarning = {1, 0.85, 0.35};
  const motion::MarkerTrack& track = content_.tracks.markers[marker];
  const motion::MarkerSample sample = row ? track.samples[*row] : motion::MarkerSample{};
  const cv::Rect2d& area = insets_[marker];
  const cv::Rect2d square(area.x, area.y, area.width, area.width);
  Box(area, {0.05, 0.05, 0.07}, 0.62);
  const double left = area.x + 4 * unit_px_;
  double y = square.y + square.height + line_height_px_ / 2;
  if (sample.IsKnown()) {
    DrawMagnified(layer_, luma, sample.position, inset_half_px_, square);
    const cv::Point2d middle(square.x + square.width / 2, square.y + square.height / 2);
    DrawCross(middle, sample.status == motion::SampleStatus::kDetected ? 12 : 30, 50, MarkerColour(track.name));
    DrawEstimate(marker, *row, square);
  }
  const bool detected = sample.status == motion::SampleStatus::kDetected;
  Text(track.name, {left, y}, MarkerColour(track.name));
  if (!detected) {
    const std::string state(motion::ToString(sample.status));
    Text(state, {area.x + area.width - 4 * unit_px_ - TextWidth(state), y}, kWarning);
  }
  y += line_height_px_;
  if (sample.IsKnown()) Text(Accuracy(marker, *row), {left, y}, detected ? kWhite : kDim);
}

// The leg fit's estimate, where it lies in the inset.
void OverlayScene::DrawEstimate(std::size_t marker, std::size_t row, const cv::Rect2d& square) {
  if (!content_.estimates || !content_.estimates->markers[marker].samples[row].IsKnown()) return;
  const Eigen::Vector2d off =
      content_.estimates->markers[marker].samples[row].position - content_.tracks.markers[marker].samples[row].position;
  const double magnified = square.width / (2 * inset_half_px_), radius = 4 * unit_px_;
  const cv::Point2d centre(square.x + square.width / 2 + off.x() * magnified,
                           square.y + square.height / 2 + off.y() * magnified);
  if (!square.contains(centre)) return;
  cairo_new_path(draw_);
  cairo_arc(draw_, centre.x, centre.y, radius, 0, 2 * CV_PI);
  SetColour({1, 1, 1}, 0.9);
  cairo_set_line_width(draw_, 1.2 * unit_px_);
  cairo_stroke(draw_);
}

// How far the position is from the leg fit's estimate, and its standard deviation.
std::string OverlayScene::Accuracy(std::size_t marker, std::size_t row) const {
  const motion::MarkerSample& sample = content_.tracks.markers[marker].samples[row];
  const std::string deviation =
      sample.sigma < kLeastTold_px ? fmt::format("±<{} px", kLeastTold_px) : fmt::format("±{:.2f} px", sample.sigma);
  if (sample.status != motion::SampleStatus::kDetected || !content_.estimates ||
      !content_.estimates->markers[marker].samples[row].IsKnown())
    return deviation;
  const double off_px = (content_.estimates->markers[marker].samples[row].position - sample.position).norm();
  return fmt::format("{:.2f} {}", off_px, deviation);
}

void OverlayScene::Stroke(cv::Point2d from, cv::Point2d to, double width_px) {
  cairo_set_line_width(draw_, width_px);
  cairo_move_to(draw_, from.x, from.y);
  cairo_line_to(draw_, to.x, to.y);
  cairo_stroke(draw_);
  // Along the line, piece by piece: the box round a slanting line is large.
  const int pieces = 1 + static_cast<int>(cv::norm(to - from) / 32);
  for (int i = 0; i < pieces; ++i)
    layer_.Touch(Around(from + (to - from) * (static_cast<double>(i) / pieces),
                        from + (to - from) * (static_cast<double>(i + 1) / pieces), width_px));
}

void OverlayScene::Box(const cv::Rect2d& area, const Colour& colour, double alpha) {
  const double r = std::min(4 * unit_px_, area.height / 2), right = area.x + area.width, bottom = area.y + area.height;
  cairo_new_path(draw_);
  cairo_arc(draw_, right - r, area.y + r, r, -CV_PI / 2, 0);
  cairo_arc(draw_, right - r, bottom - r, r, 0, CV_PI / 2);
  cairo_arc(draw_, area.x + r, bottom - r, r, CV_PI / 2, CV_PI);
  cairo_arc(draw_, area.x + r, area.y + r, r, CV_PI, 1.5 * CV_PI);
  cairo_close_path(draw_);
  SetColour(colour, alpha);
  cairo_fill(draw_);
  layer_.Touch(area);
}

void OverlayScene::SetColour(const Colour& colour, double alpha) {
  cairo_set_source_rgba(draw_, colour.r, colour.g, colour.b, alpha);
}

// Only inside boxes, which say where something was drawn.
void OverlayScene::Text(const std::string& text, cv::Point2d left_middle, const Colour& colour) {
  SetColour(colour);
  cairo_move_to(draw_, left_middle.x, left_middle.y + middle_to_base_px_);
  cairo_show_text(draw_, text.c_str());
  cairo_new_path(draw_);
}

double OverlayScene::TextWidth(const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(draw_, text.c_str(), &extents);
  return extents.x_advance;
}

std::string OverlayScene::AngleText(const motion::LegSample& leg) const {
  if (!std::isfinite(leg.knee_sigma_deg)) return fmt::format("{:.{}f}°", leg.knee_deg, decimals_);
  return fmt::format("{:.{}f}° ± {}", leg.knee_deg, decimals_, DeviationText(leg.knee_sigma_deg, decimals_, "°"));
}

}  // namespace lake::overlay
