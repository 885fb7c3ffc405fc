#include "lake/tracking/recording_quality.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/motion/marker_recording.h"
#include "lake/tracking/track_markers.h"
#include "lake/video/video_files.h"

namespace lake::tracking {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// What one place in the file showed.
struct Place {
  std::vector<double> time_s, brightness;  // per frame
  std::vector<std::int64_t> frame;         // likewise, as the tracklets' samples count them
  std::vector<std::int64_t> repeated;      // frames in which nothing moved that should have (TrackletBuilder)
  std::vector<Tracklet> tracklets;
  std::vector<std::size_t> by_contrast;  // tracklets of most of its frames, strongest first
  cv::Mat middle;                        // the frame in its middle
  double middle_s = 0;
  std::int64_t middle_frame = 0;
};

// Quarter-size pictures: what coding changes in a picture that stands still averages out.
cv::Mat Small(const cv::Mat& luma) {
  cv::Mat small;
  cv::resize(luma, small, {}, 0.25, 0.25, cv::INTER_AREA);
  return small;
}

double MedianContrast(const Tracklet& tracklet) {
  std::vector<double> contrast;
  for (const TrackletSample& sample : tracklet.samples) contrast.push_back(sample.amplitude);
  return Median(std::move(contrast));
}

void SortSpots(Place& place) {
  std::vector<double> contrast;
  for (std::size_t i = 0; i < place.tracklets.size(); ++i) {
    contrast.push_back(MedianContrast(place.tracklets[i]));
    if (2 * place.tracklets[i].samples.size() >= place.time_s.size()) place.by_contrast.push_back(i);
  }
  std::sort(place.by_contrast.begin(), place.by_contrast.end(),
            [&](std::size_t a, std::size_t b) { return contrast[a] > contrast[b]; });
}

// Until so much is decoded in all, but at least eight frames. Those from the key frame before `from_s` on are looked at
// until then, as they are decoded anyway.
Place LookAt(const std::filesystem::path& path, const RecordingCheckOptions& options, double from_s, double after_s,
             MarkerDetector& detector, double until_mpx, double& decoded_mpx, video::VideoInfo& info) {
  video::VideoReaderOptions reader_options = options.reader;
  if (from_s > 0) reader_options.seek_s = from_s;
  const auto reader = video::VideoReader::Open(path, reader_options);
  TrackletBuilder builder(detector, TrackletOptions{});
  Place place;
  constexpr std::size_t kLeastFrames = 8;
  for (video::VideoFrame frame; place.time_s.size() < static_cast<std::size_t>(options.frames_per_run);) {
    ThrowIfInterrupted();
    const bool is_spent = decoded_mpx > until_mpx;
    if (is_spent && place.time_s.size() >= kLeastFrames) break;
    if (!reader->Read(frame)) break;
    decoded_mpx += 1e-6 * static_cast<double>(frame.luma.total());
    if (frame.time_s <= after_s) continue;            // the key frame before lies in the last place
    if (frame.time_s < from_s && is_spent) continue;  // else what was asked for is not seen
    builder.Add(frame);
    const cv::Mat small = Small(frame.luma);
    place.time_s.push_back(frame.time_s);
    place.frame.push_back(frame.index);
    place.brightness.push_back(cv::mean(small)[0]);
    if (place.time_s.size() == static_cast<std::size_t>(options.frames_per_run) / 2 || place.middle.empty()) {
      place.middle = frame.luma.clone();
      place.middle_s = frame.time_s;
      place.middle_frame = frame.index;
    }
  }
  info = reader->Info();
  place.tracklets = builder.Finish();
  place.repeated = builder.RepeatedFrames();
  SortSpots(place);
  return place;
}

// Of the brightness about a straight line.
double Flicker(const Place& place) {
  const std::size_t n = place.brightness.size();
  if (n < 4) return 0;
  double sum = 0, level = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double bend = place.brightness[i] - (place.brightness[i - 1] + place.brightness[i + 1]) / 2;
    sum += bend * bend;
    level += place.brightness[i];
  }
  const auto count = static_cast<double>(n - 2);
  // White noise bends by √1.5 of itself.
  return std::sqrt(sum / count / 1.5) / std::max(level / count, 1.0);
}

