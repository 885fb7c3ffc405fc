#include "lake/synth/recording.h"

#include <optional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/video/image.h"
#include "lake/video/video_writer.h"

namespace lake::synth {
namespace {

namespace fs = std::filesystem;

// Without loss x264's search finds nothing in the noise: its fastest preset takes a quarter of the time and makes files
// that are a fifth larger.
const char* PresetOf(const RecordingOptions& options) {
  return options.lossless ? "ultrafast" : options.preset;
}

// The frames go into a video or a folder of pictures.
class FrameSink {
 public:
  FrameSink(const Scene& scene, const fs::path& folder, const RecordingOptions& options) {
    if (options.pictures) {
      pictures_ = folder / "frames";
      std::error_code error;
      fs::create_directories(*pictures_, error);
      if (error) throw Fail("{}: the folder cannot be made: {}", pictures_->string(), error.message());
      return;
    }
    video::VideoWriterOptions video{.width = scene.Profile().camera.image_width,
                                    .height = scene.Profile().camera.image_height,
                                    .frame_rate_hz = scene.Options().frame_rate_hz,
                                    .crf = options.crf,
                                    .lossless = options.lossless,
                                    .grey = !scene.Options().colour,
                                    .preset = PresetOf(options)};
    video_.emplace(folder / "video.mp4", video);
  }

  void Write(const cv::Mat& picture, int frame, double time_s) {
    if (video_)
      video_->Write(picture, time_s);
    else
      video::WriteImage(*pictures_ / fmt::format("{:05d}.png", frame), picture);
  }

  void Finish() {
    if (video_) video_->Finish();
  }

 private:
  std::optional<video::VideoWriter> video_;
  std::optional<fs::path> pictures_;
};

std::string_view NameOf(StsPhase::Kind kind) {
  switch (kind) {
    case StsPhase::Kind::kSeated:
      return "seated";
    case StsPhase::Kind::kRise:
      return "rise";
    case StsPhase::Kind::kStanding:
      return "standing";
    case StsPhase::Kind::kDescent:
      return "descent";
  }
  return "";
}

Json SceneJson(const Scene& scene, const RecordingOptions& options) {
  Json json = ToJson(scene.Options());
  json["frames"] = scene.Frames();
  json["video"] = {{"crf", options.lossless ? Json() : Json(options.crf)},
                   {"lossless", options.lossless || options.pictures},
                   {"preset", PresetOf(options)}};
  if (const auto* sts = dynamic_cast<const StsMotion*>(&scene.Motion())) {
    json["phases"] = Json::array();
    for (const StsPhase& phase : sts->Phases())
      json["phases"].push_back({{"kind", NameOf(phase.kind)},
                                {"start_s", scene.Options().start_s + phase.start_s},
                                {"end_s", scene.Options().start_s + phase.end_s}});
  }
  return json;
}

}  // namespace

void WriteTruthCsv(const fs::path& path, const Scene& scene, const std::vector<FrameTruth>& truth) {
  std::vector<std::string> header = {"frame", "time_s"};
  const auto& names = scene.Motion().Names();
  for (const std::string& name : names)
    for (const char* column : {"_x_px", "_y_px", "_visible", "_x_mm", "_y_mm"}) header.push_back(name + column);
  header.push_back("knee_deg");
  for (const std::string& name : names) header.push_back(name + "_covered");
  CsvWriter csv(header);
  for (std::size_t frame = 0; frame < truth.size(); ++frame) {
    csv.Add(frame).Add(truth[frame].time_s);
    for (const MarkerTruth& marker : truth[frame].markers)
      csv.Add(marker.px.x()).Add(marker.px.y()).Add(marker.visible).Add(marker.mm.x()).Add(marker.mm.y());
    csv.Add(truth[frame].knee_deg);
    for (const MarkerTruth& marker : truth[frame].markers) csv.Add(marker.covered);
    csv.EndRow();
  }
  csv.Write(path);
}

RecordingSummary WriteRecording(const Scene& scene, const fs::path& folder, const RecordingOptions& options) {
  FrameSink sink(scene, folder, options);
  RecordingSummary summary{scene.Frames(), scene.Motion().Names(), std::vector<int>(scene.Motion().Names().size(), 0)};
  std::vector<FrameTruth> truth;
  Progress progress("rendering", "frames", scene.Frames(), options.quiet);
  for (int frame = 0; frame < scene.Frames(); ++frame) {
    ThrowIfInterrupted();
    truth.push_back(scene.Truth(frame));
    for (std::size_t m = 0; m < summary.markers.size(); ++m)
      summary.hidden_frames[m] += truth.back().markers[m].visible ? 0 : 1;
    sink.Write(scene.Render(frame), frame, truth.back().time_s);
    progress.Advance();
  }
  WriteTruthCsv(folder / "truth.csv", scene, truth);
  camera::WriteCameraProfile(folder / "camera.yaml", scene.Profile());
  WriteJsonFile(folder / "scene.json", SceneJson(scene, options));
  sink.Finish();
  return summary;
}

}  // namespace lake::synth
