#include "lake/commands/further_inputs.h"

#include <fmt/format.h>

#include <cstdio>
#include <limits>

#include "force_plates.h"
#include "lake/commands/gait.h"
#include "lake/core/error.h"
#include "lake/exchange/ground_forces.h"
#include "lake/gait/gait_cycles.h"
#include "lake/sync/clock.h"

namespace lake::commands {
namespace {

using Eigen::Vector3d;

struct Interval {
  double from_s, to_s;
};

// "0.2,1.5"; nullopt for anything else. A study gives its own folder before it.
std::optional<Interval> IntervalOf(const std::filesystem::path& neutral) {
  Interval interval{};
  char rest = 0;
  if (std::sscanf(neutral.filename().c_str(), "%lf,%lf%c", &interval.from_s, &interval.to_s, &rest) != 2) return {};
  if (!(interval.from_s < interval.to_s))
    throw UsageError("--neutral {:g},{:g}: two times in seconds, the earlier one first", interval.from_s,
                     interval.to_s);
  return interval;
}

}  // namespace

void DescribeForces(FurtherInputs& o, OptionList& options) {
  options.Add("forces", o.forces, "Ground forces of plates: OpenSim's .mot or .sto, or a .c3d").Otherwise("none");
  options.Add("sync", o.sync, "The forces' clock against the trial's: the sync.yaml of lake sync TRIAL FORCES")
      .Otherwise("they have one clock");
  options.Check([&o](const OptionList&) {
    if (o.sync && o.forces.empty()) throw UsageError("--sync only applies together with --forces");
  });
}

void Describe(FurtherInputs& o, OptionList& options) {
  DescribeForces(o, options);
  options.Add("neutral", o.neutral, "Quiet standing, which NAME_neutral_deg in kinematics.csv is relative to")
      .Value("TRIAL|FROM,TO")
      .Otherwise("none: 0 is where the markers say so");
  options.Add("reference", o.reference, "The knee over the gait cycle as percent,mean,sd: a band in gait_cycles.png")
      .Otherwise("none");
  options.Check([&o](const OptionList&) { IntervalOf(o.neutral); });
}

std::vector<InputFile> InputsOf(const FurtherInputs& o) {
  std::vector<InputFile> inputs;
  if (!o.forces.empty()) inputs.push_back({o.forces, "forces"});
  if (o.sync) inputs.push_back({*o.sync, "sync"});
  if (!o.reference.empty()) inputs.push_back({o.reference, "reference"});
  if (!o.neutral.empty() && !IntervalOf(o.neutral))
    for (const InputFile& input : TrialInputs(o.neutral, "neutral")) inputs.push_back(input);
  return inputs;
}

void CheckFiles(const FurtherInputs& o) {
  if (!o.reference.empty()) gait::ReadReferenceCurve(o.reference);
  if (!o.forces.empty()) exchange::ReadGroundForces(o.forces);
  if (o.sync) sync::ReadClockOf(*o.sync, o.forces);
}

std::vector<gait::PlateContact> ContactsOf(const FurtherInputs& o, const exchange::Trial& trial, Run& run) {
  if (o.forces.empty()) return {};
  exchange::GroundForceRecording forces = exchange::ReadGroundForces(o.forces);
  for (const std::string& warning : forces.warnings) run.Warn(warning);
  const Vector3d up = VerticalOf(forces, trial, o.forces);
  if (o.sync) {
    const sync::Clock clock = sync::ReadClockOf(*o.sync, o.forces);
    for (double& time_s : forces.time_s) time_s = clock.FromB(time_s);
  }
  std::vector<gait::PlateContact> contacts;
  for (const exchange::PlateForces& plate : forces.plates) {
    std::vector<double> vertical_n;
    for (const Eigen::Vector3d& force : plate.force_n) vertical_n.push_back(force.dot(up));
    for (const gait::PlateLoad& load : gait::LoadsOf(vertical_n, forces.time_s)) contacts.push_back({load, plate.name});
  }
  if (contacts.empty()) run.Warn("{}: no plate bears a foot for 0.1 s: events are the markers'", o.forces.string());
  return contacts;
}

void SetNeutral(const FurtherInputs& o, const exchange::Trial& trial, exchange::TrialOptions reading,
                const gait::LegFitOptions& fit, Run& run, gait::LegFitResult& leg) {
  if (o.neutral.empty()) return;
  try {
    if (const auto interval = IntervalOf(o.neutral)) {
      leg.motion.neutral = gait::NeutralPose(leg, interval->from_s, interval->to_s);
      return;
    }
    reading.plane_from_space = trial.plane_from_space;
    const exchange::Trial standing = ReadTrialFor(o.neutral, reading);
    gait::LegFitOptions of_standing = fit;
    of_standing.facing = leg.motion.facing;
    constexpr double kAlways = std::numeric_limits<double>::infinity();
    leg.motion.neutral = gait::NeutralPose(FitTrial(standing, of_standing, run), -kAlways, kAlways);
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    throw Fail("--neutral {}: {}", o.neutral.string(), error.what());
  }
}

}  // namespace lake::commands
