#include "osim_document.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lake/loads/inverse_dynamics.h"
#include "xml.h"

namespace lake::model {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

pugi::xml_node AddNamed(pugi::xml_node parent, const char* type, const std::string& name) {
  return Add(parent, type, {{"name", name}});
}

// A set of the model; its members stand in `objects`.
pugi::xml_node AddSet(pugi::xml_node model, const char* type, const char* name) {
  const pugi::xml_node objects = Add(AddNamed(model, type, name), "objects");
  Add(objects.parent(), "groups");
  return objects;
}

std::string PathOf(const std::string& body) {
  return body == "ground" ? "/ground" : "/bodyset/" + body;
}

const char* BoolText(bool value) {
  return value ? "true" : "false";
}

const char* TypeOf(OsimJoint type) {
  switch (type) {
    case OsimJoint::kWeld:
      return "WeldJoint";
    case OsimJoint::kPin:
      return "PinJoint";
    case OsimJoint::kSlider:
      return "SliderJoint";
    case OsimJoint::kPlanar:
      break;
  }
  return "PlanarJoint";
}

// How the child's frame stands in the parent's: a pin turns about z, a slider moves along x, a planar joint turns
// about z and moves along the parent's x and y.
Isometry3d MovedBy(OsimJoint type, const std::vector<OsimCoordinate>& q) {
  Isometry3d moved = Isometry3d::Identity();
  if (type == OsimJoint::kSlider) moved.translation().x() = q[0].value;
  if (type == OsimJoint::kPlanar) moved.translation() << q[1].value, q[2].value, 0;
  if (type == OsimJoint::kPin || type == OsimJoint::kPlanar)
    moved.rotate(Eigen::AngleAxisd(q[0].value, Vector3d::UnitZ()));
  return moved;
}

void AddCoordinate(pugi::xml_node coordinates, const OsimCoordinate& coordinate) {
  constexpr double kAnyLength_m = 5;
  const double any = coordinate.is_length ? kAnyLength_m : std::numbers::pi;
  const auto [least, most] = coordinate.range.value_or(std::pair(-any, any));
  const pugi::xml_node node = AddNamed(coordinates, "Coordinate", coordinate.name);
  AddText(node, "default_value", NumberText(coordinate.value));
  AddText(node, "default_speed_value", "0");
  AddText(node, "range", TextOf({least, most}));
  AddText(node, "clamped", BoolText(false));
  AddText(node, "locked", BoolText(false));
  const pugi::xml_node function = Add(node, "prescribed_function");
  if (coordinate.prescribed) {
    const pugi::xml_node spline = AddNamed(function, "SimmSpline", coordinate.name + "_over_time");
    AddText(spline, "x", TextOf(coordinate.prescribed->time_s));
    AddText(spline, "y", TextOf(coordinate.prescribed->values));
  }
  AddText(node, "prescribed", BoolText(coordinate.prescribed.has_value()));
  AddText(node, "is_free_to_satisfy_constraints", BoolText(coordinate.follows_loops));
}

Isometry3d Moved(const Vector3d& by_m) {
  return Isometry3d(Eigen::Translation3d(by_m));
}

}  // namespace

Vector3d BodyFixedXyz(const Eigen::Matrix3d& turn) {
  return {std::atan2(-turn(1, 2), turn(2, 2)), std::asin(std::clamp(turn(0, 2), -1.0, 1.0)),
          std::atan2(-turn(0, 1), turn(0, 0))};
}

OsimDocument::OsimDocument(const std::string& name) : ground_from_{{"ground", Isometry3d::Identity()}} {
  const pugi::xml_node root = Add(document_, "OpenSimDocument", {{"Version", "40000"}});
  const pugi::xml_node model = AddNamed(root, "Model", name);
  AddComment(model, MadeBy());
  AddNamed(model, "Ground", "ground");
  AddText(model, "gravity", TextOf({0, -loads::kGravity_m_s2, 0}));
  AddText(model, "length_units", "meters");
  AddText(model, "force_units", "N");
  bodies_ = AddSet(model, "BodySet", "bodyset");
  joints_ = AddSet(model, "JointSet", "jointset");
  constraints_ = AddSet(model, "ConstraintSet", "constraintset");
  forces_ = AddSet(model, "ForceSet", "forceset");
}

Isometry3d OsimDocument::GroundFrom(const std::string& body) const {
  return ground_from_.at(body);
}

pugi::xml_node OsimDocument::AddOffsetFrame(pugi::xml_node parent, const std::string& name, const std::string& body,
                                            const Isometry3d& ground_from_frame) const {
  const Isometry3d body_from_frame = GroundFrom(body).inverse() * ground_from_frame;
  const pugi::xml_node frame = AddNamed(parent, "PhysicalOffsetFrame", name);
  AddText(frame, "socket_parent", PathOf(body));
  AddText(frame, "translation", TextOf(body_from_frame.translation()));
  AddText(frame, "orientation", TextOf(BodyFixedXyz(body_from_frame.linear())));
  return frame;
}

