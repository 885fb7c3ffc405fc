#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/name_value.h"
#include "lake/core/options.h"
#include "lake/tracking/track_markers.h"

namespace lake::tracking {
namespace {

// NAME=X,Y[@FRAME], a place in px, or NAME=#N, the number of a candidate.
MarkerSeed ParseSeed(const std::string& text, const std::string& said) {
  auto [name, place] = SplitNameValue(said, text);
  MarkerSeed seed{name};
  if (const auto at = place.find('@'); at != std::string::npos) {
    const double frame = ParseNumbers(place.substr(at + 1), 1, said + " " + name + ": frame").front();
    constexpr double kMostFrames = 1e12;
    if (frame < 0 || frame > kMostFrames || frame != std::floor(frame))
      throw UsageError("{} '{}': a frame is a whole number from 0", said, text);
    seed.frame = static_cast<std::int64_t>(frame);
    place.resize(at);
  }
  if (place.starts_with('#')) {
    const double number = ParseNumbers(place.substr(1), 1, said + " " + name + ": number").front();
    constexpr double kMost = 1e6;
    if (!(number >= 1 && number <= kMost) || number != std::floor(number) || seed.frame != 0)
      throw UsageError("{} '{}': #N is the number of a candidate, a whole number from 1", said, text);
    seed.candidate = static_cast<int>(number);
    return seed;
  }
  const std::vector<double> xy = ParseNumbers(place, 2, said + " " + name);
  seed.position = {xy[0], xy[1]};
  return seed;
}

// Lists with commas, of which a place has one itself.
std::vector<std::string> SplitColors(const OptionTexts& texts) {
  std::vector<std::string> colors;
  for (const std::string& text : texts) {
    bool is_place = false;
    for (const std::string& part : SplitText(text, ',')) {
      if (is_place)
        colors.back() += "," + part;
      else
        colors.push_back(part);
      is_place = !is_place && part.starts_with('@');
    }
  }
  return colors;
}

cv::Rect CropOf(const std::array<double, 4>& numbers, const std::string& said) {
  constexpr double kMostPx = 1e5;
  const auto is_whole = [](double value) { return value == std::floor(value) && std::abs(value) <= kMostPx; };
  if (!std::all_of(numbers.begin(), numbers.end(), is_whole))
    throw UsageError("{} {}: four whole numbers of px are needed", said, fmt::join(numbers, ","));
  std::array<int, 4> px;
  std::transform(numbers.begin(), numbers.end(), px.begin(), [](double value) { return static_cast<int>(value); });
  if (px[2] <= 0 || px[3] <= 0)
    throw UsageError("{} {}: width and height must be positive", said, fmt::join(numbers, ","));
  return {px[0], px[1], px[2], px[3]};
}

}  // namespace

void DescribeNames(std::vector<std::string>& names, std::vector<MarkerSeed>& seeds, OptionList& options) {
  options.Add("markers", names, "Names of the markers to find; ankle, knee, hip, waist are understood as the leg")
      .Value("NAME,...");
  const auto set_seeds = [&seeds](const OptionTexts& texts, const std::string& said) {
    seeds.clear();
    for (const std::string& text : texts) seeds.push_back(ParseSeed(text, said));
  };
  options
      .AddCustom("seed", "Position of a marker in a frame, or its number in candidates.png (may be repeated)",
                 set_seeds)
      .Unit("px")
      .Key("seeds")
      .Value("NAME=X,Y[@FRAME]|NAME=#N")
      .Repeats();
}

void Describe(TrackOptions& o, OptionList& options) {
  DescribeNames(o.names, o.seeds, options);
  OptionList::Choices<std::string> detectors;
  for (const std::string& name : DetectorNames()) detectors.emplace_back(name, name);
  options.AddChoice("detector", o.detector, detectors, "Kind of marker");
  const auto set_colors = [&o](const OptionTexts& texts, const std::string&) { o.colors = SplitColors(texts); };
  options
      .AddCustom(
          "color",
          "Marker colour, one for all or one per marker, for --detector color: its levels, or a place in a frame "
          "where a marker shows it",
          set_colors)
      .Key("colors")
      .Value("\"#RRGGBB\"|@X,Y[@FRAME]")
      .Repeats();
  options.Add("dictionary", o.dictionary,
              "ArUco dictionary, for --detector aruco; ids 0, 1, … are the markers in the order of --markers");
  DescribePolarity(o.polarity, options);
  DescribeCrop(o.crop, options);
  Describe(o.reader, options);
  options.Check([&o](const OptionList&) { o.Check(); });
}

Option& DescribePolarity(Polarity& polarity, OptionList& options) {
  return options.AddChoice("polarity", polarity,
                           OptionList::Choices<Polarity>{{"bright", Polarity::kBright}, {"dark", Polarity::kDark}},
                           "Whether markers are brighter or darker than their surroundings");
}

Option& DescribeCrop(cv::Rect& crop, OptionList& options) {
  const auto set = [&crop](const OptionTexts& texts, const std::string& said) {
    std::array<double, 4> numbers;
    OptionField<std::array<double, 4>>::Set(texts, said, numbers);
    crop = CropOf(numbers, said);
  };
  return options.AddCustom("crop", "Search only this rectangle of the picture", set)
      .Unit("px")
      .Key("crop")
      .Value("X,Y,W,H")
      .SplitAtCommas();
}

}  // namespace lake::tracking
