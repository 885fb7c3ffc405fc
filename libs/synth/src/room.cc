#include "room.h"

#include "body.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

struct Palette {
  cv::Vec3f wall, floor, baseboard, seat, steel, desk, screen, poster, frame;
};

Palette PaletteOf(bool bright) {
  if (bright)
    return {{208, 206, 200}, {165, 172, 180}, {150, 150, 150}, {140, 135, 130}, {185, 185, 185},
            {130, 150, 170}, {110, 108, 106}, {225, 225, 225}, {120, 120, 120}};
  return {{112, 108, 100}, {60, 68, 78}, {48, 50, 52},    {58, 40, 32}, {96, 96, 94},
          {58, 78, 98},    {18, 17, 16}, {140, 142, 142}, {40, 40, 42}};
}

// The lowest place of the hip, or of the lowest marker but the ankle: there the seat is.
Vector2d SeatedHip(const MarkerMotion& motion) {
  const int hip = IndexOfMarker(motion, "hip");
  Vector2d lowest(0, 1e9);
  for (double t = 0; t <= motion.DurationS(); t += 0.05) {
    const std::vector<Vector2d> markers = motion.At(t);
    const Vector2d& marker = hip >= 0 ? markers[hip] : markers.front();
    if (marker.y() < lowest.y()) lowest = marker;
  }
  return lowest;
}

class RoomPainter {
 public:
  RoomPainter(const SceneOptions& options, const View& view, const MarkerMotion& motion)
      : view_(view),
        bright_(options.bright_room),
        colours_(PaletteOf(options.bright_room)),
        plaster_(options.seed, "plaster", 1.0, 60, 0.8),
        grain_(options.seed, "grain", 0.8, 30, 0.5),
        forward_(motion.FacingInImage() == motion::Facing::kRight ? 1 : -1) {
    const int ankle = IndexOfMarker(motion, "ankle");
    if (ankle >= 0) ankle_ = motion.At(0)[ankle];
    hip_ = SeatedHip(motion);
    if (ankle < 0 || !options.walk) return;
    is_seated_ = false;
    ankle_ = view.Plane({0.5 * view.Size().width, 0.5 * view.Size().height});
    for (double t = 0; t <= motion.DurationS(); t += 0.05) ankle_.y() = std::min(ankle_.y(), motion.At(t)[ankle].y());
  }

  void Paint(Canvas& canvas) {
    canvas_ = &canvas;
    const double ground = ankle_.y() - kSoleBelowAnkle;
    Wall();
    Fill(colours_.floor, Box(-3500, ground - 900, 3500, ground + 150), &grain_, bright_ ? 0.03f : 0.08f, 3.0f);
    for (int board = 0; board < 4; ++board)  // seams of the floor, closer together towards the wall
      Fill(0.8f * colours_.floor, Box(-3500, ground + 112 - 60 * board - 8 * board * board, 3500,
                                      ground + 115 - 60 * board - 8 * board * board));
    Fill(colours_.baseboard, Box(-3500, ground + 150, 3500, ground + 225));
    Wallware(ground);
    Desk(ground);
    if (is_seated_) Chair(ground);
  }

 private:
  // The side to which the person looks is positive in all that follows.
  Polygon Placed(Polygon polygon) const {
    for (Vector2d& p : polygon) p.x() = ankle_.x() + forward_ * p.x();
    return polygon;
  }

  void Fill(const cv::Vec3f& bgr, const Polygon& polygon, const Texture* texture = nullptr, float contrast = 0,
            float mm_per_texel = 2) {
    SeenLayer(view_, {{bgr, texture, contrast, mm_per_texel, 0}, {{Placed(polygon)}}, 0}).PaintOn(*canvas_);
  }

