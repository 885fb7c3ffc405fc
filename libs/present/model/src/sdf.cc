#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/model/simulator_model.h"
#include "rigid_bodies.h"
#include "xml.h"

namespace lake::model {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// x y z and fixed-axis angles of a frame that is turned about z within the thigh frame, in the model's frame.
std::string PoseText(const Isometry3d& thigh_from_frame) {
  const Vector3d at = ModelFromThigh() * thigh_from_frame.translation();
  const Eigen::Matrix3d turn = ModelFromThigh() * thigh_from_frame.linear();
  const double yaw = std::atan2(turn(1, 0), turn(0, 0));
  const double pitch = std::atan2(-turn(2, 0), std::hypot(turn(0, 0), turn(1, 0)));
  const double roll = std::atan2(turn(2, 1), turn(2, 2));
  return TextOf({at.x(), at.y(), at.z(), roll, pitch, yaw});
}

void AddInertial(pugi::xml_node link, const RigidBody& body) {
  const pugi::xml_node inertial = Add(link, "inertial");
  AddText(inertial, "pose", TextOf({body.centre_m.x(), body.centre_m.y(), body.centre_m.z(), 0, 0, 0}));
  AddText(inertial, "mass", NumberText(body.mass_kg));
  const pugi::xml_node inertia = Add(inertial, "inertia");
  const Eigen::Matrix3d& i = body.inertia_kg_m2;
  for (const auto& [name, value] : {std::pair{"ixx", i(0, 0)},
                                    {"ixy", i(0, 1)},
                                    {"ixz", i(0, 2)},
                                    {"iyy", i(1, 1)},
                                    {"iyz", i(1, 2)},
                                    {"izz", i(2, 2)}})
    AddText(inertia, name, NumberText(value));
}

void AddVisual(pugi::xml_node link, const RigidBody& body) {
  const pugi::xml_node visual = Add(link, "visual", {{"name", body.name + "_shape"}});
  if (body.IsCylinder()) {
    // SDFormat's cylinder stands along z: turned about y it lies along x.
    AddText(visual, "pose", TextOf({body.centre_m.x(), 0, body.centre_m.z(), 0, std::numbers::pi / 2, 0}));
    const pugi::xml_node cylinder = Add(Add(visual, "geometry"), "cylinder");
    AddText(cylinder, "radius", NumberText(body.cylinder_radius_m));
    AddText(cylinder, "length", NumberText(body.cylinder_to_m - body.cylinder_from_m));
    return;
  }
  AddText(visual, "pose", TextOf({0, 0, body.low_m, 0, 0, 0}));
  const pugi::xml_node polyline = Add(Add(visual, "geometry"), "polyline");
  for (const Eigen::Vector2d& point : body.outline_m) AddText(polyline, "point", TextOf({point.x(), point.y()}));
  AddText(polyline, "height", NumberText(body.high_m - body.low_m));
}

// A joint at a place in the child's frame.
pugi::xml_node AddJoint(pugi::xml_node model, const char* name, const char* type, BodyIndex parent, BodyIndex child,
                        const RigidBodies& bodies, const Vector3d& in_child_m) {
  const pugi::xml_node joint = Add(model, "joint", {{"name", name}, {"type", type}});
  AddText(joint, "parent", bodies[parent].name);
  AddText(joint, "child", bodies[child].name);
  AddText(joint, "pose", TextOf({in_child_m.x(), in_child_m.y(), in_child_m.z(), 0, 0, 0}));
  const bool slides = std::string_view(type) == "prismatic";
  AddText(Add(joint, "axis"), "xyz", slides ? "1 0 0" : "0 0 1");
  return joint;
}

}  // namespace

void WriteSdf(const std::filesystem::path& path, const parts::Mechanism& mechanism) {
  const RigidBodies bodies = RigidBodiesOf(mechanism);
  const linkage::Pose& pose = bodies.reference;
  pugi::xml_document document;
  const pugi::xml_node sdf = Add(document, "sdf", {{"version", "1.9"}});
  AddComment(sdf, MadeBy());
  AddComment(sdf, fmt::format("All joint positions are 0 in this pose: knee angle {} deg, actuator {} m, pin to pin. "
                              "The joints shank_pin and rod_end close loops.",
                              NumberText(DegreesFromRadians(pose.theta_rad)),
                              NumberText(kMetresPerMillimetre * pose.stroke_mm)));
  const pugi::xml_node model = Add(sdf, "model", {{"name", "knee_exoskeleton"}});
  for (const RigidBody& body : bodies.bodies) {
    const pugi::xml_node link = Add(model, "link", {{"name", body.name}});
    AddText(link, "pose", PoseText(body.thigh_from_body));
    AddInertial(link, body);
    AddVisual(link, body);
  }
  const pugi::xml_node base = Add(model, "joint", {{"name", "base"}, {"type", "fixed"}});
  AddText(base, "parent", "world");
  AddText(base, "child", bodies[BodyIndex::kThighPlate].name);
  using enum BodyIndex;
  AddJoint(model, "knee", "revolute", kThighPlate, kShankLink, bodies, Vector3d::Zero());
  AddJoint(model, "thigh_pin", "revolute", kThighPlate, kSlewingBar, bodies, Vector3d::Zero());
  AddJoint(model, "tip", "revolute", kSlewingBar, kCoupler, bodies, Vector3d::Zero());
  AddJoint(model, "mount", "revolute", kThighPlate, kActuatorBody, bodies, Vector3d::Zero());
  const pugi::xml_node stroke =
      AddJoint(model, "stroke", "prismatic", kActuatorBody, kActuatorRod, bodies, Vector3d::Zero());
  const pugi::xml_node limit = Add(stroke.child("axis"), "limit");
  const linkage::StrokeRange& range = mechanism.range.stroke;
  AddText(limit, "lower", NumberText(kMetresPerMillimetre * (range.lower_mm - pose.stroke_mm)));
  AddText(limit, "upper", NumberText(kMetresPerMillimetre * (range.upper_mm - pose.stroke_mm)));
  const Vector3d coupler_end(kMetresPerMillimetre * mechanism.links.l1, 0, 0);
  AddJoint(model, "shank_pin", "revolute", kShankLink, kCoupler, bodies, coupler_end);
  AddJoint(model, "rod_end", "revolute", kSlewingBar, kActuatorRod, bodies, Vector3d::Zero());
  WriteXml(path, document);
}

}  // namespace lake::model
