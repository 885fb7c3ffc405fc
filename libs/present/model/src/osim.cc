#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/cuffs/cuff_course.h"
#include "lake/exchange/mot.h"
#include "lake/model/coupled_model.h"
#include "lake/model/simulator_model.h"
#include "osim_document.h"
#include "worn_body.h"

namespace lake::model {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;
using enum BodyIndex;

// A frame in the sagittal plane, `z_m` to the right.
Isometry3d InPlane(const Vector2d& at_m, double lean_rad, double z_m = 0) {
  Isometry3d frame(Eigen::Translation3d(at_m.x(), at_m.y(), z_m));
  frame.rotate(Eigen::AngleAxisd(-lean_rad, Vector3d::UnitZ()));
  return frame;
}

// Turned over, z to the left: a turn forward is positive about it. The thigh plate's frame is so against the thigh's.
Isometry3d TurnedOver(Isometry3d frame) {
  frame.linear() = frame.linear() * Vector3d(-1, 1, -1).asDiagonal();
  return frame;
}

// The plate and all that moves on it, but not what holds the plate.
void AddMechanism(OsimDocument& document, const RigidBodies& bodies, const linkage::StrokeRange& stroke,
                  const Isometry3d& ground_from_plate, const OsimCoordinate& driven) {
  const auto at = [&](BodyIndex index) -> Isometry3d { return ground_from_plate * bodies[index].thigh_from_body; };
  for (const RigidBody& body : bodies.bodies) {
    document.AddBody({body.name, body.mass_kg, body.centre_m, body.inertia_kg_m2,
                      Isometry3d(ground_from_plate * body.thigh_from_body)});
    if (body.IsCylinder()) {
      document.AddCylinder(body.name, {body.cylinder_from_m, 0, body.centre_m.z()},
                           {body.cylinder_to_m, 0, body.centre_m.z()}, body.cylinder_radius_m);
      continue;
    }
    Eigen::AlignedBox3d box;
    for (const Vector2d& point : body.outline_m) {
      box.extend(Vector3d(point.x(), point.y(), body.low_m));
      box.extend(Vector3d(point.x(), point.y(), body.high_m));
    }
    document.AddBrick(body.name, box.center(), box.sizes() / 2);
  }
  const auto pin = [&](const char* name, BodyIndex parent, BodyIndex child, double value_rad) {
    document.AddJoint(OsimJoint::kPin, name, bodies[parent].name, bodies[child].name, at(child),
                      {{.name = name, .value = value_rad, .follows_loops = true}});
  };
  pin("knee", kThighPlate, kShankLink, bodies.reference.theta_rad);
  pin("thigh_pin", kThighPlate, kSlewingBar, 0);
  pin("tip", kSlewingBar, kCoupler, 0);
  pin("mount", kThighPlate, kActuatorBody, 0);
  OsimCoordinate length = driven;
  length.range = {kMetresPerMillimetre * stroke.lower_mm, kMetresPerMillimetre * stroke.upper_mm};
  document.AddJoint(OsimJoint::kSlider, "stroke", bodies[kActuatorBody].name, bodies[kActuatorRod].name,
                    at(kActuatorRod), {length});
  const linkage::Pose& pose = bodies.reference;
  const auto pinned = [&](const Vector2d& in_thigh_mm) -> Vector3d {
    return ground_from_plate * (kMetresPerMillimetre * Vector3d(in_thigh_mm.x(), in_thigh_mm.y(), 0));
  };
  document.AddPin("shank_pin", bodies[kShankLink].name, bodies[kCoupler].name, pinned(pose.shank_pin));
  document.AddPin("rod_end", bodies[kSlewingBar].name, bodies[kActuatorRod].name, pinned(pose.tip));
  document.AddActuator("actuator", "stroke");
}

OsimCoordinate StrokeAt(const RigidBodies& bodies) {
  return {.name = "stroke", .value = kMetresPerMillimetre * bodies.reference.stroke_mm, .is_length = true};
}

// The person's segments and joints, and the bushings of the cuffs.
class CoupledOsim {
 public:
  CoupledOsim(const parts::Mechanism& mechanism, const Subject& subject)
      : mechanism_(mechanism),
        subject_(subject),
        worn_(WornBodyOf(mechanism, subject)),
        document_("worn_knee_exoskeleton") {}