// How far what stands nearly upright in the room leans: the mode of the edges' directions about the vertical, each
// weighed by its strength. nullopt where no direction stands out.
std::optional<double> TiltDeg(const cv::Mat& grey) {
  constexpr double kReach_deg = 12, kBin_deg = 0.5, kLeastEdge = 40;
  cv::Mat smooth, dx, dy;
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.2);
  cv::Sobel(smooth, dx, CV_32F, 1, 0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1);
  std::vector<double> weight(static_cast<std::size_t>(2 * kReach_deg / kBin_deg) + 1, 0.0);
  for (int y = 0; y < grey.rows; y += 2)
    for (int x = 0; x < grey.cols; x += 2) {
      const double gx = dx.at<float>(y, x), gy = dy.at<float>(y, x), strength = std::hypot(gx, gy);
      if (strength < kLeastEdge) continue;
      // The edge runs across its gradient; it leans clockwise where the gradient turns with it.
      const double lean = DegreesFromRadians(std::atan(gy / (std::abs(gx) < 1e-6 ? 1e-6 : gx)));
      if (std::abs(lean) < kReach_deg)
        weight[static_cast<std::size_t>(std::lround((lean + kReach_deg) / kBin_deg))] += strength;
    }
  const auto peak = static_cast<std::size_t>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  const double usual = Median(weight), enough = kLeastEdge * 0.2 * grey.rows;
  if (weight[peak] < 3 * usual || weight[peak] < enough) return std::nullopt;
  double sum = 0, at = 0;
  for (std::size_t k = peak > 1 ? peak - 2 : 0; k <= std::min(peak + 2, weight.size() - 1); ++k) {
    sum += weight[k];
    at += weight[k] * (static_cast<double>(k) * kBin_deg - kReach_deg);
  }
  return at / sum;
}

// Ankle, knee and hip with the same error: σ²/a² + σ²/b² + σ² (1/a² + 1/b² + 2 cos θ/(a b)), for a = b at its largest.
double KneeSdDeg(double position_sd_px, double segment_px) {
  return segment_px > 0 ? DegreesFromRadians(position_sd_px / segment_px * std::sqrt(6.0)) : 0;
}

void CountSpots(const std::vector<Place>& places, std::size_t markers, RecordingCheck& check) {
  std::vector<double> spots, clutter;
  int all = 0;
  for (const Place& place : places) {
    for (const std::int64_t frame : place.frame) {
      if (std::find(place.repeated.begin(), place.repeated.end(), frame) != place.repeated.end()) continue;
      const auto seen = std::count_if(place.tracklets.begin(), place.tracklets.end(),
                                      [&](const Tracklet& tracklet) { return tracklet.SampleIn(frame) != nullptr; });
      spots.push_back(static_cast<double>(seen));
      all += seen >= static_cast<std::ptrdiff_t>(markers);
    }
    const std::size_t more = place.by_contrast.size() > markers ? place.by_contrast.size() - markers : 0;
    clutter.push_back(static_cast<double>(more));
    if (more > 0)
      check.strongest_clutter =
          std::max(check.strongest_clutter, MedianContrast(place.tracklets[place.by_contrast[markers]]) /
                                                MedianContrast(place.tracklets[place.by_contrast[markers - 1]]));
  }
  check.spots = spots.empty() ? 0 : Median(spots);
  check.clutter = clutter.empty() ? 0 : Median(clutter);
  check.all_seen_share = spots.empty() ? 0 : static_cast<double>(all) / static_cast<double>(spots.size());
}

// The markers, as TrackMarkers names them; the reason where it cannot.
struct Named {
  std::optional<TrackResult> tracked;
  std::string why_not;
};

Named NameMarkers(const std::filesystem::path& video, const RecordingCheckOptions& options,
                  const video::VideoInfo& info) {
  TrackOptions track;
  track.names = options.names;
  track.seeds = options.seeds;
  track.polarity = options.polarity;
  track.crop = options.crop;
  track.reader = options.reader;
  const double frame_mpx = 1e-6 * info.width * info.height;
  track.reader.last = std::max<std::int64_t>(options.frames_named, std::llround(options.budget_mpx / frame_mpx)) - 1;
  track.metric_from_px = [aspect = info.pixel_aspect](const Eigen::Vector2d& px) {
    return Eigen::Vector2d(aspect * px.x(), px.y());
  };
  track.quiet = true;
  try {
    return {TrackMarkers(video, track), ""};
  } catch (const Error& error) {
    return {std::nullopt, error.what()};
  }
}

const motion::MarkerTrack& TrackOf(const TrackResult& tracked, std::string_view name) {
  return *tracked.recording.Find(name);
}

double MedianDistance(const motion::MarkerTrack& one, const motion::MarkerTrack& other) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < one.samples.size(); ++i)
    if (one.samples[i].IsKnown() && other.samples[i].IsKnown())
      distances.push_back((one.samples[i].position - other.samples[i].position).norm());
  return distances.empty() ? 0 : Median(std::move(distances));
}

