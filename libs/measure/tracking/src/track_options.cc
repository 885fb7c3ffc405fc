#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/name_value.h"
#include "lake/core/options.h"
#include "lake/tracking/track_markers.h"

namespace lake::tracking {
namespace {

// NAME=X,Y[@FRAME], a place in px.
MarkerSeed ParseSeed(const std::string& text, const std::string& said) {
  auto [name, place] = SplitNameValue(said, text);
  MarkerSeed seed{name};
  if (const auto at = place.find('@'); at != std::string::npos) {
    const double frame = ParseNumbers(place.substr(at + 1), 1, said + " " + name + ": frame").front();
    constexpr double kMostFrames = 1e12;
    if (frame < 0 || frame > kMostFrames || frame != std::floor(frame))
      throw UsageError(fmt::format("{} '{}': a frame is a whole number from 0", said, text));
    seed.frame = static_cast<std::int64_t>(frame);
    place.resize(at);
  }
  const std::vector<double> xy = ParseNumbers(place, 2, said + " " + name);
  seed.position = {xy[0], xy[1]};
  return seed;
}

cv::Rect CropOf(const std::array<double, 4>& numbers, const std::string& said) {
  constexpr double kMostPx = 1e5;
  const auto is_whole = [](double value) { return value == std::floor(value) && std::abs(value) <= kMostPx; };
  if (!std::all_of(numbers.begin(), numbers.end(), is_whole))
    throw UsageError(fmt::format("{} {}: four whole numbers of px are needed", said, fmt::join(numbers, ",")));
  std::array<int, 4> px;
  std::transform(numbers.begin(), numbers.end(), px.begin(), [](double value) { return static_cast<int>(value); });
  if (px[2] <= 0 || px[3] <= 0)
    throw UsageError(fmt::format("{} {}: width and height must be positive", said, fmt::join(numbers, ",")));
  return {px[0], px[1], px[2], px[3]};
}

}  // namespace

void Describe(TrackOptions& o, OptionList& options) {
  options.Add("markers", o.names, "Names of the markers to find; ankle, knee, hip, waist are understood as the leg")
      .Value("NAME,...");
  const auto set_seeds = [&o](const OptionTexts& texts, const std::string& said) {
    o.seeds.clear();
    for (const std::string& text : texts) o.seeds.push_back(ParseSeed(text, said));
  };
  options.AddCustom("seed", "Position of a marker in a frame (may be repeated)", set_seeds)
      .Unit("px")
      .Key("seeds")
      .Value("NAME=X,Y[@FRAME]")
      .Repeats();
  options.AddChoice("detector", o.detector,
                    OptionList::Choices<DetectorKind>{{"reflective", DetectorKind::kReflective},
                                                      {"color", DetectorKind::kColor},
                                                      {"template", DetectorKind::kTemplate},
                                                      {"aruco", DetectorKind::kAruco}},
                    "Kind of marker");
  options.Add("color", o.colors, "Marker colour, one for all or one per marker, for --detector color")
      .Key("colors")
      .Value("\"#RRGGBB\"")
      .Repeats();
  options.Add("dictionary", o.dictionary,
              "ArUco dictionary, for --detector aruco; ids 0, 1, … are the markers in the order of --markers");
  options.AddChoice("polarity", o.polarity,
                    OptionList::Choices<Polarity>{{"bright", Polarity::kBright}, {"dark", Polarity::kDark}},
                    "Whether markers are brighter or darker than their surroundings");
  const auto set_crop = [&o](const OptionTexts& texts, const std::string& said) {
    std::array<double, 4> numbers;
    OptionField<std::array<double, 4>>::Set(texts, said, numbers);
    o.crop = CropOf(numbers, said);
  };
  options.AddCustom("crop", "Search only this rectangle of the picture", set_crop)
      .Unit("px")
      .Key("crop")
      .Value("X,Y,W,H")
      .SplitAtCommas();
  Describe(o.reader, options);
  options.Check([&o](const OptionList&) { o.Check(); });
}

}  // namespace lake::tracking
