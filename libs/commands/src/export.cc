#include "lake/commands/export.h"

#include <functional>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/drawing/linkage_dxf.h"
#include "lake/linkage/design_file.h"
#include "lake/model/simulator_model.h"
#include "lake/model/step_file.h"
#include "part_tables.h"

namespace lake::commands {
namespace {

struct Format {
  const char* name;
  const char* file;
  std::function<void(const std::filesystem::path&, const parts::Mechanism&)> write;
};

const std::vector<Format>& Formats() {
  static const std::vector<Format> kFormats = {
      {"mjcf", "design.xml", model::WriteMjcf},
      {"sdf", "design.sdf", model::WriteSdf},
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
  throw UsageError(fmt::format("no format '{}': there are {}", name, fmt::join(known, ", ")));
}

}  // namespace

Json RunExport(const ExportOptions& options, Run& run) {
  const Format& format = FormatNamed(options.format);
  const linkage::Design design = linkage::ReadDesign(options.design);
  run.AddInput(options.design, "design");
  const linkage::UsedRange range = linkage::FindUsedRange(design.links, design.d_min_mm, design.d_max_mm);
  const parts::Mechanism mechanism = parts::MakeMechanism(design.links, range, options.parts);
  run.Begin({"summary.json", format.file, "parts.csv"});
  WarnOfStack(mechanism, run);
  if (options.format == "urdf")
    run.Warn("URDF cannot close loops: the simulator has to join coupler_end to shank_pin and rod_end to bar_tip");
  format.write(run.Result(format.file), mechanism);
  WritePartList(run.Result("parts.csv"), mechanism);
  std::vector<std::string> layers;
  for (const std::vector<std::string>& bodies : LayersOf(mechanism.stack))
    layers.push_back(fmt::format("{}", fmt::join(bodies, " and ")));
  run.Report(fmt::format("{}; {:.0f} g without actuator; layers: {}\n", format.file, MassOf_g(mechanism),
                         fmt::join(layers, ", ")));
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
  options.AddOperand("format", o.format, "What to write").Value(fmt::format("{}", fmt::join(names, "|"))).Required();
  Describe(o.parts, options);
}

}  // namespace lake::commands
