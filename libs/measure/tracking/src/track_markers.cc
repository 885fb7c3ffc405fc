#include "lake/tracking/track_markers.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/tracking/tracklet.h"
#include "lake/video/frame_queue.h"

namespace lake::tracking {
namespace {

bool IsName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
}

// The luma of one frame of a video.
cv::Mat ReadLuma(const std::filesystem::path& video, std::int64_t frame, video::VideoReaderOptions options) {
  options.first = frame, options.last = frame;
  video::VideoFrame read;
  if (!video::VideoReader::Open(video, options)->Read(read)) throw Fail("{}: has no frame {}", video.string(), frame);
  return read.luma.clone();
}

std::unique_ptr<MarkerDetector> MakeDetector(const std::filesystem::path& video, const TrackOptions& options) {
  const DetectorRegion region{options.crop};
  switch (options.detector) {
    case DetectorKind::kReflective:
      return MakeReflectiveDetector(options.polarity, region);
    case DetectorKind::kColor:
      return MakeColorDetector(options.colors, region);
    case DetectorKind::kTemplate: {
      std::vector<cv::Mat> pictures;
      for (const MarkerSeed& seed : options.seeds) pictures.push_back(ReadLuma(video, seed.frame, options.reader));
      return MakeTemplateDetector(options.seeds, pictures, region);
    }
    case DetectorKind::kAruco:
      return MakeArucoDetector(options.dictionary, region);
  }
  throw UsageError("no such detector");
}

// The identity that the detector gives to each name; empty where it gives none.
std::vector<int> Identities(const TrackOptions& options) {
  std::vector<int> identities(options.names.size());
  std::iota(identities.begin(), identities.end(), 0);
  switch (options.detector) {
    case DetectorKind::kReflective:
      return {};
    case DetectorKind::kColor:
      return options.colors.size() > 1 ? identities : std::vector<int>{};
    case DetectorKind::kAruco:
      return identities;
    case DetectorKind::kTemplate:
      break;
  }
  for (std::size_t n = 0; n < options.names.size(); ++n)
    identities[n] =
        static_cast<int>(std::find_if(options.seeds.begin(), options.seeds.end(),
                                      [&](const MarkerSeed& seed) { return seed.name == options.names[n]; }) -
                         options.seeds.begin());
  return identities;
}

void CheckPlaces(const TrackOptions& options, const video::VideoInfo& video) {
  for (const MarkerSeed& seed : options.seeds) {
    if (seed.candidate) continue;
    const auto [x, y] = std::tuple(seed.position.x(), seed.position.y());
    if (!(x >= 0 && y >= 0 && x <= video.width - 1 && y <= video.height - 1))
      throw Fail("--seed {}={},{}: outside the picture of {}x{} px", seed.name, x, y, video.width, video.height);
  }
  const cv::Rect picture(0, 0, video.width, video.height);
  if (!options.crop.empty() && (options.crop & picture) != options.crop)
    throw Fail("--crop {},{},{},{}: reaches outside the picture of {}x{} px", options.crop.x, options.crop.y,
               options.crop.width, options.crop.height, video.width, video.height);
}

void CheckSeedFrames(const TrackOptions& options, const motion::MarkerRecording& recording) {
  for (const MarkerSeed& seed : options.seeds)
    if (!seed.candidate && (seed.frame < recording.frame.front() || seed.frame > recording.frame.back()))
      throw Fail("--seed {}: frame {} was not looked at (frames {} to {} were)", seed.name, seed.frame,
                 recording.frame.front(), recording.frame.back());
}

double MedianRadius(const std::vector<Tracklet>& tracklets) {
  std::vector<double> radii;
  for (const Tracklet& tracklet : tracklets)
    for (const TrackletSample& sample : tracklet.samples) radii.push_back(sample.radius_px);
  return Median(std::move(radii));
}

}  // namespace