// The diagonal of the box that holds the path, but for what is farthest out.
double ReachOf(std::span<const Eigen::Vector2d> path) {
  constexpr double kEnd = 0.02;
  if (path.empty()) return 0;
  std::vector<double> x, y;
  for (const Eigen::Vector2d& position : path) {
    x.push_back(position.x());
    y.push_back(position.y());
  }
  return std::hypot(Quantile(x, 1 - kEnd) - Quantile(x, kEnd), Quantile(y, 1 - kEnd) - Quantile(y, kEnd));
}

// How often the ankle turns before and behind the hip by this much, in what is seen without a gap; the most.
int TurnsOfAnkle(const TrackResult& tracked, double least_px) {
  const motion::MarkerTrack &ankle = TrackOf(tracked, "ankle"), &hip = TrackOf(tracked, "hip");
  constexpr double kGap_s = 0.5;
  int most = 0, turns = 0, direction = 0;
  double low = 0, high = 0, last_s = -1;
  for (std::size_t i = 0; i < ankle.samples.size(); ++i) {
    if (!ankle.samples[i].IsKnown() || !hip.samples[i].IsKnown()) continue;
    const double x = ankle.samples[i].position.x() - hip.samples[i].position.x(), at_s = tracked.recording.time_s[i];
    if (last_s < 0 || at_s - last_s > kGap_s) {
      turns = direction = 0;
      low = high = x;
    }
    last_s = at_s;
    low = std::min(low, x);
    high = std::max(high, x);
    const int now = x - low > least_px ? 1 : high - x > least_px ? -1 : 0;
    if (now == 0 || now == direction) {
      if (direction != 0) (direction > 0 ? low : high) = x;
      continue;
    }
    turns += direction != 0 ? 1 : 0;
    most = std::max(most, turns);
    direction = now;
    low = high = x;
  }
  return most;
}

void TakeNamed(const TrackResult& tracked, RecordingCheck& check) {
  check.video.bits_per_pixel = tracked.video.bits_per_pixel;
  check.markers = *tracked.figures;
  check.compression_px = tracked.sigma.compression_px;
  check.position_sd_px = std::hypot(check.markers.sigma_px, check.compression_px);
  const motion::MarkerTrack &ankle = TrackOf(tracked, "ankle"), &hip = TrackOf(tracked, "hip"),
                            *knee = tracked.recording.Find("knee");
  check.segment_px =
      (knee ? MedianDistance(ankle, *knee) + MedianDistance(*knee, hip) : MedianDistance(ankle, hip)) / 2;
  check.knee_sd_deg = KneeSdDeg(check.position_sd_px, check.segment_px);
  const std::size_t frames = tracked.recording.time_s.size();
  // Where no marker is seen the person is out of the picture; a repeated picture shows nothing of its own, either.
  std::size_t all = 0, any = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto is_seen = [&](const motion::MarkerTrack& track) { return track.samples[i].IsKnown(); };
    all += std::ranges::all_of(tracked.recording.markers, is_seen);
    any += std::ranges::any_of(tracked.recording.markers, is_seen);
  }
  const auto shown = static_cast<double>(std::max<std::size_t>(any, 1));
  check.all_seen_share = static_cast<double>(all) / shown;
  const auto knee_seen = knee ? std::ranges::count_if(knee->samples, &motion::MarkerSample::IsKnown) : 0;
  check.knee_hidden_share = std::max(0.0, 1 - static_cast<double>(knee_seen) / shown);
  for (const motion::MarkerTrack& track : tracked.recording.markers) {
    std::vector<Eigen::Vector2d> path;
    for (const motion::MarkerSample& sample : track.samples)
      if (sample.IsKnown()) path.push_back(sample.position);
    const double reach_px = ReachOf(path);
    check.travel_px = std::max(check.travel_px, reach_px);
    // In a rise or a squat the ankle stays.
    if (track.name == "ankle" && reach_px > 0.8 * check.segment_px)
      check.strides = std::max(0, TurnsOfAnkle(tracked, 0.5 * check.segment_px) - 1) / 2;
  }
}

// How far the strongest spots of each place are followed within it, and how far they are from the nearest spot of the
// next place; the largest of both, px.
double TravelOfSpots(const std::vector<Place>& places, std::size_t spots) {
  double travel_px = 0;
  std::vector<Eigen::Vector2d> before;
  for (const Place& place : places) {
    std::vector<Eigen::Vector2d> here;
    for (const std::size_t i : std::span(place.by_contrast).first(std::min(spots, place.by_contrast.size()))) {
      std::vector<Eigen::Vector2d> path;
      for (const TrackletSample& sample : place.tracklets[i].samples) path.push_back(sample.position);
      travel_px = std::max(travel_px, ReachOf(path));
      here.push_back(path[path.size() / 2]);
    }
    if (here.empty()) continue;
    for (const Eigen::Vector2d& from : before) {
      const auto distance = [&](const Eigen::Vector2d& to) { return (to - from).norm(); };
      travel_px = std::max(travel_px, distance(*std::ranges::min_element(here, {}, distance)));
    }
    before = std::move(here);
  }
  return travel_px;
}

