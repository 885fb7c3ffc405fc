#include <cmath>
#include <numbers>

#include "lake/model/simulator_model.h"
#include "rigid_bodies.h"
#include "xml.h"

namespace lake::model {
namespace {

using Eigen::Vector3d;

constexpr const char* kOrigin = "origin";
constexpr const char* kNoLimit = "1e9";  // URDF asks for a number; the design has none

void AddMassAndInertia(pugi::xml_node link, const RigidBody& body) {
  const pugi::xml_node inertial = Add(link, "inertial");
  Add(inertial, kOrigin, {{"xyz", TextOf(body.centre_m)}});
  Add(inertial, "mass", {{"value", NumberText(body.mass_kg)}});
  const Eigen::Matrix3d& i = body.inertia_kg_m2;
  Add(inertial, "inertia",
      {{"ixx", NumberText(i(0, 0))},
       {"ixy", NumberText(i(0, 1))},
       {"ixz", "0"},
       {"iyy", NumberText(i(1, 1))},
       {"iyz", "0"},
       {"izz", NumberText(i(2, 2))}});
}

pugi::xml_node AddShape(pugi::xml_node link, const Vector3d& at_m, const Vector3d& roll_pitch_yaw) {
  const pugi::xml_node visual = Add(link, "visual");
  Add(visual, kOrigin, {{"xyz", TextOf(at_m)}, {"rpy", TextOf(roll_pitch_yaw)}});
  return Add(visual, "geometry");
}

// URDF has boxes and cylinders: a box along each side of a plate, a disc on each corner.
void AddPlateShape(pugi::xml_node link, const parts::Plate& plate, const RigidBody& body) {
  const std::size_t count = plate.corners.size();
  const double width_m = 2 * kMetresPerMillimetre * plate.radius_mm, height_m = body.high_m - body.low_m;
  const double middle_m = (body.low_m + body.high_m) / 2;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d from = kMetresPerMillimetre * plate.corners[i];
    const Eigen::Vector2d side = kMetresPerMillimetre * plate.corners[(i + 1) % count] - from;
    Add(AddShape(link, {from.x(), from.y(), middle_m}, Vector3d::Zero()), "cylinder",
        {{"radius", NumberText(width_m / 2)}, {"length", NumberText(height_m)}});
    if (count == 2 && i == 1) continue;  // the way back
    const Eigen::Vector2d middle = from + side / 2;
    Add(AddShape(link, {middle.x(), middle.y(), middle_m}, {0, 0, std::atan2(side.y(), side.x())}), "box",
        {{"size", TextOf({side.norm(), width_m, height_m})}});
  }
}

void AddLink(pugi::xml_node robot, const RigidBody& body, const parts::Plate* plate) {
  const pugi::xml_node link = Add(robot, "link", {{"name", body.name}});
  AddMassAndInertia(link, body);
  if (plate) {
    AddPlateShape(link, *plate, body);
    return;
  }
  const Vector3d along_x(0, std::numbers::pi / 2, 0);
  Add(AddShape(link, body.centre_m, along_x), "cylinder",
      {{"radius", NumberText(body.cylinder_radius_m)},
       {"length", NumberText(body.cylinder_to_m - body.cylinder_from_m)}});
}

pugi::xml_node AddJoint(pugi::xml_node robot, const char* name, const char* type, const std::string& parent,
                        const std::string& child, const Vector3d& at_m, double turn_rad = 0) {
  const pugi::xml_node joint = Add(robot, "joint", {{"name", name}, {"type", type}});
  Add(joint, "parent", {{"link", parent}});
  Add(joint, "child", {{"link", child}});
  Add(joint, kOrigin, {{"xyz", TextOf(at_m)}, {"rpy", TextOf({0, 0, turn_rad})}});
  const std::string_view kind = type;
  if (kind != "fixed") Add(joint, "axis", {{"xyz", kind == "prismatic" ? "1 0 0" : "0 0 1"}});
  return joint;
}

// A place on a link, as a link without mass.
void AddPlace(pugi::xml_node robot, const char* name, const std::string& on, const Vector3d& at_m) {
  Add(robot, "link", {{"name", name}});
  AddJoint(robot, (std::string(name) + "_place").c_str(), "fixed", on, name, at_m);
}

}  // namespace

void WriteUrdf(const std::filesystem::path& path, const parts::Mechanism& mechanism) {
  const RigidBodies bodies = RigidBodiesOf(mechanism);
  const linkage::Links& links = mechanism.links;
  pugi::xml_document document;
  const pugi::xml_node robot = Add(document, "robot", {{"name", "knee_exoskeleton"}});
  AddComment(robot, MadeBy());
  AddComment(robot,
             "URDF is a tree. Two loops are cut: coupler_end must meet shank_pin, and rod_end must meet bar_tip; state "
             "this in the simulator. knee is 0 when straight, stroke is the actuator's length, pin to pin; with "
             "all joints at 0 the tree is not assembled.");
  Add(robot, "link", {{"name", "base"}});
  for (std::size_t i = 0; i < bodies.bodies.size(); ++i)
    AddLink(robot, bodies.bodies[i], i < parts::kPlates ? &mechanism.plates[i] : nullptr);
  const auto name = [&](BodyIndex index) { return bodies[index].name; };
  const auto at = [](double x_mm, double y_mm) {
    return Vector3d(kMetresPerMillimetre * x_mm, kMetresPerMillimetre * y_mm, 0);
  };
  // The thigh frame stands in the model's frame: half a turn about (0, 1, 1).
  const pugi::xml_node base = AddJoint(robot, "base_frame", "fixed", "base", name(BodyIndex::kThighPlate), {0, 0, 0});
  base.child(kOrigin).attribute("rpy") = TextOf({std::numbers::pi / 2, 0, std::numbers::pi}).c_str();
  // Straight, the shank points down, against the thigh frame's y.
  const std::string thigh = name(BodyIndex::kThighPlate);
  AddJoint(robot, "knee", "continuous", thigh, name(BodyIndex::kShankLink), at(0, 0), -std::numbers::pi / 2);
  AddJoint(robot, "thigh_pin", "continuous", thigh, name(BodyIndex::kSlewingBar), at(0, links.l3));
  AddJoint(robot, "tip", "continuous", name(BodyIndex::kSlewingBar), name(BodyIndex::kCoupler), at(links.l2, 0));
  AddJoint(robot, "mount", "continuous", thigh, name(BodyIndex::kActuatorBody), at(links.l5, links.l3 + links.l6));
  const pugi::xml_node stroke =
      AddJoint(robot, "stroke", "prismatic", name(BodyIndex::kActuatorBody), name(BodyIndex::kActuatorRod), at(0, 0));
  const linkage::StrokeRange& range = mechanism.range.stroke;
  Add(stroke, "limit",
      {{"lower", NumberText(kMetresPerMillimetre * range.lower_mm)},
       {"upper", NumberText(kMetresPerMillimetre * range.upper_mm)},
       {"effort", kNoLimit},
       {"velocity", kNoLimit}});
  AddPlace(robot, "coupler_end", name(BodyIndex::kCoupler), at(links.l1, 0));
  AddPlace(robot, "shank_pin", name(BodyIndex::kShankLink), at(links.l4, 0));
  AddPlace(robot, "rod_end", name(BodyIndex::kActuatorRod), at(0, 0));
  AddPlace(robot, "bar_tip", name(BodyIndex::kSlewingBar), at(links.l2, 0));
  WriteXml(path, document);
}

}  // namespace lake::model
