#include "point_json.h"

namespace lake::redesign {

nlohmann::json JsonOf(const ReoptimizePoint& point) {
  return {{"links", point.links.Values()},
          {"knots_mm", point.knots_mm},
          {"placement_mm", {point.placement_mm.x(), point.placement_mm.y()}},
          {"duration_s", point.duration_s}};
}

ReoptimizePoint PointOf(const nlohmann::json& json) {
  ReoptimizePoint point;
  point.links = linkage::Links::FromValues(json.at("links").get<std::array<double, 6>>());
  json.at("knots_mm").get_to(point.knots_mm);
  point.placement_mm = {json.at("placement_mm").at(0).get<double>(), json.at("placement_mm").at(1).get<double>()};
  json.at("duration_s").get_to(point.duration_s);
  return point;
}

}  // namespace lake::redesign
