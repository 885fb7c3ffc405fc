#include "lake/loads/body_path.h"

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"

namespace lake::loads {
namespace {

namespace fs = std::filesystem;

struct NamedSegment {
  const char* name;
  SegmentInertia LegBody::*segment;
};
constexpr NamedSegment kSegments[] = {
    {"foot", &LegBody::foot}, {"shank", &LegBody::shank}, {"thigh", &LegBody::thigh}, {"trunk", &LegBody::trunk}};

// Throws Error where the lists are no body.
BodyPath FromJson(const Json& json) {
  BodyPath path;
  for (const NamedSegment& named : kSegments) {
    const Json& segment = json.at(named.name);
    path.body.*named.segment = {segment.at("mass_kg").get<double>(), segment.at("centre_mm").get<double>() / kMmPerM,
                                segment.at("gyration_mm").get<double>() / kMmPerM};
  }
  path.body.sole = {json.at("foot_mm").at(0).get<double>() / kMmPerM, json.at("foot_mm").at(1).get<double>() / kMmPerM};
  path.body.ankle_height_m = json.at("ankle_height_mm").get<double>() / kMmPerM;
  path.feet_from_percent = json.at("feet_from_percent").get<int>();
  const std::vector<double> tilt_deg = NumbersOrNaN(json.at("trunk_deg")), x_mm = NumbersOrNaN(json.at("trunk_x_mm")),
                            y_mm = NumbersOrNaN(json.at("trunk_y_mm"));
  constexpr std::size_t kPercents = 101;
  if (tilt_deg.size() != kPercents || x_mm.size() != kPercents || y_mm.size() != kPercents)
    throw Fail("the trunk's lists under 'body_path' must have 101 values");
  for (std::size_t i = 0; i < kPercents; ++i) {
    if (!std::isfinite(tilt_deg[i] + x_mm[i] + y_mm[i]))
      throw Fail("the trunk is not known at {} % of the rise: balance needs it over the whole rise", i);
    path.trunk.push_back({RadiansFromDegrees(tilt_deg[i]), Eigen::Vector2d(x_mm[i], y_mm[i]) / kMmPerM});
  }
  return path;
}

}  // namespace

Json BodyPathJson(const BodyPath& path) {
  Json json = {{"foot_mm", {kMmPerM * path.body.sole.heel_m, kMmPerM * path.body.sole.toe_m}},
               {"ankle_height_mm", kMmPerM * path.body.ankle_height_m},
               {"feet_from_percent", path.feet_from_percent}};
  for (const NamedSegment& named : kSegments) {
    const SegmentInertia& segment = path.body.*named.segment;
    json[named.name] = {{"mass_kg", segment.mass_kg},
                        {"centre_mm", kMmPerM * segment.centre_m},
                        {"gyration_mm", kMmPerM * segment.gyration_m}};
  }
  Json tilt_deg = Json::array(), x_mm = Json::array(), y_mm = Json::array();
  for (const TrunkSample& sample : path.trunk) {
    tilt_deg.push_back(DegreesFromRadians(sample.tilt_rad));
    x_mm.push_back(kMmPerM * sample.centre_m.x());
    y_mm.push_back(kMmPerM * sample.centre_m.y());
  }
  json.update({{"trunk_deg", tilt_deg}, {"trunk_x_mm", x_mm}, {"trunk_y_mm", y_mm}});
  return json;
}

BodyPath ReadBodyPath(const fs::path& path) {
  const fs::path file = fs::is_directory(path) ? path / "loads.json" : path;
  const Json json = ReadJsonFile(file);
  if (!json.is_object() || !json.contains("body_path"))
    throw Fail("{}: 'body_path' is missing: run lake loads again and give its loads.json", file.string());
  try {
    return FromJson(json.at("body_path"));
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: 'body_path' cannot be read: {}", file.string(), error.what());
  } catch (const Error& error) {
    throw Fail("{}: {}", file.string(), error.what());
  }
}

}  // namespace lake::loads