  void Write(const std::filesystem::path& path) {
    AddPerson();
    const Isometry3d plate = TurnedOver(InPlane(worn_.hinge_m, worn_.thigh.lean_rad, -kBeside_m));
    OsimCoordinate stroke = StrokeAt(worn_.mechanism);
    stroke.prescribed = CourseOf([](const WornSample& s) { return kMetresPerMillimetre * s.stroke_mm; });
    AddMechanism(document_, worn_.mechanism, mechanism_.range.stroke, plate, stroke);
    document_.AddJoint(OsimJoint::kPlanar, "exoskeleton", "ground", worn_.mechanism[kThighPlate].name,
                       TurnedOver(plate),
                       {{.name = "exo_turn", .value = -worn_.thigh.lean_rad},
                        {.name = "exo_x", .value = worn_.hinge_m.x(), .is_length = true},
                        {.name = "exo_y", .value = worn_.hinge_m.y(), .is_length = true}});
    for (const WornCuff& cuff : worn_.cuffs) AddCuff(cuff);
    document_.Write(path);
  }

 private:
  static Isometry3d FrameOf(const WornSegment& segment) { return InPlane(segment.at_m, segment.lean_rad); }

  template <typename Value>
  OsimCourse CourseOf(Value value) const {
    OsimCourse course;
    course.time_s.reserve(subject_.rise.size());
    course.values.reserve(subject_.rise.size());
    for (const WornSample& sample : subject_.rise) {
      course.time_s.push_back(sample.time_s);
      course.values.push_back(value(sample));
    }
    return course;
  }

  void AddSegment(const WornSegment& segment) {
    const double across = segment.inertia_kg_m2;
    document_.AddBody({segment.name, segment.mass_kg, Vector3d(segment.centre_m.x(), segment.centre_m.y(), 0),
                       Vector3d(across, segment.LongInertia(), across).asDiagonal(), FrameOf(segment)});
    if (segment.length_m > 0)
      document_.AddCylinder(segment.name, Vector3d::Zero(), {0, segment.length_m, 0}, segment.radius_m);
  }

  // A joint of the person, whose angle is positive forward, or backward as a knee bends.
  template <typename Degrees>
  void AddPersonsJoint(const char* name, const WornSegment& parent, const WornSegment& child, double value_rad,
                       bool forward, Degrees degrees) {
    document_.AddJoint(OsimJoint::kPin, name, parent.name, child.name,
                       forward ? TurnedOver(FrameOf(child)) : FrameOf(child),
                       {{.name = name, .value = value_rad, .prescribed = CourseOf([&](const WornSample& s) {
                                                             return RadiansFromDegrees(degrees(s));
                                                           })}});
    document_.AddActuator(std::string(name) + "_moment", name);
  }

  void AddPerson() {
    AddSegment(worn_.foot);
    const loads::LegBody& body = subject_.body.body;
    constexpr double kHalfWidth_m = 0.04;  // to be shown
    document_.AddBrick(worn_.foot.name, {(body.sole.toe_m - body.sole.heel_m) / 2, -body.ankle_height_m / 2, 0},
                       {body.sole.Length() / 2, body.ankle_height_m / 2, kHalfWidth_m});
    AddSegment(worn_.shank);
    AddSegment(worn_.thigh);
    AddSegment(worn_.trunk);
    document_.AddJoint(OsimJoint::kWeld, "floor", "ground", worn_.foot.name, FrameOf(worn_.foot), {});
    AddPersonsJoint("ankle", worn_.foot, worn_.shank, 0, true, [](const WornSample& s) { return s.shank_deg; });
    AddPersonsJoint("human_knee", worn_.shank, worn_.thigh, worn_.knee_rad, false,
                    [](const WornSample& s) { return s.knee_deg; });
    AddPersonsJoint("hip", worn_.thigh, worn_.trunk, worn_.knee_rad, true, HipDeg);
  }

  void AddCuff(const WornCuff& cuff) {
    const Isometry3d segment = FrameOf(cuff.on_thigh ? worn_.thigh : worn_.shank);
    const Vector3d up(0, cuff.up_m, 0), slip(cuff.slip_m.x(), cuff.slip_m.y(), 0);
    document_.AddBushing({.name = cuff.name,
                          .segment = cuff.Segment(),
                          .link = cuff.Link(),
                          .on_segment = segment * Eigen::Translation3d(up),
                          .on_link = segment * Eigen::Translation3d(up + slip),
                          .stiffness_n_m = {cuff.stiffness_n_m, cuff.stiffness_n_m, 0},
                          .turn_nm = {0, 0, cuff.turn_nm},
                          .damping_n_s_m = {kCuffDamping_n_s_m, kCuffDamping_n_s_m, 0},
                          .turn_damping_nm_s = {0, 0, kCuffDamping_nm_s}});
  }

