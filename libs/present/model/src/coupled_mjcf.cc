#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/model/coupled_model.h"
#include "mjcf_parts.h"

namespace lake::model {
namespace {

using Eigen::Vector2d;

// Pads and joints of persons have no mass or damping of their own; these keep a simulation calm and leave forces at
// rest as they are.
constexpr double kPad_kg = 0.02, kPadInertia_kg_m2 = 1e-4, kPadDamping_n_s_m = 200, kPadDamping_nm_s = 2;
constexpr double kPersonServo_nm = 2e5, kPersonDamping_nm_s = 4e3;  // per rad: a person who keeps to the motion
constexpr double kActuator_n_m = 5e6;                               // an actuator that keeps to its program
constexpr double kBeside_m = 0.06;                                  // from the leg's middle to the plates
constexpr int kKeyframes = 21;

std::string DegreesText(double degrees) {
  return NumberText(degrees);
}

// Of a turn forward about y.
std::string TurnText(double forward_rad) {
  return TextOf({std::cos(forward_rad / 2), 0, std::sin(forward_rad / 2), 0});
}

void AddMass(pugi::xml_node body, const loads::SegmentInertia& segment, const Eigen::Vector3d& centre_m) {
  const double inertia = segment.mass_kg * segment.gyration_m * segment.gyration_m;
  constexpr double kAbout = 0.3;  // about the long axis, which a planar motion does not feel
  Add(body, "inertial",
      {{"pos", TextOf(centre_m)},
       {"mass", NumberText(segment.mass_kg)},
       {"diaginertia", TextOf({inertia, inertia, kAbout * inertia})}});
}

void AddLimb(pugi::xml_node body, double length_m, double radius_m) {
  Add(body, "geom",
      {{"type", "capsule"},
       {"fromto", TextOf({0, 0, 0, 0, 0, length_m})},
       {"size", NumberText(radius_m)},
       {"mass", "0"},
       {"rgba", "0.85 0.72 0.6 0.5"}});
}

pugi::xml_node AddSegment(pugi::xml_node parent, const char* name, double up_m, double turn_rad) {
  return Add(parent, "body", {{"name", name}, {"pos", TextOf({0, 0, up_m})}, {"quat", TurnText(turn_rad)}});
}

void AddPersonsJoint(pugi::xml_node body, const char* name, const char* axis, double reference_deg) {
  Add(body, "joint",
      {{"name", name},
       {"type", "hinge"},
       {"axis", axis},
       {"ref", DegreesText(reference_deg)},
       {"damping", NumberText(kPersonDamping_nm_s)}});
}

struct Pad {
  std::string name;
  const char* link;  // what it is welded to
};

// A cuff's pad on its segment, `up_m` from the segment's origin, moved by the slip that it has in the file's pose.
Pad AddPad(pugi::xml_node segment, const std::string& name, const char* link, double up_m, const Vector2d& slip_mm,
           const cuffs::Cuff& cuff, double stiffness_n_mm) {
  const Vector2d slip_m = kMetresPerMillimetre * slip_mm;
  const pugi::xml_node pad =
      Add(segment, "body", {{"name", name}, {"pos", TextOf({slip_m.x(), 0, up_m + slip_m.y()})}});
  Add(pad, "inertial",
      {{"pos", "0 0 0"},
       {"mass", NumberText(kPad_kg)},
       {"diaginertia", TextOf({kPadInertia_kg_m2, kPadInertia_kg_m2, kPadInertia_kg_m2})}});
  for (const auto& [suffix, axis, reference_m] :
       {std::tuple("_x", "1 0 0", slip_m.x()), std::tuple("_z", "0 0 1", slip_m.y())})
    Add(pad, "joint",
        {{"name", name + suffix},
         {"type", "slide"},
         {"axis", axis},
         {"ref", NumberText(reference_m)},
         {"stiffness", NumberText(stiffness_n_mm / kMetresPerMillimetre)},
         {"damping", NumberText(kPadDamping_n_s_m)}});
  const double turn_nm = stiffness_n_mm * cuff.length_mm * cuff.length_mm / 12 * kMetresPerMillimetre;
  Add(pad, "joint",
      {{"name", name + "_turn"},
       {"type", "hinge"},
       {"axis", "0 1 0"},
       {"stiffness", NumberText(turn_nm)},
       {"damping", NumberText(kPadDamping_nm_s)}});
  return {name, link};
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

double HipDeg(const WornSample& sample) {
  return sample.trunk_deg - (sample.shank_deg - sample.knee_deg);
}

// Where the trunk's centre of mass is in its own frame, m, mean over the rise.
Eigen::Vector3d TrunkCentre(const loads::BodyPath& body) {
  Vector2d sum = Vector2d::Zero();
  for (const loads::TrunkSample& sample : body.trunk) sum += Eigen::Rotation2Dd(sample.tilt_rad) * sample.centre_m;
  sum /= static_cast<double>(body.trunk.size());
  return {sum.x(), 0, sum.y()};
}

class CoupledModel {
 public:
  CoupledModel(const parts::Mechanism& mechanism, const Wearer& wearer)
      : mechanism_(mechanism),
        wearer_(wearer),
        bodies_(RigidBodiesOf(mechanism)),
        knee_deg_(DegreesFromRadians(bodies_.reference.theta_rad)) {}

  void Write(const std::filesystem::path& path) {
    pugi::xml_document document;
    const pugi::xml_node model = Add(document, "mujoco", {{"model", "worn_knee_exoskeleton"}});
    AddComment(model, MadeBy());
    AddOptions(model);
    AddMeshes(model, bodies_);
    AddTree(model);
    const pugi::xml_node equality = Add(model, "equality");
    AddLoops(equality, mechanism_.links);
    for (const Pad& pad : pads_) Add(equality, "weld", {{"body1", pad.name}, {"body2", pad.link}});
    AddServos(Add(model, "actuator"));
    AddSensors(Add(model, "sensor"));
    AddKeyframes(Add(model, "keyframe"));
    WriteXml(path, document);
  }

 private:
  // The file's pose: the shank upright, the trunk too, the knee as the mechanism's reference has it.
  void AddTree(pugi::xml_node model) {
    const loads::LegBody& body = wearer_.body.body;
    const double shank_m = kMetresPerMillimetre * wearer_.shank_mm, thigh_m = kMetresPerMillimetre * wearer_.thigh_mm;
    const pugi::xml_node world = Add(model, "worldbody");
    Add(world, "light", {{"pos", "0 -1 2"}, {"dir", "0 1 -1"}});
    const pugi::xml_node foot = Add(world, "body", {{"name", "foot"}, {"pos", "0 0 0"}});
    AddMass(foot, body.foot, {body.foot.centre_m, 0, -body.ankle_height_m / 2});
    Add(foot, "geom",
        {{"type", "box"},
         {"pos", TextOf({(body.sole.toe_m - body.sole.heel_m) / 2, 0, -body.ankle_height_m / 2})},
         {"size", TextOf({body.sole.Length() / 2, 0.04, body.ankle_height_m / 2})},
         {"mass", "0"},
         {"rgba", "0.85 0.72 0.6 0.5"}});
    const pugi::xml_node shank = AddSegment(foot, "shank", 0, 0);
    AddPersonsJoint(shank, "ankle", "0 1 0", 0);
    AddMass(shank, body.shank, {0, 0, shank_m - body.shank.centre_m});
    AddLimb(shank, shank_m, 0.045);
    const double knee_rad = RadiansFromDegrees(knee_deg_);
    const pugi::xml_node thigh = AddSegment(shank, "thigh", shank_m, -knee_rad);
    AddPersonsJoint(thigh, "human_knee", "0 -1 0", knee_deg_);
    AddMass(thigh, body.thigh, {0, 0, thigh_m - body.thigh.centre_m});
    AddLimb(thigh, thigh_m, 0.06);
    const pugi::xml_node trunk = AddSegment(thigh, "trunk", thigh_m, knee_rad);
    AddPersonsJoint(trunk, "hip", "0 1 0", knee_deg_);
    AddMass(trunk, body.trunk, TrunkCentre(wearer_.body));
    AddLimb(trunk, 2 * body.trunk.centre_m, 0.1);
    AddPads(shank, thigh, shank_m);
    const Vector2d hinge_m = kMetresPerMillimetre * wearer_.hinge_mm;
    AddMechanism(AddFrame(world, bodies_, {hinge_m.x(), kBeside_m, shank_m + hinge_m.y()}, -knee_rad), bodies_,
                 mechanism_.range.stroke);
  }

  // On the shank the cuffs are free of stress in this pose; those of the thigh have all of the misfit.
  void AddPads(pugi::xml_node shank, pugi::xml_node thigh, double shank_m) {
    const Vector2d on_thigh_mm = cuffs::MisfitOf(Vector2d::Zero(), wearer_.hinge_mm, wearer_.rise.back().knee_deg, 0);
    const Vector2d misfit_mm = cuffs::MisfitOf(wearer_.hinge_mm, on_thigh_mm, -knee_deg_, 0);
    const Vector2d slip_mm = -cuffs::MisfitOf(Vector2d::Zero(), misfit_mm, knee_deg_, 0);  // thigh's axes
    const double stiffness = std::sqrt(wearer_.cuffs.softest_n_mm * wearer_.cuffs.stiffest_n_mm);
    int number = 0;
    for (const cuffs::Cuff& cuff : wearer_.cuffs.thigh)
      pads_.push_back(AddPad(thigh, fmt::format("thigh_cuff_{}", ++number), "thigh_plate",
                             kMetresPerMillimetre * cuff.from_knee_mm, slip_mm, cuff, stiffness));
    number = 0;
    for (const cuffs::Cuff& cuff : wearer_.cuffs.shank)
      pads_.push_back(AddPad(shank, fmt::format("shank_cuff_{}", ++number), "shank_link",
                             shank_m - kMetresPerMillimetre * cuff.from_knee_mm, Vector2d::Zero(), cuff, stiffness));
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
    for (const Pad& pad : pads_)
      for (const char* axis : {"_x", "_z", "_turn"})
        Add(sensors, "jointpos", {{"name", pad.name + axis + "_slip"}, {"joint", pad.name + axis}});
  }

  // Controls are in rad and m, whatever the compiler's angle.
  void AddKeyframes(pugi::xml_node keyframes) const {
    const std::size_t last = wearer_.rise.size() - 1;
    for (int k = 0; k < kKeyframes; ++k) {
      const std::size_t i = last * static_cast<std::size_t>(k) / (kKeyframes - 1);
      const WornSample& sample = wearer_.rise[i];
      Add(keyframes, "key",
          {{"name", fmt::format("{}_percent", 100 * i / last)},
           {"time", NumberText(sample.time_s)},
           {"ctrl", TextOf({RadiansFromDegrees(sample.shank_deg), RadiansFromDegrees(sample.knee_deg),
                            RadiansFromDegrees(HipDeg(sample)), kMetresPerMillimetre * sample.stroke_mm})}});
    }
  }

  const parts::Mechanism& mechanism_;
  const Wearer& wearer_;
  const RigidBodies bodies_;
  const double knee_deg_;
  std::vector<Pad> pads_;
};

}  // namespace

void WriteCoupledMjcf(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Wearer& wearer) {
  const cuffs::CuffOptions& cuffs = wearer.cuffs;
  cuffs::LoadOnLeg({}, cuffs, {cuffs.softest_n_mm, cuffs.stiffest_n_mm});  // refuses what is no cuff
  CoupledModel(mechanism, wearer).Write(path);
}

void WriteCourse(const std::filesystem::path& path, const Wearer& wearer) {
  CsvWriter csv({"time_s", "ankle_deg", "human_knee_deg", "hip_deg", "stroke_mm"});
  for (const WornSample& sample : wearer.rise)
    csv.Add(sample.time_s)
        .Add(sample.shank_deg)
        .Add(sample.knee_deg)
        .Add(HipDeg(sample))
        .Add(sample.stroke_mm)
        .EndRow();
  csv.Write(path);
}

}  // namespace lake::model