  // Plaster lit by a window on the side that the person looks to.
  void Wall() {
    cv::Mat& image = canvas_->image;
    const int channels = image.channels();
    const cv::Vec3f colour = channels == 1 ? cv::Vec3f::all(Grey(colours_.wall)) : colours_.wall;
    for (int row = 0; row < image.rows; ++row)
      for (int column = 0; column < image.cols; ++column) {
        const float side = static_cast<float>(forward_ * (2.0 * column / image.cols - 1)),
                    up = 1 - 2.0f * row / image.rows;
        const float factor = (1 + 0.14f * side + 0.06f * up) * (1 + 0.02f * plaster_.At(column * 0.5f, row * 0.5f));
        for (int c = 0; c < channels; ++c) image.ptr<float>(row)[column * channels + c] = factor * colour[c];
      }
  }

  void Wallware(double ground) {
    Fill(colours_.poster, Box(-1080, ground + 860, -800, ground + 1260));
    Fill(0.9f * colours_.wall, Box(-1060, ground + 1060, -820, ground + 1235));
    for (int line = 0; line < 5; ++line)
      Fill(colours_.frame, Box(-1055, ground + 890 + 32 * line, -845 - 25 * (line % 3), ground + 897 + 32 * line));
    Fill(1.12f * colours_.wall, Box(330, ground + 225, 342, ground + 2400));  // a door frame
    Fill(0.8f * colours_.wall, Box(342, ground + 225, 348, ground + 2400));
    Fill(1.25f * colours_.wall, Box(420, ground + 420, 470, ground + 470));  // a socket
    Fill(0.5f * colours_.wall, Box(436, ground + 440, 454, ground + 450));
  }

  void Desk(double ground) {
    Fill(colours_.frame, Box(690, ground + 40, 725, ground + 720));
    Fill(colours_.frame, Box(1180, ground + 40, 1215, ground + 720));
    Fill(colours_.desk, Box(620, ground + 720, 1400, ground + 752), &grain_, 0.06f);
    Fill(colours_.screen, Box(760, ground + 860, 1230, ground + 1150));
    Fill(colours_.frame, Box(940, ground + 752, 990, ground + 860));
    Fill(colours_.screen, Box(700, ground + 752, 860, ground + 764));
  }

  void Chair(double ground) {
    const double x = forward_ * (hip_.x() - ankle_.x()), top = hip_.y() - kThighRadiusAtHip + 8;
    const double leg_bottom = ground + 25;
    for (const double leg : {x - 165, x + 165})
      Fill(0.7f * colours_.steel, Box(leg + 14, ground + 60, leg + 36, top - 45));
    Fill(colours_.steel, Box(x - 185, leg_bottom, x - 161, top - 45));
    Fill(colours_.steel, Box(x + 165, leg_bottom, x + 189, top - 45));
    Fill(0.85f * colours_.steel, Box(x - 170, leg_bottom + 90, x + 175, leg_bottom + 106));
    Fill(colours_.seat, Box(x - 205, top - 52, x + 205, top), &grain_, 0.08f);
    Fill(colours_.steel, {{x - 200, top - 20}, {x - 182, top - 20}, {x - 232, top + 470}, {x - 250, top + 470}});
    Fill(colours_.seat, {{x - 226, top + 190}, {x - 196, top + 190}, {x - 226, top + 460}, {x - 256, top + 460}},
         &grain_, 0.08f);
  }

  const View& view_;
  bool bright_;
  Palette colours_;
  Texture plaster_, grain_;
  double forward_;
  Vector2d ankle_{0, 0}, hip_;
  bool is_seated_ = true;
  Canvas* canvas_ = nullptr;
};

}  // namespace

Canvas PaintRoom(const SceneOptions& options, const View& view, const MarkerMotion& motion) {
  Canvas canvas{cv::Mat(view.Size(), options.colour ? CV_32FC3 : CV_32FC1, cv::Scalar::all(options.background_level)),
                {}};
  if (options.room) RoomPainter(options, view, motion).Paint(canvas);
  return canvas;
}

}  // namespace lake::synth