void OsimDocument::AddBody(const OsimBody& body) {
  ground_from_[body.name] = body.ground_from_body;
  const pugi::xml_node node = AddNamed(bodies_, "Body", body.name);
  Add(node, "components");
  AddText(node, "mass", NumberText(body.mass_kg));
  AddText(node, "mass_center", TextOf(body.centre_m));
  const Eigen::Matrix3d& i = body.inertia_kg_m2;
  AddText(node, "inertia", TextOf({i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}));
}

pugi::xml_node OsimDocument::AddShape(const std::string& body, const Isometry3d& body_from_shape, const char* type) {
  const pugi::xml_node components = bodies_.find_child_by_attribute("name", body.c_str()).child("components");
  const pugi::xml_node frame =
      AddOffsetFrame(components, body + "_shape_frame", body, GroundFrom(body) * body_from_shape);
  const pugi::xml_node shape = AddNamed(Add(frame, "attached_geometry"), type, body + "_shape");
  AddText(shape, "socket_frame", "..");
  return shape;
}

void OsimDocument::AddBrick(const std::string& body, const Vector3d& middle_m, const Vector3d& half_m) {
  AddText(AddShape(body, Moved(middle_m), "Brick"), "half_lengths", TextOf(half_m));
}

void OsimDocument::AddCylinder(const std::string& body, const Vector3d& from_m, const Vector3d& to_m, double radius_m) {
  // OpenSim's cylinder stands along y.
  Isometry3d middle = Moved((from_m + to_m) / 2);
  middle.rotate(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitY(), to_m - from_m));
  const pugi::xml_node shape = AddShape(body, middle, "Cylinder");
  AddText(shape, "radius", NumberText(radius_m));
  AddText(shape, "half_height", NumberText((to_m - from_m).norm() / 2));
}

void OsimDocument::AddJoint(OsimJoint type, const std::string& name, const std::string& parent,
                            const std::string& child, const Isometry3d& at,
                            const std::vector<OsimCoordinate>& coordinates) {
  const pugi::xml_node joint = AddNamed(joints_, TypeOf(type), name);
  const std::string parent_frame = name + "_on_" + parent, child_frame = name + "_on_" + child;
  AddText(joint, "socket_parent_frame", parent_frame);
  AddText(joint, "socket_child_frame", child_frame);
  if (!coordinates.empty()) {
    const pugi::xml_node list = Add(joint, "coordinates");
    for (const OsimCoordinate& coordinate : coordinates) AddCoordinate(list, coordinate);
  }
  const pugi::xml_node frames = Add(joint, "frames");
  AddOffsetFrame(frames, parent_frame, parent, at * MovedBy(type, coordinates).inverse());
  AddOffsetFrame(frames, child_frame, child, at);
}

void OsimDocument::AddPin(const std::string& name, const std::string& line_body, const std::string& follower_body,
                          const Vector3d& at_m) {
  const Isometry3d line_from_ground = GroundFrom(line_body).inverse();
  const pugi::xml_node pin = AddNamed(constraints_, "PointOnLineConstraint", name);
  AddText(pin, "isEnforced", BoolText(true));
  AddText(pin, "socket_line_body", PathOf(line_body));
  AddText(pin, "socket_follower_body", PathOf(follower_body));
  AddText(pin, "line_direction_vec", TextOf(line_from_ground.linear() * Vector3d::UnitZ()));
  AddText(pin, "point_on_line", TextOf(line_from_ground * at_m));
  AddText(pin, "point_on_follower", TextOf(GroundFrom(follower_body).inverse() * at_m));
}

void OsimDocument::AddBushing(const OsimBushing& bushing) {
  const pugi::xml_node node = AddNamed(forces_, "BushingForce", bushing.name);
  AddText(node, "appliesForce", BoolText(true));
  const std::string on_segment = bushing.name + "_on_" + bushing.segment,
                    on_link = bushing.name + "_on_" + bushing.link;
  AddText(node, "socket_frame1", on_segment);
  AddText(node, "socket_frame2", on_link);
  const pugi::xml_node frames = Add(node, "frames");
  AddOffsetFrame(frames, on_segment, bushing.segment, bushing.on_segment);
  AddOffsetFrame(frames, on_link, bushing.link, bushing.on_link);
  AddText(node, "rotational_stiffness", TextOf(bushing.turn_nm));
  AddText(node, "translational_stiffness", TextOf(bushing.stiffness_n_m));
  AddText(node, "rotational_damping", TextOf(bushing.turn_damping_nm_s));
  AddText(node, "translational_damping", TextOf(bushing.damping_n_s_m));
}

void OsimDocument::AddActuator(const std::string& name, const std::string& coordinate) {
  const pugi::xml_node node = AddNamed(forces_, "CoordinateActuator", name);
  AddText(node, "appliesForce", BoolText(true));
  AddText(node, "min_control", "-Inf");
  AddText(node, "max_control", "Inf");
  AddText(node, "coordinate", coordinate);
  AddText(node, "optimal_force", "1");
}

void OsimDocument::Write(const std::filesystem::path& path) const {
  WriteXml(path, document_);
}

}  // namespace lake::model