void TrackOptions::Check() const {
  physics.Check();
  if (names.empty()) throw UsageError("--markers: no names");
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (!IsName(name)) throw UsageError(fmt::format("--markers: '{}' is not a name (letters, digits, _ - .)", name));
    if (!seen.insert(name).second) throw UsageError(fmt::format("--markers: '{}' stands twice", name));
  }
  std::set<std::string> seeded;
  for (const MarkerSeed& seed : seeds) {
    if (!seen.contains(seed.name))
      throw UsageError(fmt::format("--seed {}: not one of the markers ({})", seed.name, fmt::join(names, ", ")));
    if (!seeded.insert(seed.name).second) throw UsageError(fmt::format("--seed {}: given twice", seed.name));
  }
  if (detector == DetectorKind::kColor && colors.size() > 1 && colors.size() != names.size())
    throw UsageError(fmt::format("--color: {} colours for {} markers; give one for all or one for each", colors.size(),
                                 names.size()));
  if (detector != DetectorKind::kColor && !colors.empty()) throw UsageError("--color is for --detector color");
  if (detector == DetectorKind::kTemplate && seeded.size() != names.size())
    throw UsageError("--detector template needs a --seed for each marker: the patch is cut there");
  for (const MarkerSeed& seed : seeds)
    if (seed.candidate && detector == DetectorKind::kTemplate)
      throw UsageError(
          fmt::format("--seed {}=#{}: --detector template needs the place in px", seed.name, *seed.candidate));
}

namespace {

// What was followed over all frames, not yet named.
struct Followed {
  TrackResult result;
  std::vector<Tracklet> tracklets;
  std::vector<std::int64_t> repeated, breaks;  // frames: TrackletBuilder's
};

Followed Follow(const std::filesystem::path& video, const TrackOptions& options) {
  options.Check();
  const std::unique_ptr<MarkerDetector> detector = MakeDetector(video, options);
  video::VideoReaderOptions reader_options = options.reader;
  reader_options.colour = detector->NeedsColour();
  const std::unique_ptr<video::VideoReader> reader = video::VideoReader::Open(video, reader_options);
  if (reader->Info().interlaced)
    throw Fail(
        "{}: is interlaced: each frame holds two fields that were taken at different times; make a frame of each field "
        "(ffmpeg -i {} -vf bwdif=mode=send_field -crf 15 progressive.mp4), or record progressively",
        video.string(), video.string());
  CheckPlaces(options, reader->Info());

  Followed followed;
  motion::MarkerRecording& recording = followed.result.recording;
  TrackletOptions tracklet_options;
  tracklet_options.physics = options.physics;
  for (const MarkerSeed& seed : options.seeds)
    if (!seed.candidate) tracklet_options.seeds.push_back({seed.frame, seed.position});
  TrackletBuilder builder(*detector, tracklet_options);
  {
    Progress progress("tracking", "frames", reader->Info().frames, options.quiet);
    video::FrameQueue queue(*reader);
    for (video::VideoFrame frame; queue.Pop(frame); progress.Advance()) {
      ThrowIfInterrupted();
      recording.frame.push_back(frame.index);
      recording.time_s.push_back(frame.time_s);
      builder.Add(frame);
    }
  }
  followed.result.video = reader->Info();
  if (recording.Frames() < 2)
    throw Fail("{}: has only {} frame; a motion needs more", video.string(), recording.Frames());
  CheckSeedFrames(options, recording);
  followed.tracklets = builder.Finish();
  followed.repeated = builder.RepeatedFrames(), followed.breaks = builder.Breaks();
  followed.result.tracklets = followed.tracklets.size();
  followed.result.radius_px = MedianRadius(followed.tracklets);
  return followed;
}

}  // namespace

TrackResult TrackMarkers(const std::filesystem::path& video, const TrackOptions& options) {
  auto [result, tracklets, repeated, breaks] = Follow(video, options);
  const NamingOptions naming{options.names,   options.seeds, Identities(options), options.metric_from_px, options.up_px,
                             options.physics, breaks};
  try {
    NameTracklets(tracklets, naming, result.recording);
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    throw NamingError(fmt::format("{}: {}", video.string(), error.what()), ListCandidates(tracklets));
  }
  try {
    result.times = CorrectFrameTimes(repeated, result.recording);
  } catch (const Error& error) {
    throw Fail("{}: {}", video.string(), error.what());
  }
  result.sigma = CalibrateSigmas(result.recording);
  return result;
}

CandidateList FindCandidates(const std::filesystem::path& video, const TrackOptions& options) {
  return ListCandidates(Follow(video, options).tracklets);
}

}  // namespace lake::tracking
