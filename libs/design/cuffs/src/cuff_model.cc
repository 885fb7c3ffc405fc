#include "lake/cuffs/cuff_model.h"

#include <fmt/ranges.h>

#include <locale>
#include <sstream>
#include <tuple>

#include "lake/core/error.h"
#include "segment_axes.h"

namespace lake::cuffs {
namespace {

void SetCuffs(const OptionTexts& texts, const std::string& said, std::vector<Cuff>& cuffs) {
  cuffs.clear();
  for (const std::string& text : texts) {
    Cuff cuff;
    char colon = 0, rest = 0;
    std::istringstream words(text);
    words.imbue(std::locale::classic());
    if (!(words >> cuff.from_knee_mm >> colon >> cuff.length_mm) || colon != ':' || words >> rest ||
        cuff.from_knee_mm <= 0 || cuff.length_mm < 0)
      throw UsageError("{} '{}': give DISTANCE:LENGTH in mm, as 200:80", said, text);
    cuffs.push_back(cuff);
  }
}

std::string CuffsText(const std::vector<Cuff>& cuffs) {
  std::vector<std::string> texts;
  for (const Cuff& cuff : cuffs) texts.push_back(fmt::format("{}:{}", cuff.from_knee_mm, cuff.length_mm));
  return fmt::format("{}", fmt::join(texts, " "));
}

}  // namespace

std::vector<PlacedCuff> CuffsOf(const CuffOptions& options) {
  std::vector<PlacedCuff> cuffs;
  cuffs.reserve(options.thigh.size() + options.shank.size());
  for (std::size_t k = 0; k < options.thigh.size(); ++k) cuffs.push_back({options.thigh[k], true, k});
  for (std::size_t k = 0; k < options.shank.size(); ++k) cuffs.push_back({options.shank[k], false, k});
  return cuffs;
}

void CheckCuffs(const CuffOptions& o) {
  if (o.thigh.empty() || o.shank.empty()) throw UsageError("a segment without a cuff: each needs one at least");
  for (const PlacedCuff& cuff : CuffsOf(o))
    if (!(cuff.from_knee_mm > 0) || !(cuff.length_mm >= 0))
      throw UsageError("a cuff {} mm from the knee, {} mm long: give a distance above 0", cuff.from_knee_mm,
                       cuff.length_mm);
}

void CheckStiffnesses(const CuffOptions& o) {
  if (!(o.softest_n_mm > 0))
    throw UsageError("cuffs of {} to {} N/mm: give stiffnesses above 0", o.softest_n_mm, o.stiffest_n_mm);
  if (!(o.softest_n_mm <= o.stiffest_n_mm))
    throw UsageError("--cuff-softest {} is above --cuff-stiffest {}: give the softest and the stiffest", o.softest_n_mm,
                     o.stiffest_n_mm);
}

void DescribePlaces(CuffOptions& o, OptionList& options) {
  for (const auto& [name, segment, cuffs] :
       {std::tuple("thigh-cuff", "thigh", &o.thigh), std::tuple("shank-cuff", "shank", &o.shank)}) {
    Option& option =
        options
            .AddCustom(
                name, fmt::format("A cuff on the {}: its middle's distance from the knee, and its length, mm", segment),
                [cuffs = cuffs](const OptionTexts& texts, const std::string& said) { SetCuffs(texts, said, *cuffs); },
                [cuffs = cuffs] { return CuffsText(*cuffs); })
            .Value("DISTANCE:LENGTH")
            .Repeats();
    if (cuffs->empty()) option.Otherwise("none");
  }
}

void Describe(CuffOptions& o, OptionList& options) {
  DescribePlaces(o, options);
  options.Add("cuff-softest", o.softest_n_mm, "The least stiffness of cuff and flesh that is expected")
      .Unit("N/mm")
      .Positive();
  options.Add("cuff-stiffest", o.stiffest_n_mm, "The largest stiffness of cuff and flesh that is expected")
      .Unit("N/mm")
      .Positive();
  options.Check([&o](const OptionList&) { CheckStiffnesses(o); });
}

Eigen::Vector2d MisfitOf(const Eigen::Vector2d& place_shank_mm, const Eigen::Vector2d& place_thigh_mm, double thigh_deg,
                         double shank_deg) {
  return AxesOf(thigh_deg) * place_thigh_mm - AxesOf(shank_deg) * place_shank_mm;
}

}  // namespace lake::cuffs