  const parts::Mechanism& mechanism_;
  const Subject& subject_;
  const WornBody worn_;
  OsimDocument document_;
};

// The turns of shank link, slewing bar, coupler and actuator against the thigh plate.
std::array<double, 4> TurnsOf(const linkage::Pose& pose) {
  const auto turn = [&](parts::Body body) { return parts::PlacementOf(body, pose).turn_rad; };
  return {turn(parts::Body::kShank), turn(parts::Body::kBar), turn(parts::Body::kCoupler),
          turn(parts::Body::kActuator)};
}

// Of the thigh plate: exo_turn, and the hinge's place.
struct PlatePlace {
  double turn_rad = 0;
  Vector2d hinge_m;
};

Eigen::Rotation2Dd Leaning(double lean_deg) {
  return Eigen::Rotation2Dd(-RadiansFromDegrees(lean_deg));
}

// Where the cuffs let the exoskeleton rest, its hinge at this angle: from the slip of the first cuff on each segment.
PlatePlace PlateAt(const WornSample& sample, const Subject& subject, double hinge_deg) {
  const double shank_deg = sample.shank_deg, thigh_deg = shank_deg - sample.knee_deg;
  const double held_deg = hinge_deg - sample.knee_deg, standing_deg = subject.rise.back().knee_deg;
  const Vector2d on_thigh_mm = cuffs::MisfitOf(Vector2d::Zero(), subject.hinge_mm, standing_deg, 0);
  const auto slips_mm =
      cuffs::SlipsOf(subject.cuffs, RadiansFromDegrees(sample.knee_deg), RadiansFromDegrees(standing_deg),
                     subject.hinge_mm.x(), subject.hinge_mm.y(), RadiansFromDegrees(held_deg));
  const auto slip = [&](std::size_t cuff) {
    return Leaning(shank_deg) * Vector2d(slips_mm[cuff][0], slips_mm[cuff][1]);
  };
  const Vector2d on_thigh(0, subject.cuffs.thigh[0].from_knee_mm), on_shank(0, -subject.cuffs.shank[0].from_knee_mm);
  const Vector2d thigh_cuff = Leaning(thigh_deg) * on_thigh + slip(0),  // from the knee
      shank_cuff = Leaning(shank_deg) * on_shank + slip(subject.cuffs.thigh.size());
  // The links are as long as ever, and so is the way between their cuffs.
  const Vector2d before = Leaning(thigh_deg) * (on_thigh - on_thigh_mm) -
                          Leaning(shank_deg + held_deg) * (on_shank - subject.hinge_mm),
                 after = thigh_cuff - shank_cuff;
  const double turned_rad = std::atan2(Cross(before, after), before.dot(after));  // anticlockwise
  const Vector2d knee_mm = Leaning(shank_deg) * Vector2d(0, subject.shank_mm);
  return {turned_rad - RadiansFromDegrees(thigh_deg),
          kMetresPerMillimetre *
              (knee_mm + thigh_cuff - Eigen::Rotation2Dd(turned_rad) * Leaning(thigh_deg) * (on_thigh - on_thigh_mm))};
}

}  // namespace

void WriteOsim(const std::filesystem::path& path, const parts::Mechanism& mechanism) {
  const RigidBodies bodies = RigidBodiesOf(mechanism);
  OsimDocument document("knee_exoskeleton");
  const Isometry3d plate = TurnedOver(Isometry3d::Identity());
  AddMechanism(document, bodies, mechanism.range.stroke, plate, StrokeAt(bodies));
  document.AddJoint(OsimJoint::kWeld, "base", "ground", bodies[kThighPlate].name, TurnedOver(plate), {});
  document.Write(path);
}

void WriteCoupledOsim(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject) {
  CoupledOsim(mechanism, subject).Write(path);
}

void WriteOsimMotion(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject) {
  const linkage::Pose reference = ReferencePose(mechanism);
  const std::array<double, 4> then = TurnsOf(reference);
  exchange::MotTable table;
  table.name = "rise";
  table.columns = {"ankle", "human_knee", "hip",      "stroke", "knee", "thigh_pin",
                   "tip",   "mount",      "exo_turn", "exo_x",  "exo_y"};
  for (const WornSample& sample : subject.rise) {
    const std::array<double, 4> now = TurnsOf(linkage::RequirePose(mechanism.links, sample.stroke_mm));
    std::array<double, 4> turned{};
    for (std::size_t k = 0; k < now.size(); ++k)
      turned[k] = DegreesFromRadians(std::remainder(now[k] - then[k], 2 * std::numbers::pi));
    const double hinge_deg = DegreesFromRadians(reference.theta_rad) + turned[0];
    const PlatePlace plate = PlateAt(sample, subject, hinge_deg);
    table.time_s.push_back(sample.time_s);
    table.rows.push_back({sample.shank_deg, sample.knee_deg, HipDeg(sample), kMetresPerMillimetre * sample.stroke_mm,
                          hinge_deg, turned[1], turned[2] - turned[1], turned[3], DegreesFromRadians(plate.turn_rad),
                          plate.hinge_m.x(), plate.hinge_m.y()});
  }
  exchange::WriteMot(path, table);
}

}  // namespace lake::model
