#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/model/simulator_model.h"
#include "mjcf_parts.h"

namespace lake::model {
namespace {

using Eigen::Vector3d;

// Both sides of a plate: MuJoCo takes the hull.
std::string MeshVertices(const RigidBody& body) {
  std::vector<double> numbers;
  for (const double z : {body.low_m, body.high_m})
    for (const Eigen::Vector2d& point : body.outline_m) numbers.insert(numbers.end(), {point.x(), point.y(), z});
  return TextOf(numbers);
}

pugi::xml_node AddJoint(pugi::xml_node body, const char* name, double reference_deg) {
  return Add(body, "joint", {{"name", name}, {"type", "hinge"}, {"axis", "0 0 1"}, {"ref", NumberText(reference_deg)}});
}

}  // namespace

// A body in its parent, with inertia and shape. Both turn about z alone.
pugi::xml_node AddBody(pugi::xml_node parent, const RigidBody& body, const Eigen::Isometry3d& thigh_from_parent) {
  const Eigen::Isometry3d parent_from_body = thigh_from_parent.inverse() * body.thigh_from_body;
  const double turn = std::atan2(parent_from_body(1, 0), parent_from_body(0, 0));
  pugi::xml_node node = Add(parent, "body",
                            {{"name", body.name},
                             {"pos", TextOf(parent_from_body.translation())},
                             {"quat", TextOf({std::cos(turn / 2), 0, 0, std::sin(turn / 2)})}});
  const Eigen::Matrix3d& inertia = body.inertia_kg_m2;
  Add(node, "inertial",
      {{"pos", TextOf(body.centre_m)},
       {"mass", NumberText(body.mass_kg)},
       {"fullinertia", TextOf({inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), 0, 0})}});
  if (body.IsCylinder())
    Add(node, "geom",
        {{"type", "cylinder"},
         {"size", NumberText(body.cylinder_radius_m)},
         {"fromto", TextOf({body.cylinder_from_m, 0, body.centre_m.z(), body.cylinder_to_m, 0, body.centre_m.z()})}});
  else
    Add(node, "geom", {{"type", "mesh"}, {"mesh", body.name}});
  return node;
}

void AddOptions(pugi::xml_node model) {
  Add(model, "compiler", {{"angle", "degree"}, {"inertiafromgeom", "false"}});
  // Loops are as stiff as the time step allows: at rest a loop yields by (1 - d) / d x A F t^2, with A its inverse mass
  // (some 20 / kg), F its force, t and d below: 0.002 mm at 1 kN.
  Add(model, "option", {{"timestep", "0.0005"}, {"iterations", "200"}, {"tolerance", "1e-12"}});
  const pugi::xml_node defaults = Add(model, "default");
  Add(defaults, "geom", {{"contype", "0"}, {"conaffinity", "0"}, {"rgba", "0.7 0.72 0.75 1"}});
  Add(defaults, "equality", {{"solref", "0.001 1"}, {"solimp", "0.9999 0.9999 0.001"}});
}

void AddMechanism(pugi::xml_node frame, const RigidBodies& bodies, const linkage::StrokeRange& stroke) {
  const pugi::xml_node shank =
      AddBody(frame, bodies[BodyIndex::kShankLink], bodies[BodyIndex::kThighPlate].thigh_from_body);
  AddJoint(shank, "knee", DegreesFromRadians(bodies.reference.theta_rad));
  const RigidBody& slewing_bar = bodies[BodyIndex::kSlewingBar];
  const pugi::xml_node bar = AddBody(frame, slewing_bar, bodies[BodyIndex::kThighPlate].thigh_from_body);
  AddJoint(bar, "thigh_pin", 0);
  AddJoint(AddBody(bar, bodies[BodyIndex::kCoupler], slewing_bar.thigh_from_body), "tip", 0);
  const RigidBody& actuator = bodies[BodyIndex::kActuatorBody];
  const pugi::xml_node cylinder = AddBody(frame, actuator, bodies[BodyIndex::kThighPlate].thigh_from_body);
  AddJoint(cylinder, "mount", 0);
  AddComment(cylinder,
             "Not of the design: damping and armature, 20 kg of motor and screw as the rod feels them, keep the servo "
             "calm; they leave forces at rest as they are. Put your actuator's own here.");
  const pugi::xml_node rod = AddBody(cylinder, bodies[BodyIndex::kActuatorRod], actuator.thigh_from_body);
  Add(rod, "joint",
      {{"name", "stroke"},
       {"type", "slide"},
       {"axis", "1 0 0"},
       {"ref", NumberText(kMetresPerMillimetre * bodies.reference.stroke_mm)},
       {"damping", "3000"},
       {"armature", "20"},
       {"limited", "true"},
       {"range", TextOf({kMetresPerMillimetre * stroke.lower_mm, kMetresPerMillimetre * stroke.upper_mm})}});
}

