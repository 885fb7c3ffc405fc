#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/model/coupled_model.h"
#include "mjcf_parts.h"
#include "worn_body.h"

namespace lake::model {
namespace {

// A pad's own, which a simulation asks for.
constexpr double kPad_kg = 0.02, kPadInertia_kg_m2 = 1e-4;
constexpr double kPersonServo_nm = 2e5, kPersonDamping_nm_s = 4e3;  // per rad: a person who keeps to the motion
constexpr double kActuator_n_m = 5e6;                               // an actuator that keeps to its program
constexpr int kKeyframes = 21;

std::string DegreesText(double degrees) {
  return NumberText(degrees);
}

// Of a turn forward about y.
std::string TurnText(double forward_rad) {
  return TextOf({std::cos(forward_rad / 2), 0, std::sin(forward_rad / 2), 0});
}

void AddMass(pugi::xml_node body, const WornSegment& segment) {
  Add(body, "inertial",
      {{"pos", TextOf({segment.centre_m.x(), 0, segment.centre_m.y()})},
       {"mass", NumberText(segment.mass_kg)},
       {"diaginertia", TextOf({segment.inertia_kg_m2, segment.inertia_kg_m2, segment.LongInertia()})}});
}

void AddLimb(pugi::xml_node body, const WornSegment& segment) {
  Add(body, "geom",
      {{"type", "capsule"},
       {"fromto", TextOf({0, 0, 0, 0, 0, segment.length_m})},
       {"size", NumberText(segment.radius_m)},
       {"mass", "0"},
       {"rgba", "0.85 0.72 0.6 0.5"}});
}

// `up_m`: of its joint, on the parent.
pugi::xml_node AddSegment(pugi::xml_node parent, const WornSegment& segment, double up_m, double turn_rad) {
  return Add(parent, "body", {{"name", segment.name}, {"pos", TextOf({0, 0, up_m})}, {"quat", TurnText(turn_rad)}});
}

void AddPersonsJoint(pugi::xml_node body, const char* name, const char* axis, double reference_deg) {
  Add(body, "joint",
      {{"name", name},
       {"type", "hinge"},
       {"axis", axis},
       {"ref", DegreesText(reference_deg)},
       {"damping", NumberText(kPersonDamping_nm_s)}});
}

// A cuff's pad on its segment, moved by the slip that it has in the file's pose.
void AddPad(pugi::xml_node segment, const WornCuff& cuff) {
  const pugi::xml_node pad =
      Add(segment, "body", {{"name", cuff.name}, {"pos", TextOf({cuff.slip_m.x(), 0, cuff.up_m + cuff.slip_m.y()})}});
  Add(pad, "inertial",
      {{"pos", "0 0 0"},
       {"mass", NumberText(kPad_kg)},
       {"diaginertia", TextOf({kPadInertia_kg_m2, kPadInertia_kg_m2, kPadInertia_kg_m2})}});
  for (const auto& [suffix, axis, reference_m] :
       {std::tuple("_x", "1 0 0", cuff.slip_m.x()), std::tuple("_z", "0 0 1", cuff.slip_m.y())})
    Add(pad, "joint",
        {{"name", cuff.name + suffix},
         {"type", "slide"},
         {"axis", axis},
         {"ref", NumberText(reference_m)},
         {"stiffness", NumberText(cuff.stiffness_n_m)},
         {"damping", NumberText(kCuffDamping_n_s_m)}});
  Add(pad, "joint",
      {{"name", cuff.name + "_turn"},
       {"type", "hinge"},
       {"axis", "0 1 0"},
       {"stiffness", NumberText(cuff.turn_nm)},
       {"damping", NumberText(kCuffDamping_nm_s)}});
}

// The exoskeleton's thigh plate: its hinge keeps its place on the shank in the file's pose, and it moves freely in the
// plane.
pugi::xml_node AddFrame(pugi::xml_node world, const RigidBodies& bodies, const Eigen::Vector3d& hinge_m,
                        double thigh_rad) {
  pugi::xml_node frame = AddBody(world, bodies[BodyIndex::kThighPlate], Eigen::Isometry3d::Identity());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(thigh_rad, Eigen::Vector3d::UnitY()) * ModelFromThigh());
  frame.attribute("quat") = TextOf({turn.w(), turn.x(), turn.y(), turn.z()}).c_str();
  frame.attribute("pos") = TextOf(hinge_m).c_str();
  for (const auto& [name, type, axis] : {std::tuple("exo_x", "slide", "1 0 0"), std::tuple("exo_y", "slide", "0 1 0"),
                                         std::tuple("exo_turn", "hinge", "0 0 1")})
    Add(frame, "joint", {{"name", name}, {"type", type}, {"axis", axis}});
  return frame;
}

class CoupledModel {
 public:
  CoupledModel(const parts::Mechanism& mechanism, const Subject& subject)
      : mechanism_(mechanism),
        subject_(subject),
        worn_(WornBodyOf(mechanism, subject)),
        knee_deg_(DegreesFromRadians(worn_.knee_rad)) {}