// The spots of a place's middle frame; those at a named marker's place in that frame are it.
void ShowFrame(const Place& place, const std::optional<TrackResult>& tracked, RecordingCheck& check) {
  check.frame = place.middle;
  check.shown_frame_ms = std::llround(1000 * place.middle_s);
  for (const Tracklet& tracklet : place.tracklets)
    if (const TrackletSample* sample = tracklet.SampleIn(place.middle_frame))
      check.spots_shown.push_back({sample->position, sample->radius_px, sample->amplitude, ""});
  if (!tracked) return;
  const std::vector<double>& time_s = tracked->recording.time_s;
  const auto row = static_cast<std::size_t>(
      std::ranges::min_element(time_s, {}, [&](double t) { return std::abs(t - place.middle_s); }) - time_s.begin());
  if (std::abs(time_s[row] - place.middle_s) > MedianInterval(time_s) / 2) return;  // after what was named
  for (const motion::MarkerTrack& track : tracked->recording.markers)
    for (CheckedSpot& spot : check.spots_shown)
      if (track.samples[row].IsKnown() && (spot.position - track.samples[row].position).norm() < spot.radius_px)
        spot.name = track.name;
}

// The one in the middle of the recording; of those in which the markers were named, if they were.
const Place& PlaceToShow(const std::vector<Place>& places, const std::optional<TrackResult>& tracked) {
  const double last_s = tracked ? tracked->recording.time_s.back() : places.back().middle_s;
  std::size_t seen = 0;
  while (seen < places.size() && places[seen].middle_s <= last_s) ++seen;
  return places[seen / 2];
}

// When to look: at the beginnings of equal parts of the file.
std::vector<double> Starts(const std::vector<double>& stamps_s, const RecordingCheckOptions& options) {
  const auto frames = static_cast<double>(stamps_s.size());
  if (stamps_s.size() <= static_cast<std::size_t>(options.frames_per_run)) return {0};
  std::vector<double> starts;
  for (int i = 0; i < options.runs; ++i) {
    const double last = frames - options.frames_per_run;
    starts.push_back(stamps_s[static_cast<std::size_t>(last * i / std::max(options.runs - 1, 1))]);
  }
  return starts;
}

// Places are looked for by the times that the file has, and by the capture rate only where it has none.
std::pair<RecordingCheckOptions, std::vector<double>> InOwnTimes(const std::filesystem::path& video,
                                                                 const RecordingCheckOptions& options) {
  RecordingCheckOptions own = options;
  own.reader.capture_rate_hz = 0;
  if (auto stamps_s = video::StampsInContainer(video, own.reader)) return {own, *std::move(stamps_s)};
  return {options, video::StampsInContainer(video, options.reader).value_or(std::vector<double>{})};
}

double MedianLevel(const Tracklet& marker) {
  std::vector<double> levels;
  levels.reserve(marker.samples.size());
  for (const TrackletSample& sample : marker.samples) levels.push_back(sample.background + sample.amplitude);
  return Median(std::move(levels));
}

// What was learnt; where coding has blurred the level on which clipped pixels pile up, the stream's white, or 255 where
// most markers are brighter than that by more than coding makes of it.
double SaturationLevel(std::span<const Tracklet* const> markers, const ImageFigures& image,
                       const video::VideoInfo& video) {
  constexpr double kHighest = 255, kBeyondWhite = 1.03;
  if (image.saturation_level != kHighest) return image.saturation_level;
  const auto beyond = std::ranges::count_if(
      markers, [&](const Tracklet* marker) { return MedianLevel(*marker) > kBeyondWhite * video.white_level; });
  return 2 * static_cast<std::size_t>(beyond) > markers.size() ? kHighest : video.white_level;
}

}  // namespace