void AddLoops(pugi::xml_node equality, const linkage::Links& links) {
  const double coupler_m = kMetresPerMillimetre * links.l1;
  Add(equality, "connect",
      {{"name", "shank_pin"}, {"body1", "coupler"}, {"body2", "shank_link"}, {"anchor", TextOf({coupler_m, 0, 0})}});
  Add(equality, "connect",
      {{"name", "rod_end"}, {"body1", "actuator_rod"}, {"body2", "slewing_bar"}, {"anchor", "0 0 0"}});
}

void AddMeshes(pugi::xml_node model, const RigidBodies& bodies) {
  const pugi::xml_node asset = Add(model, "asset");
  for (const RigidBody& body : bodies.bodies)
    if (!body.IsCylinder()) Add(asset, "mesh", {{"name", body.name}, {"vertex", MeshVertices(body)}});
}

void AddActuator(pugi::xml_node actuators, const linkage::StrokeRange& stroke, double stiffness_n_m) {
  Add(actuators, "position",
      {{"name", "actuator"},
       {"joint", "stroke"},
       {"kp", NumberText(stiffness_n_m)},
       {"ctrllimited", "true"},
       {"ctrlrange", TextOf({kMetresPerMillimetre * stroke.lower_mm, kMetresPerMillimetre * stroke.upper_mm})}});
}

namespace {

void AddTree(pugi::xml_node model, const RigidBodies& bodies, const linkage::StrokeRange& stroke) {
  const pugi::xml_node world = Add(model, "worldbody");
  Add(world, "light", {{"pos", "0 -1 1"}, {"dir", "0 1 -1"}});
  AddComment(world,
             "The thigh frame: x posterior, y up the thigh, z along the pins. Give it joints, or weld it to a leg.");
  pugi::xml_node frame = AddBody(world, bodies[BodyIndex::kThighPlate], Eigen::Isometry3d::Identity());
  const Eigen::Quaterniond turn(ModelFromThigh());
  frame.attribute("quat") = TextOf({turn.w(), turn.x(), turn.y(), turn.z()}).c_str();
  AddMechanism(frame, bodies, stroke);
}

}  // namespace

void WriteMjcf(const std::filesystem::path& path, const parts::Mechanism& mechanism) {
  const RigidBodies bodies = RigidBodiesOf(mechanism);
  pugi::xml_document document;
  const pugi::xml_node model = Add(document, "mujoco", {{"model", "knee_exoskeleton"}});
  AddComment(model, MadeBy());
  AddOptions(model);
  AddMeshes(model, bodies);
  const linkage::StrokeRange& stroke = mechanism.range.stroke;
  AddTree(model, bodies, stroke);

  AddLoops(Add(model, "equality"), mechanism.links);
  constexpr double kServo_n_m = 5e5;
  AddActuator(Add(model, "actuator"), stroke, kServo_n_m);
  const pugi::xml_node sensor = Add(model, "sensor");
  Add(sensor, "jointpos", {{"name", "knee_angle"}, {"joint", "knee"}});
  Add(sensor, "jointpos", {{"name", "stroke_length"}, {"joint", "stroke"}});
  Add(sensor, "actuatorfrc", {{"name", "actuator_force"}, {"actuator", "actuator"}});
  Add(Add(model, "keyframe"), "key",
      {{"name", "reference"}, {"ctrl", NumberText(kMetresPerMillimetre * bodies.reference.stroke_mm)}});
  WriteXml(path, document);
}

}  // namespace lake::model