  void Write(const std::filesystem::path& path) {
    pugi::xml_document document;
    const pugi::xml_node model = Add(document, "mujoco", {{"model", "worn_knee_exoskeleton"}});
    AddComment(model, MadeBy());
    AddOptions(model);
    AddMeshes(model, worn_.mechanism);
    AddTree(model);
    const pugi::xml_node equality = Add(model, "equality");
    AddLoops(equality, mechanism_.links);
    for (const WornCuff& cuff : worn_.cuffs) Add(equality, "weld", {{"body1", cuff.name}, {"body2", cuff.Link()}});
    AddServos(Add(model, "actuator"));
    AddSensors(Add(model, "sensor"));
    AddKeyframes(Add(model, "keyframe"));
    WriteXml(path, document);
  }

 private:
  void AddTree(pugi::xml_node model) {
    const loads::LegBody& body = subject_.body.body;
    const pugi::xml_node world = Add(model, "worldbody");
    Add(world, "light", {{"pos", "0 -1 2"}, {"dir", "0 1 -1"}});
    const pugi::xml_node foot = Add(world, "body", {{"name", "foot"}, {"pos", "0 0 0"}});
    AddMass(foot, worn_.foot);
    Add(foot, "geom",
        {{"type", "box"},
         {"pos", TextOf({(body.sole.toe_m - body.sole.heel_m) / 2, 0, -body.ankle_height_m / 2})},
         {"size", TextOf({body.sole.Length() / 2, 0.04, body.ankle_height_m / 2})},
         {"mass", "0"},
         {"rgba", "0.85 0.72 0.6 0.5"}});
    const pugi::xml_node shank = AddSegment(foot, worn_.shank, 0, 0);
    AddPersonsJoint(shank, "ankle", "0 1 0", 0);
    AddMass(shank, worn_.shank);
    AddLimb(shank, worn_.shank);
    const pugi::xml_node thigh = AddSegment(shank, worn_.thigh, worn_.shank.length_m, -worn_.knee_rad);
    AddPersonsJoint(thigh, "human_knee", "0 -1 0", knee_deg_);
    AddMass(thigh, worn_.thigh);
    AddLimb(thigh, worn_.thigh);
    const pugi::xml_node trunk = AddSegment(thigh, worn_.trunk, worn_.thigh.length_m, worn_.knee_rad);
    AddPersonsJoint(trunk, "hip", "0 1 0", knee_deg_);
    AddMass(trunk, worn_.trunk);
    AddLimb(trunk, worn_.trunk);
    for (const WornCuff& cuff : worn_.cuffs) AddPad(cuff.on_thigh ? thigh : shank, cuff);
    AddMechanism(AddFrame(world, worn_.mechanism, {worn_.hinge_m.x(), kBeside_m, worn_.hinge_m.y()}, -worn_.knee_rad),
                 worn_.mechanism, mechanism_.range.stroke);
  }

  void AddServos(pugi::xml_node actuators) const {
    for (const char* joint : {"ankle", "human_knee", "hip"})
      Add(actuators, "position", {{"name", joint}, {"joint", joint}, {"kp", NumberText(kPersonServo_nm)}});
    AddActuator(actuators, mechanism_.range.stroke, kActuator_n_m);
  }

  void AddSensors(pugi::xml_node sensors) const {
    for (const char* joint : {"knee", "human_knee", "stroke"})
      Add(sensors, "jointpos", {{"name", fmt::format("{}_position", joint)}, {"joint", joint}});
    for (const char* servo : {"human_knee", "actuator"})
      Add(sensors, "actuatorfrc", {{"name", fmt::format("{}_force", servo)}, {"actuator", servo}});
    for (const WornCuff& cuff : worn_.cuffs)
      for (const char* axis : {"_x", "_z", "_turn"})
        Add(sensors, "jointpos", {{"name", cuff.name + axis + "_slip"}, {"joint", cuff.name + axis}});
  }

  // Controls are in rad and m, whatever the compiler's angle.
  void AddKeyframes(pugi::xml_node keyframes) const {
    const std::size_t last = subject_.rise.size() - 1;
    for (int k = 0; k < kKeyframes; ++k) {
      const std::size_t i = last * static_cast<std::size_t>(k) / (kKeyframes - 1);
      const WornSample& sample = subject_.rise[i];
      Add(keyframes, "key",
          {{"name", fmt::format("{}_percent", 100 * i / last)},
           {"time", NumberText(sample.time_s)},
           {"ctrl", TextOf({RadiansFromDegrees(sample.shank_deg), RadiansFromDegrees(sample.knee_deg),
                            RadiansFromDegrees(HipDeg(sample)), kMetresPerMillimetre * sample.stroke_mm})}});
    }
  }

  const parts::Mechanism& mechanism_;
  const Subject& subject_;
  const WornBody worn_;
  const double knee_deg_;
};

}  // namespace

void WriteCoupledMjcf(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject) {
  CoupledModel(mechanism, subject).Write(path);
}

void WriteCourse(const std::filesystem::path& path, const Subject& subject) {
  CsvWriter csv({"time_s", "ankle_deg", "human_knee_deg", "hip_deg", "stroke_mm"});
  for (const WornSample& sample : subject.rise)
    csv.AddRow(sample.time_s, sample.shank_deg, sample.knee_deg, HipDeg(sample), sample.stroke_mm);
  csv.Write(path);
}

}  // namespace lake::model
