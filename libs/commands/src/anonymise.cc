#include "lake/commands/anonymise.h"

#include <fmt/format.h>

#include <algorithm>

#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/motion/marker_recording.h"
#include "lake/video/video_files.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

fs::path TrialFile(const fs::path& trial, const char* name) {
  if (const auto file = FindResult(trial, name)) return *file;
  throw Fail("{}: no {} in it; --trial is the folder that lake track made of the video", trial.string(), name);
}

// Frames and pixels are those of one video only.
void CheckIsTrialOf(const fs::path& video, const Json& summary, const fs::path& trial) {
  const std::string hash = Sha256OfFile(video::FilesOfVideo(video));
  const Json inputs = summary.value("inputs", Json::array());
  if (std::any_of(inputs.begin(), inputs.end(), [&](const Json& input) { return input.value("sha256", "") == hash; }))
    return;
  throw Fail("{}: not the video that {} was tracked in; their contents differ", video.string(), trial.string());
}

void CheckSize(const fs::path& video, const video::VideoReaderOptions& reader, const Json& tracked) {
  const video::VideoInfo info = video::VideoReader::Open(video, reader)->Info();
  const int width = tracked.value("width", 0), height = tracked.value("height", 0);
  if (info.width != width || info.height != height)
    throw Fail("{}: {}×{} px, but it was tracked as {}×{} px: give the same --rotate as to lake track", video.string(),
               info.width, info.height, width, height);
}

}  // namespace

void Describe(AnonymiseRunOptions& o, OptionList& options) {
  options.AddOperand("video", o.video, "Video, or image sequence as frames/%05d.png")
      .Required()
      .IsPath(Option::Path::kVideo);
  options.Add("trial", o.trial, "Folder that lake track made of this video: it knows where the trunk is")
      .Value("TRACKDIR")
      .Required();
  options.Add("crf", o.copy.crf, "H.264 quality, 0 to 51, for a smaller file").Between(0, 51).Otherwise("without loss");
  video::DescribeCaptureRate(o.copy.reader, options);
  video::DescribeRotation(o.copy.reader, options);
}

Json RunAnonymise(const AnonymiseRunOptions& options, Run& run) {
  const fs::path tracks = TrialFile(options.trial, "tracks.csv"),
                 summary_file = TrialFile(options.trial, "summary.json");
  const Json summary = ReadJsonFile(summary_file);
  try {
    CheckIsTrialOf(options.video, summary, options.trial);
    CheckSize(options.video, options.copy.reader, summary.value("video", Json::object()));
  } catch (const Json::exception& error) {
    throw Fail("{}: not a summary of lake-track ({})", summary_file.string(), error.what());
  }
  run.AddInput(video::FilesOfVideo(options.video), "video");
  run.AddInput(tracks, "tracks");
  const overlay::HeadBlur blur(motion::ReadMarkerCsv(tracks));
  run.Begin({"summary.json", "anonymised.mp4"});
  overlay::AnonymiseOptions copy = options.copy;
  copy.quiet = run.Quiet();
  const overlay::AnonymisedCopy done =
      overlay::WriteAnonymisedVideo(options.video, blur, copy, run.Result("anonymised.mp4"));
  if (done.whole > 0)
    run.Warn("in {} of {} frames the head's position is unknown: there the whole picture is blurred", done.whole,
             done.frames);
  if (done.beside_leg > 0)
    run.Warn(
        "in {} of {} frames leg or markers, which are left as they are, are where the face may be: look at these "
        "frames",
        done.beside_leg, done.frames);
  run.Report("{} frames; {}\nOnly the tracked subject is blurred: look for others in the picture.\n", done.frames,
             done.is_exact ? "what is not blurred is the recording's to the bit"
                           : "what is not blurred was encoded anew, so tracks differ a little");
  return {{"frames", done.frames},
          {"frames_blurred_whole", done.whole},
          {"frames_beside_leg", done.beside_leg},
          {"exact_beside_the_head", done.is_exact}};
}

}  // namespace lake::commands
