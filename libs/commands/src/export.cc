#include "lake/commands/export.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "lake/compare/comparison_file.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/removed.h"
#include "lake/drawing/linkage_dxf.h"
#include "lake/linkage/design_file.h"
#include "lake/model/coupled_model.h"
#include "lake/model/simulator_model.h"
#include "lake/model/step_file.h"
#include "lake/problem/problem_file.h"
#include "lake/redesign/human_motion.h"
#include "part_tables.h"

namespace lake::commands {
namespace {

struct Format {
  const char* name;
  const char* file;
  std::function<void(const std::filesystem::path&, const parts::Mechanism&)> write;
  // Worn by a person; none where the format has no such model.
  std::function<void(const std::filesystem::path&, const parts::Mechanism&, const model::Subject&)> write_worn =
      nullptr;
};

const std::vector<Format>& Formats() {
  static const std::vector<Format> kFormats = {
      {"mjcf", "design.xml", model::WriteMjcf, model::WriteCoupledMjcf},
      {"osim", "design.osim", model::WriteOsim, model::WriteCoupledOsim},
      {"urdf", "design.urdf", model::WriteUrdf},
      {"step", "design.step",
       [](const std::filesystem::path& path, const parts::Mechanism& mechanism) {
         model::WriteStep(path, mechanism, model::ReferencePose(mechanism));
       }},
      {"dxf", "design.dxf",
       [](const std::filesystem::path& path, const parts::Mechanism& mechanism) {
         drawing::WriteLinkPlates(path, mechanism.links, mechanism.options);
       }},
  };
  return kFormats;
}

const Format& FormatNamed(const std::string& name) {
  std::vector<std::string> known;
  for (const Format& format : Formats()) {
    if (format.name == name) return format;
    known.push_back(format.name);
  }
  if (const std::string why = WhyRemoved("lake-export", name); !why.empty()) throw UsageError("{}", why);
  throw UsageError("no format '{}': there are {}", name, fmt::join(known, ", "));
}

std::filesystem::path MotionOf(const ExportOptions& options) {
  return options.motion.empty() ? options.design.parent_path() / "predicted" : options.motion;
}

void CheckBody(const ExportOptions& options) {
  if (options.body.empty()) {
    if (!options.motion.empty())
      throw UsageError("--motion only applies to a worn mechanism: give --body loads.json too");
    return;
  }
  if (!FormatNamed(options.format).write_worn)
    throw UsageError("--body is for mjcf and osim, not for {}", options.format);
  if (const std::filesystem::path motion = MotionOf(options); options.motion.empty() && !exists(motion))
    throw UsageError("{} is not there: give --motion, a folder of lake-optimize's predicted/ or of lake-compare",
                     motion.string());
}

double LeanDeg(const Eigen::Vector2d& up) {
  return DegreesFromRadians(std::atan2(up.x(), up.y()));
}

// By the design's program; without one the leg moved it, as in a redesign: at the knee angles of its trial.
std::optional<std::vector<double>> WornStrokes(const linkage::Design& design, const compare::ComparedCurves& curves) {
  if (design.program) return redesign::ProgramStrokes(design, 0, redesign::MakeHumanMotion(curves.human));
  std::vector<double> knee_rad;
  knee_rad.reserve(curves.exo.knee_deg.size());
  for (const double knee_deg : curves.exo.knee_deg) knee_rad.push_back(RadiansFromDegrees(knee_deg));
  return redesign::StrokesForAngles(redesign::DrivenLinksOf(design, 0), knee_rad);
}

// lake-optimize's balance.csv beside the design says how the trunk leans for balance.
void WarnOfLean(const ExportOptions& options, Run& run) {
  const std::filesystem::path file = options.design.parent_path() / "balance.csv";
  if (!exists(file)) return;
  const CsvTable balance = CsvTable::Read(file);
  if (!balance.Has("trunk_lean_deg")) return;
  double largest_deg = 0;
  for (std::size_t i = 0; i < balance.Rows(); ++i)
    largest_deg = std::max(largest_deg, std::abs(balance.RequiredNumber(i, balance.Column("trunk_lean_deg"))));
  constexpr double kTold_deg = 0.5;
  if (largest_deg >= kTold_deg)
    run.Warn(
        "the trunk leans as in {}; that it has to lean up to {:.0f} degrees otherwise for balance, as {} says, is not "
        "in the model",
        options.body.string(), largest_deg, file.string());
}

// The person in the motion of the exoskeleton's leg.
model::Subject SubjectOf(const ExportOptions& options, const linkage::Design& design) {
  const std::filesystem::path folder = MotionOf(options);
  const compare::ComparedCurves curves = compare::ReadComparisonOfRises(folder);
  const compare::StsCurve& exo = curves.exo;
  if (exo.leg_knee.empty())
    throw Fail("{}: it shows no leg beside the exoskeleton's joint: nobody wears it", folder.string());
  const auto strokes = WornStrokes(design, curves);
  if (!strokes) throw Fail("{}: the design cannot be assembled at d_min", options.design.string());
  model::Subject subject{.body = loads::ReadBodyPath(options.body), .cuffs = options.cuffs, .rise = {}};
  for (std::size_t i = 0; i < exo.knee.size(); ++i) {
    const Eigen::Vector2d shank = exo.leg_knee[i] - exo.ankle[i], thigh = exo.hip[i] - exo.leg_knee[i];
    subject.shank_mm += shank.norm() / static_cast<double>(exo.knee.size());
    subject.thigh_mm += thigh.norm() / static_cast<double>(exo.knee.size());
    subject.rise.push_back(
        {.time_s = exo.duration_s * static_cast<double>(i) / static_cast<double>(exo.knee.size() - 1),
         .shank_deg = LeanDeg(shank),
         .knee_deg = LeanDeg(shank) - LeanDeg(thigh),
         .trunk_deg = DegreesFromRadians(subject.body.trunk[i].tilt_rad),
         .stroke_mm = (*strokes)[i]});
  }
  const std::size_t last = exo.knee.size() - 1;
  subject.hinge_mm =
      compare::AxesAlong(exo.leg_knee[last] - exo.ankle[last]).transpose() * (exo.knee[last] - exo.leg_knee[last]);
  return subject;
}

}  // namespace

std::vector<InputFile> InputsOf(const ExportOptions& options) {
  std::vector<InputFile> inputs{{options.design, "design"}};
  if (options.body.empty()) return inputs;
  inputs.push_back({std::filesystem::is_directory(options.body) ? options.body / "loads.json" : options.body, "body"});
  inputs.push_back({MotionOf(options) / "comparison.json", "motion"});
  return inputs;
}

Json RunExport(const ExportOptions& options, Run& run) {
  const Format& format = FormatNamed(options.format);
  CheckBody(options);
  const linkage::Design design = linkage::ReadDesign(options.design);
  std::optional<model::Subject> subject;
  if (!options.body.empty()) {
    subject = SubjectOf(options, design);
    WarnOfLean(options, run);
  }
  run.AddInputs(InputsOf(options));
  const linkage::UsedRange range = linkage::FindUsedRange(design.links, design.d_min_mm, design.d_max_mm);
  const parts::Mechanism mechanism = parts::MakeMechanism(design.links, range, options.parts);
  run.Begin({"summary.json", format.file, "parts.csv", "course.csv", "course.mot"});
  WarnOfStack(mechanism, run);
  if (options.format == "urdf")
    run.Warn("URDF cannot close loops: the simulator has to join coupler_end to shank_pin and rod_end to bar_tip");
  if (subject) {
    format.write_worn(run.Result(format.file), mechanism, *subject);
    model::WriteCourse(run.Result("course.csv"), *subject);
    if (options.format == "osim") model::WriteOsimMotion(run.Result("course.mot"), mechanism, *subject);
  } else {
    format.write(run.Result(format.file), mechanism);
  }
  WritePartList(run.Result("parts.csv"), mechanism);
  std::vector<std::string> layers;
  for (const std::vector<std::string>& bodies : LayersOf(mechanism.stack))
    layers.push_back(fmt::format("{}", fmt::join(bodies, " and ")));
  run.Report("{}; {:.0f} g without actuator; layers: {}\n", format.file, MassOf_g(mechanism), fmt::join(layers, ", "));
  const linkage::Pose pose = model::ReferencePose(mechanism);
  return {{"format", format.name},
          {"file", format.file},
          {"reference_stroke_mm", pose.stroke_mm},
          {"reference_knee_deg", DegreesFromRadians(pose.theta_rad)},
          {"parts", PartsJson(mechanism)}};
}

void Describe(ExportOptions& o, OptionList& options) {
  options.AddOperand("design", o.design, "design.yaml, as lake-optimize writes it").Required();
  std::vector<std::string> names;
  for (const Format& format : Formats()) names.push_back(format.name);
  const auto take = [&o](const OptionTexts& texts, const std::string& said) {
    OptionField<std::string>::Set(texts, said, o.format);
    FormatNamed(o.format);
    problem::TakeFromDesign(linkage::ReadDesign(o.design).parts, o.design,
                            OptionsOf(o.parts));  // which options below change
  };
  options.AddCustom("format", "What to write", take, [&o] { return o.format; })
      .Operand()
      .Value(fmt::format("{}", fmt::join(names, "|")))
      .Required();
  Describe(o.parts, options);
  options
      .Add("body", o.body,
           "Of mjcf and osim: worn by this person, loads.json or the folder of lake-loads: leg, trunk, cuffs that "
           "yield, and the rise")
      .IsPath(Option::Path::kFile)
      .Otherwise("the mechanism alone");
  options.Add("motion", o.motion, "With --body: the rise, a folder of lake-optimize's predicted/ or of lake-compare")
      .IsPath(Option::Path::kFolder)
      .Otherwise("predicted/ beside the design");
  Describe(o.cuffs, options);
  options.Check([&o](const OptionList& list) {
    for (const char* name : {"thigh-cuff", "shank-cuff", "cuff-softest", "cuff-stiffest"})
      if (o.body.empty() && list.IsGiven(name))
        throw UsageError("--{} only applies to a worn mechanism: give --body loads.json too", name);
  });
}

}  // namespace lake::commands