MarkerFigures FiguresOf(std::span<const Tracklet* const> markers, const ImageFigures& image,
                        const video::VideoInfo& video) {
  // Of the level at which the video saturates: coding takes less off clipped markers. Of a marker, as that of a single
  // frame's fit is wrong by as much.
  constexpr double kSaturated = 0.97;
  const double saturation_level = SaturationLevel(markers, image, video);
  MarkerFigures figures;
  figures.shutter_fraction = image.shutter_fraction;
  std::vector<double> radius, contrast, over_noise, steps;
  double variance = 0, saturated = 0;
  for (const Tracklet* marker : markers) {
    if (MedianLevel(*marker) >= kSaturated * saturation_level) saturated += static_cast<double>(marker->samples.size());
    for (std::size_t i = 0; i < marker->samples.size(); ++i) {
      const TrackletSample& sample = marker->samples[i];
      const double level = std::min(sample.amplitude, image.saturation_level);
      radius.push_back(sample.radius_px);
      contrast.push_back(level);
      over_noise.push_back(level / std::sqrt(image.noise.Variance(level)));
      variance += sample.sigma_px * sample.sigma_px;
      if (i > 0 && sample.frame == marker->samples[i - 1].frame + 1)
        steps.push_back((sample.position - marker->samples[i - 1].position).norm());
    }
  }
  figures.samples = radius.size();
  if (radius.empty()) return figures;
  const auto n = static_cast<double>(radius.size());
  figures.radius_px = Median(radius);
  figures.contrast = Median(contrast);
  figures.noise = std::sqrt(image.noise.Variance(figures.contrast));
  figures.contrast_over_noise = Quantile(over_noise, 0.1);
  figures.saturated_share = saturated / n;
  figures.sigma_px = std::sqrt(variance / n);
  if (!steps.empty()) figures.fastest_px = Quantile(steps, 0.98);
  constexpr double kUsualShutter = 0.5;
  figures.blur_px = figures.fastest_px * image.shutter_fraction.value_or(kUsualShutter);
  return figures;
}

std::int64_t DroppedFrames(const std::vector<double>& stamps_s) {
  if (stamps_s.size() < 4) return 0;
  const double usual = MedianInterval(stamps_s);
  std::int64_t dropped = 0;
  for (std::size_t i = 1; i < stamps_s.size(); ++i)
    if (const double step = stamps_s[i] - stamps_s[i - 1]; step > 1.5 * usual)
      dropped += std::llround(step / usual) - 1;
  return dropped;
}

RecordingCheck CheckRecording(const std::filesystem::path& video, const RecordingCheckOptions& options) {
  const Clock::time_point begin = Clock::now();
  RecordingCheck check;
  CheckPictureSize(video, video::VideoReader::Open(video, options.reader)->Info());
  const auto [looked, stamps_s] = InOwnTimes(video, options);
  check.frames_in_file = static_cast<std::int64_t>(stamps_s.size());
  check.dropped_frames = DroppedFrames(stamps_s);
  const auto detector = MakeReflectiveDetector(options.polarity, {options.crop});
  std::vector<Place> places;
  double after_s = -1;
  const std::vector<double> starts = Starts(stamps_s, options);
  double decoded_mpx = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    // However large the pictures, the beginning, the middle and the end are seen.
    const bool is_needed = i == 0 || i == starts.size() / 2 || i + 1 == starts.size();
    if (!places.empty() && (starts[i] <= after_s || (!is_needed && decoded_mpx > options.budget_mpx))) continue;
    // Each place has its share of the budget, and what those before left of theirs.
    const double share_mpx = options.budget_mpx * static_cast<double>(i + 1) / static_cast<double>(starts.size());
    Place place = LookAt(video, looked, starts[i], after_s, *detector, share_mpx, decoded_mpx, check.video);
    if (place.time_s.empty()) continue;
    after_s = place.time_s.back();
    check.frames_seen += static_cast<int>(place.time_s.size());
    check.repeated_frames += static_cast<int>(place.repeated.size());
    check.flicker = std::max(check.flicker, Flicker(place));
    places.push_back(std::move(place));
  }
  if (places.empty()) throw Fail("{}: holds no frame that can be looked at", video.string());
  check.places_seen = static_cast<int>(places.size());
  if (options.reader.capture_rate_hz > 0) check.video.frame_rate_hz = options.reader.capture_rate_hz;

  CountSpots(places, options.names.size(), check);
  const Named named = NameMarkers(video, options, check.video);
  check.why_not_named = named.why_not;
  if (named.tracked)
    TakeNamed(*named.tracked, check);
  else
    check.travel_px = TravelOfSpots(places, options.names.size());
  std::vector<double> tilts;
  for (const Place& place : places)
    if (const auto tilt = TiltDeg(place.middle)) tilts.push_back(*tilt);
  if (2 * tilts.size() > places.size()) check.tilt_deg = Median(tilts);
  ShowFrame(PlaceToShow(places, named.tracked), named.tracked, check);
  check.seconds = SecondsSince(begin);
  return check;
}

}  // namespace lake::tracking
