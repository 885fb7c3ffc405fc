#include "lake/loads/anthropometry.h"

#include <cmath>

#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/core/yaml.h"
#include "lake/person/body.h"

namespace lake::loads {
namespace {

// Table 4.1 there; head, arms and trunk from the greater trochanter to the glenohumeral joint.
Anthropometry Winter() {
  return {"winter",
          "D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed., Wiley 2009, table 4.1, "
          "doi 10.1002/9780470549148",
          {0.0145, 0.5, 0.475},
          {0.0465, 0.433, 0.302},
          {0.100, 0.433, 0.323},
          {0.678, 0.626, 0.496}};
}

// Table 4 there; the gyrations are those about the mediolateral axis ("transverse"), about which the leg flexes. Head,
// arms and trunk are put together from trunk, head, and arms that hang down, with the table's mean lengths; the room's
// README has the sums and a test repeats them.
Anthropometry DeLeva(Sex sex) {
  const std::string source =
      "P. de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, J. Biomech. 29(9), 1996, "
      "1223-1230, doi 10.1016/0021-9290(95)00178-6";
  if (sex == Sex::kMale)
    return {"deleva, male",          source, {0.0137, 0.4415, 0.245}, {0.0433, 0.4395, 0.246}, {0.1416, 0.4095, 0.329},
            {0.6028, 0.6411, 0.4398}};
  return {"deleva, female",        source, {0.0129, 0.4014, 0.279}, {0.0481, 0.4352, 0.263}, {0.1478, 0.3612, 0.364},
          {0.5824, 0.6907, 0.4505}};
}

SegmentShare ReadShare(YamlNode& file, const char* name) {
  std::optional<YamlNode> node = file.Child(name);
  if (!node) throw Fail("{}: no segment '{}'; needed are foot, shank, thigh and trunk", file.Where(), name);
  const auto share = [&](const char* key, double most) {
    const std::optional<double> value = node->Number(key);
    if (!value) throw Fail("{}: segment '{}' has no '{}'", node->Where(), name, key);
    if (!(*value > 0 && *value < most))
      throw Fail("{}: {} of '{}' is {}, not between 0 and {}", node->Where(), key, name, *value, most);
    return *value;
  };
  const SegmentShare segment = {share("mass", 1), share("centre", 1.5), share("gyration", 1.5)};
  node->Finish();
  return segment;
}

}  // namespace

Anthropometry FindAnthropometry(const std::string& name_or_file, std::optional<Sex> sex) {
  if (name_or_file == "winter") return Winter();
  if (name_or_file != kDeLeva) return ReadAnthropometry(name_or_file);
  if (!sex) throw UsageError("--anthropometry deleva: has a table for men and one for women; give --sex");
  return DeLeva(*sex);
}

Anthropometry ReadAnthropometry(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw Fail("--anthropometry '{}': neither winter nor deleva nor a file", path.string());
  YamlNode file = YamlNode::ReadFile(path);
  Anthropometry table{.name = path.filename().string(),
                      .source = file.Text("source").value_or(""),
                      .foot = ReadShare(file, "foot"),
                      .shank = ReadShare(file, "shank"),
                      .thigh = ReadShare(file, "thigh"),
                      .trunk = ReadShare(file, "trunk")};
  file.Finish();
  const double sum = 2 * (table.foot.mass + table.shank.mass + table.thigh.mass) + table.trunk.mass;
  if (std::abs(sum - 1) > 0.02)
    throw Fail("{}: both legs and the trunk add up to {} of the body's mass, not 1", path.string(),
               SignificantText(sum, 4));
  return table;
}

Foot FootOfStature(double height_m) {
  constexpr double kBehindAnkle = 0.25;
  return {kBehindAnkle * person::kFoot * height_m, (1 - kBehindAnkle) * person::kFoot * height_m};
}

double AnkleHeightOfStature(double height_m) {
  return person::kAnkleHeight * height_m;
}

double TrunkOfStature(double height_m) {
  return person::kTrunk * height_m;
}

double StatureOfLeg(double leg_m) {
  return leg_m / (person::kThigh + person::kShank);
}

}  // namespace lake::loads
