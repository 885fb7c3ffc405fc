#include "lake/commands/leg_loads.h"

#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::commands {
namespace {

struct LegForce {
  const char* name;
  const char* label;
  double cuffs::LegStatics::*force_n;
};
constexpr LegForce kThighCuff{"thigh_cuff", "thigh cuff", &cuffs::LegStatics::largest_thigh_n};
constexpr LegForce kShankCuff{"shank_cuff", "shank cuff", &cuffs::LegStatics::largest_shank_n};
constexpr LegForce kKneeShear{"knee_shear", "shear at the knee", &cuffs::LegStatics::knee_shear_n};
constexpr LegForce kKneeCompression{"knee_compression", "compression", &cuffs::LegStatics::knee_compression_n};
constexpr LegForce kLegForces[] = {kThighCuff, kShankCuff, kKneeShear, kKneeCompression};

// The row with the largest magnitude; nullptr if none is known.
const LegLoadRow* LargestOf(const LegForce& force, const std::vector<LegLoadRow>& rows) {
  const LegLoadRow* largest = nullptr;
  for (const LegLoadRow& row : rows) {
    const double force_n = row.leg.*force.force_n;
    if (std::isfinite(force_n) && (!largest || std::abs(force_n) > std::abs(largest->leg.*force.force_n)))
      largest = &row;
  }
  return largest;
}

void WarnAbove(const LegForce& force, const std::optional<double>& limit_n, const char* option, const char* advice,
               const std::vector<LegLoadRow>& rows, Run& run) {
  const LegLoadRow* largest = LargestOf(force, rows);
  if (!limit_n || !largest || !(largest->leg.*force.force_n > *limit_n)) return;
  run.Warn("{}: {:.0f} N at {:.1f}° (stroke {:.1f} mm), above --{} {}: {}", force.label, largest->leg.*force.force_n,
           largest->at.knee_deg, largest->at.stroke_mm, option, SignificantText(*limit_n, 6), advice);
}

void WarnOfNoRest(const std::vector<LegLoadRow>& rows, Run& run) {
  for (const LegLoadRow& row : rows) {
    if (!std::isfinite(row.at.moment_nm) || std::isfinite(row.leg.knee_shear_n)) continue;
    run.Warn(
        "the cuffs cannot bear the moment at {:.1f}°: two push the leg forward, and nothing leans against them; give "
        "them a length, or a segment two",
        row.at.knee_deg);
    return;
  }
}

}  // namespace

void LegLoadOptions::Check() const {
  if (cuffs.thigh.empty() != cuffs.shank.empty())
    throw UsageError("--thigh-cuff and --shank-cuff hold one device: give both or neither");
  if (!AreAsked() && (thigh_link_kg || shank_link_kg || max_leg_shear_n || max_cuff_force_n))
    throw UsageError("what the leg bears depends on the cuffs: give --thigh-cuff and --shank-cuff too");
}

void Describe(LegLoadOptions& o, OptionList& options) {
  DescribePlaces(o.cuffs, options);
  options
      .Add("thigh-link-mass", o.thigh_link_kg,
           "Mass of what is fixed to the thigh, for leg_loads; taken half way to the outermost cuff")
      .Unit("kg")
      .NotNegative()
      .Otherwise("all parts but the shank link, and the actuator");
  options.Add("shank-link-mass", o.shank_link_kg, "Mass of what is fixed to the shank, for leg_loads; likewise")
      .Unit("kg")
      .NotNegative()
      .Otherwise("of the shank link");
  options.Add("max-leg-shear", o.max_leg_shear_n, "Warn where moment and weight shear the knee by more")
      .Unit("N")
      .Positive();
  options.Add("max-cuff-force", o.max_cuff_force_n, "Warn where moment and weight press a cuff by more")
      .Unit("N")
      .Positive();
}

std::vector<LegLoadRow> LegLoadsOf(const std::vector<KneeMoment>& moments, const cuffs::CuffOptions& worn) {
  std::vector<LegLoadRow> rows;
  rows.reserve(moments.size());
  for (const KneeMoment& at : moments)
    rows.push_back({at, cuffs::StaticsOf({.thigh_deg = -at.knee_deg, .shank_deg = 0}, at.moment_nm, worn)});
  return rows;
}

void WriteLegLoads(const std::filesystem::path& path, const std::vector<LegLoadRow>& rows) {
  CsvWriter table(
      {"stroke_mm", "knee_deg", "moment_nm", "thigh_cuff_n", "shank_cuff_n", "knee_shear_n", "knee_compression_n"});
  for (const auto& [at, leg] : rows) {
    table.Add(at.stroke_mm).Add(at.knee_deg).Add(at.moment_nm);
    for (const LegForce& force : kLegForces) table.Add(leg.*force.force_n);
    table.EndRow();
  }
  table.Write(path);
}

Json ReportLegLoads(const std::vector<LegLoadRow>& rows, const LegLoadOptions& options, Run& run) {
  constexpr const char* kFarther = "a cuff farther from the knee, a longer one or a second one would help";
  WarnAbove(kThighCuff, options.max_cuff_force_n, "max-cuff-force", kFarther, rows, run);
  WarnAbove(kShankCuff, options.max_cuff_force_n, "max-cuff-force", kFarther, rows, run);
  WarnAbove(kKneeShear, options.max_leg_shear_n, "max-leg-shear", "two cuffs on each segment, far apart, would help",
            rows, run);
  WarnOfNoRest(rows, run);
  Json json = {{"posture", "shank upright, thigh by the knee angle"}};
  std::vector<std::string> texts;
  for (const LegForce& force : kLegForces)
    if (const LegLoadRow* largest = LargestOf(force, rows)) {
      const double force_n = largest->leg.*force.force_n;
      json[force.name] = {{"largest_n", force_n}, {"at_deg", largest->at.knee_deg}};
      texts.push_back(fmt::format("{} {} N at {:.1f}°", force.label, RoundedText(force_n, 0), largest->at.knee_deg));
    }
  if (!texts.empty()) run.Report("on the leg, shank upright: {}\n", fmt::join(texts, ", "));
  return json;
}

}  // namespace lake::commands
