#include "lake/linkage/design_file.h"

#include <algorithm>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/yaml.h"

namespace lake::linkage {
namespace {

template <typename Value>
Value Require(std::optional<Value> value, const YamlNode& node, std::string_view key) {
  if (!value) throw Fail("{}: the key '{}' is missing", node.Where(), key);
  return std::move(*value);
}

Links ReadLinks(YamlNode node) {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string key = fmt::format("l{}", i + 1);
    values[i] = Require(node.Number(key), node, "links: " + key);
  }
  node.Finish();
  const Links links = Links::FromValues(values);
  CheckLinks(links, node.Where());
  return links;
}

std::vector<StrokeProgram::Knot> ReadKnots(const YamlNode& node) {
  std::vector<StrokeProgram::Knot> knots;
  for (const YamlNode& element : node.Elements()) {
    const std::vector<YamlNode> pair = element.Elements();
    if (pair.size() != 2) throw Fail("{}: a knot is [time_s, stroke_mm], not {} values", element.Where(), pair.size());
    knots.push_back({pair[0].AsNumber(), pair[1].AsNumber()});
    if (knots.size() > 1 && !(knots.back().time_s > knots[knots.size() - 2].time_s))
      throw Fail("{}: the times of knots must ascend; {} s does not", element.Where(), knots.back().time_s);
    if (!(knots.back().stroke_mm > 0)) throw Fail("{}: a stroke must be above 0 mm", element.Where());
  }
  if (knots.size() < 2) throw Fail("{}: a free program needs at least two knots", node.Where());
  return knots;
}

StrokeProgram ReadProgram(YamlNode node) {
  StrokeProgram program;
  const std::string kind = Require(node.Text("kind"), node, "program: kind");
  if (kind == "constant") {
    program.speed_mm_s = Require(node.Number("speed_mm_s"), node, "program: speed_mm_s");
    if (!(program.speed_mm_s > 0))
      throw Fail("{}: speed_mm_s must be above 0, not {}", node.Where(), program.speed_mm_s);
  } else if (kind == "free") {
    program.kind = StrokeProgram::Kind::kFree;
    program.knots = ReadKnots(Require(node.Child("knots"), node, "program: knots"));
  } else {
    throw Fail("{}: program kind '{}' is neither 'constant' nor 'free'", node.Where(), kind);
  }
  node.Finish();
  return program;
}

std::string ProgramText(const StrokeProgram& program) {
  if (program.kind == StrokeProgram::Kind::kConstant)
    return fmt::format("program:\n  kind: constant\n  speed_mm_s: {}\n", FormatNumber(program.speed_mm_s));
  std::string text = "program:\n  kind: free\n  knots:\n";
  for (const auto& knot : program.knots)
    text += fmt::format("    - [{}, {}]\n", FormatNumber(knot.time_s), FormatNumber(knot.stroke_mm));
  return text;
}

// A single-quoted YAML scalar.
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted.append(c == '\'' ? 2 : 1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

// A map of texts.
void ReadTexts(YamlNode& root, const char* key, Json& texts) {
  auto node = root.Child(key);
  if (!node) return;
  if (!node->IsMap()) throw Fail("{}: '{}' must have keys", node->Where(), key);
  for (const auto& [name, value] : node->Pairs()) texts[name] = value.AsText();
}

// A line of its own; JSON is YAML, too.
std::string TextsLine(const char* key, const Json& texts) {
  return texts.empty() ? "" : fmt::format("{}: {}\n", key, texts.dump());
}

Mount ReadMount(const YamlNode& node) {
  try {
    return MountOf(node.AsText());
  } catch (const UsageError& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
}

}  // namespace

Design ReadDesign(const std::filesystem::path& path) {
  if (std::filesystem::is_regular_file(path / "design.yaml"))
    throw Fail("{}: is a folder; its design is {}", path.string(), (path / "design.yaml").string());
  YamlNode root = YamlNode::ReadFile(path);
  if (!root.IsMap()) throw Fail("{}: a design is a map with the keys links, d_min_mm, …", path.string());
  ExpectKind(root, "design");
  Design design;
  design.links = ReadLinks(Require(root.Child("links"), root, "links"));
  design.d_min_mm = Require(root.Number("d_min_mm"), root, "d_min_mm");
  design.d_max_mm = root.Number("d_max_mm");
  design.range_deg = root.Number("range_deg");
  if (const auto placement = root.Numbers("placement_mm", 2)) design.placement_mm = {(*placement)[0], (*placement)[1]};
  if (const auto mount = root.Child("mount")) design.mount = ReadMount(*mount);
  if (auto program = root.Child("program")) design.program = ReadProgram(std::move(*program));
  ReadTexts(root, "parts", design.parts);
  ReadTexts(root, "body", design.body);
  ReadTexts(root, "load", design.load);
  design.made_by = root.Text("made_by").value_or("");
  root.Finish();
  if (!(design.d_min_mm > 0)) throw Fail("{}: d_min_mm must be above 0, not {}", root.Where(), design.d_min_mm);
  if (design.d_max_mm && !(*design.d_max_mm > design.d_min_mm))
    throw Fail("{}: d_max_mm = {} must exceed d_min_mm = {}", root.Where(), *design.d_max_mm, design.d_min_mm);
  return design;
}

double StrokeAt(const std::vector<StrokeProgram::Knot>& knots, double time_s) {
  if (time_s <= knots.front().time_s) return knots.front().stroke_mm;
  if (time_s >= knots.back().time_s) return knots.back().stroke_mm;
  const auto after = std::ranges::upper_bound(knots, time_s, {}, &StrokeProgram::Knot::time_s), before = after - 1;
  return std::lerp(before->stroke_mm, after->stroke_mm, (time_s - before->time_s) / (after->time_s - before->time_s));
}

void WriteDesign(const std::filesystem::path& path, const Design& design) {
  std::string text = "links:\n";
  const auto values = design.links.Values();
  for (std::size_t i = 0; i < values.size(); ++i) text += fmt::format("  l{}: {}\n", i + 1, FormatNumber(values[i]));
  text += fmt::format("d_min_mm: {}\n", FormatNumber(design.d_min_mm));
  if (design.d_max_mm) text += fmt::format("d_max_mm: {}\n", FormatNumber(*design.d_max_mm));
  if (design.range_deg) text += fmt::format("range_deg: {}\n", FormatNumber(*design.range_deg));
  text += fmt::format("placement_mm: [{}, {}]\n", FormatNumber(design.placement_mm[0]),
                      FormatNumber(design.placement_mm[1]));
  text += fmt::format("mount: {}\n", NameOf(design.mount));
  if (design.program) text += ProgramText(*design.program);
  text += TextsLine("parts", design.parts) + TextsLine("body", design.body) + TextsLine("load", design.load);
  if (!design.made_by.empty()) text += fmt::format("made_by: {}\n", Quoted(design.made_by));
  WriteTextFile(path, text);
}

}  // namespace lake::linkage
