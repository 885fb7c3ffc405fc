#include "lake/commands/track_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/name_value.h"

namespace lake::commands {

tracking::DetectorKind ParseDetector(const std::string& text) {
  static const std::map<std::string, tracking::DetectorKind> kKinds = {
      {"reflective", tracking::DetectorKind::kReflective},
      {"color", tracking::DetectorKind::kColor},
      {"template", tracking::DetectorKind::kTemplate},
      {"aruco", tracking::DetectorKind::kAruco}};
  const auto found = kKinds.find(text);
  if (found == kKinds.end()) throw UsageError(fmt::format("detector '{}': reflective, color, template or aruco", text));
  return found->second;
}

tracking::Polarity ParsePolarity(const std::string& text) {
  if (text != "bright" && text != "dark") throw UsageError(fmt::format("polarity '{}': bright or dark", text));
  return text == "dark" ? tracking::Polarity::kDark : tracking::Polarity::kBright;
}

tracking::MarkerSeed ParseSeed(const std::string& text) {
  auto [name, place] = SplitNameValue("--seed", text);
  tracking::MarkerSeed seed{name};
  if (const auto at = place.find('@'); at != std::string::npos) {
    const double frame = ParseNumbers(place.substr(at + 1), 1, "--seed " + name + ": frame").front();
    constexpr double kMostFrames = 1e12;
    if (frame < 0 || frame > kMostFrames || frame != std::floor(frame))
      throw UsageError(fmt::format("--seed '{}': a frame is a whole number from 0", text));
    seed.frame = static_cast<std::int64_t>(frame);
    place.resize(at);
  }
  if (place.starts_with('#')) {
    const double number = ParseNumbers(place.substr(1), 1, "--seed " + name + ": number").front();
    constexpr double kMost = 1e6;
    if (!(number >= 1 && number <= kMost) || number != std::floor(number) || seed.frame != 0)
      throw UsageError(fmt::format("--seed '{}': #N is the number of a candidate, a whole number from 1", text));
    seed.candidate = static_cast<int>(number);
    return seed;
  }
  const std::vector<double> xy = ParseNumbers(place, 2, "--seed " + name);
  seed.position = {xy[0], xy[1]};
  return seed;
}

cv::Rect CropOf(std::span<const double> numbers) {
  constexpr double kMostPx = 1e5;
  const auto is_whole = [](double value) { return value == std::floor(value) && std::abs(value) <= kMostPx; };
  if (numbers.size() != 4 || !std::all_of(numbers.begin(), numbers.end(), is_whole))
    throw UsageError(fmt::format("--crop {}: four whole numbers of px are needed", fmt::join(numbers, ",")));
  std::array<int, 4> px;
  std::transform(numbers.begin(), numbers.end(), px.begin(), [](double value) { return static_cast<int>(value); });
  if (px[2] <= 0 || px[3] <= 0)
    throw UsageError(fmt::format("--crop {}: width and height must be positive", fmt::join(numbers, ",")));
  return {px[0], px[1], px[2], px[3]};
}

}  // namespace lake::commands
