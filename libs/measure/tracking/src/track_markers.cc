#include "lake/tracking/track_markers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "detector_kinds.h"
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

// How much the first leg marker moves, as a part of what the third does: feet stay, hips move.
double FootMotion(const motion::MarkerRecording& recording) {
  const auto extent = [&](std::string_view name) {
    const motion::MarkerTrack* track = recording.Find(name);
    if (!track) return 1.0;
    Eigen::AlignedBox2d box;
    for (const motion::MarkerSample& sample : track->samples)
      if (sample.IsKnown()) box.extend(sample.position);
    return box.isEmpty() ? 1.0 : box.diagonal().norm();
  };
  return extent(kLegMarkers[0]) / std::max(extent(kLegMarkers[2]), 1.0);
}

// Where several directions may be up, that with which the markers can be named and the foot rests best.
void NameWithEachUp(const std::vector<Tracklet>& tracklets, const TrackOptions& options,
                    const std::vector<std::int64_t>& discontinuities, const std::vector<std::int64_t>& repeated,
                    TrackResult& result) {
  const cv::Rect seen = options.crop.empty() ? cv::Rect(0, 0, result.video.width, result.video.height) : options.crop;
  const Eigen::AlignedBox2d picture(Eigen::Vector2d(seen.x, seen.y),
                                    Eigen::Vector2d(seen.x + seen.width, seen.y + seen.height));
  std::vector<Eigen::Vector2d> ups = {options.up_px};
  ups.insert(ups.end(), options.other_ups_px.begin(), options.other_ups_px.end());
  std::optional<motion::MarkerRecording> best;
  std::optional<Error> first_error;
  for (const Eigen::Vector2d& up : ups) {
    motion::MarkerRecording named = result.recording;
    try {
      NameTracklets(tracklets,
                    {options.names, options.seeds, KindOf(options).identities(options), options.metric_from_px, up,
                     options.physics, discontinuities, repeated, picture, options.reader.rotate_deg},
                    named);
    } catch (const UsageError&) {
      throw;
    } catch (const Error& error) {
      if (!first_error) first_error = error;
      continue;
    }
    if (best && FootMotion(named) >= FootMotion(*best)) continue;
    best = std::move(named);
    result.up_px = up;
  }
  if (!best) throw *first_error;
  result.recording = std::move(*best);
}

// Those that markers' positions come from.
std::vector<const Tracklet*> NamedTracklets(const std::vector<Tracklet>& tracklets,
                                            const motion::MarkerRecording& recording) {
  std::vector<const Tracklet*> named;
  for (const Tracklet& tracklet : tracklets) {
    const TrackletSample& first = tracklet.samples.front();
    const auto frame = static_cast<std::size_t>(
        std::lower_bound(recording.frame.begin(), recording.frame.end(), first.frame) - recording.frame.begin());
    if (std::any_of(recording.markers.begin(), recording.markers.end(), [&](const motion::MarkerTrack& marker) {
          return marker.samples[frame].IsKnown() && marker.samples[frame].position == first.position;
        }))
      named.push_back(&tracklet);
  }
  return named;
}

}  // namespace

void CheckPictureSize(const std::filesystem::path& video, const video::VideoInfo& info) {
  constexpr int kLeast_px = 16;
  if (std::min(info.width, info.height) < kLeast_px)
    throw Fail("{}: its pictures are of {}x{} px; markers on a leg take at least {} px a side: is it the right file?",
               video.string(), info.width, info.height, kLeast_px);
}

void TrackOptions::Check() const {
  physics.Check();
  if (names.empty()) throw UsageError("--markers: no names");
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (!IsName(name)) throw UsageError("--markers: '{}' is not a name (letters, digits, _ - .)", name);
    if (!seen.insert(name).second) throw UsageError("--markers: '{}' stands twice", name);
  }
  std::set<std::string> seeded;
  for (const MarkerSeed& seed : seeds) {
    if (!seen.contains(seed.name))
      throw UsageError("--seed {}: not one of the markers ({})", seed.name, fmt::join(names, ", "));
    if (!seeded.insert(seed.name).second) throw UsageError("--seed {}: given twice", seed.name);
  }
  const DetectorKind& kind = KindOf(*this);
  if (!colors.empty() && detector != "color") throw UsageError("--color is for --detector color");
  kind.check(*this);
  for (const std::string& color : colors) ParseMarkerColor(color);
}

namespace {

// What was followed over all frames, not yet named.
struct Followed {
  TrackResult result;
  std::vector<Tracklet> tracklets;
  std::vector<std::int64_t> repeated, discontinuities;  // frames: TrackletBuilder's
  std::optional<ImageFigures> image;                    // the detector's
};

Followed Follow(const std::filesystem::path& video, const TrackOptions& options) {
  options.Check();
  const std::unique_ptr<MarkerDetector> detector = KindOf(options).prepare(video, options)({options.crop});
  const video::VideoReaderOptions reader_options =
      detector->NeedsColour() ? WithChroma(options.reader) : options.reader;
  const std::unique_ptr<video::VideoReader> reader = video::VideoReader::Open(video, reader_options);
  CheckPictureSize(video, reader->Info());
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
  tracklet_options.look_back_s = 1;
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
  followed.repeated = builder.RepeatedFrames();
  followed.discontinuities = builder.Discontinuities();
  followed.image = detector->Figures();
  followed.result.tracklets = followed.tracklets.size();
  followed.result.radius_px = MedianRadius(followed.tracklets);
  return followed;
}

void NameAndTime(const std::filesystem::path& video, const TrackOptions& options, const Followed& followed,
                 TrackResult& result) {
  try {
    NameWithEachUp(followed.tracklets, options, followed.discontinuities, followed.repeated, result);
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    throw NamingError(fmt::format("{}: {}", video.string(), error.what()), ListCandidates(followed.tracklets));
  }
  try {
    result.times = CorrectFrameTimes(followed.repeated, result.recording);
  } catch (const Error& error) {
    throw Fail("{}: {}", video.string(), error.what());
  }
}

void MarkRepeated(const std::vector<std::int64_t>& repeated, Followed& followed) {
  followed.repeated = repeated;
  for (Tracklet& tracklet : followed.tracklets)
    for (TrackletSample& sample : tracklet.samples)
      sample.repeated = std::ranges::binary_search(repeated, sample.frame);
}

}  // namespace

TrackResult TrackMarkers(const std::filesystem::path& video, const TrackOptions& options) {
  Followed followed = Follow(video, options);
  TrackResult result = followed.result;
  NameAndTime(video, options, followed, result);
  // A path that stands still in a repeated picture goes on as no other, so names are given anew without these frames;
  // where that asks, those that were found stand.
  if (result.times.repeated != followed.repeated) {
    MarkRepeated(result.times.repeated, followed);
    TrackResult anew = followed.result;
    try {
      NameAndTime(video, options, followed, anew);
      result = std::move(anew);
    } catch (const NamingError&) {
    }
  }
  if (followed.image)
    result.figures = FiguresOf(NamedTracklets(followed.tracklets, result.recording), *followed.image, result.video);
  result.sigma = CalibrateSigmas(result.video, result.recording);
  return result;
}

CandidateList FindCandidates(const std::filesystem::path& video, const TrackOptions& options) {
  return ListCandidates(Follow(video, options).tracklets);
}

}  // namespace lake::tracking
