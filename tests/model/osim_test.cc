// OpenSim's file, read and posed by this test alone: against MuJoCo's model of the same, the closed form and the cuffs'
// model. OpenSim itself is not at hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "cuffs/leg_energy.h"
#include "lake/core/angles.h"
#include "lake/exchange/mot.h"
#include "lake/model/simulator_model.h"
#include "model/mujoco_model.h"
#include "model/worn_person.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Values = std::map<std::string, double>;  // of coordinates, rad and m

std::vector<double> NumbersIn(const pugi::xml_node& node) {
  std::istringstream text(node.text().get());
  std::vector<double> numbers;
  for (double number = 0; text >> number;) numbers.push_back(number);
  return numbers;
}

Vector3d VectorIn(const pugi::xml_node& node) {
  const std::vector<double> numbers = NumbersIn(node);
  EXPECT_EQ(numbers.size(), 3u) << node.path();
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

class OsimFile {
 public:
  explicit OsimFile(const std::filesystem::path& path) {
    EXPECT_TRUE(document_.load_file(path.c_str())) << path;
    for (const pugi::xml_node joint : Joints())
      for (const pugi::xml_node coordinate : joint.child("coordinates"))
        default_[coordinate.attribute("name").value()] = coordinate.child("default_value").text().as_double();
  }

  pugi::xml_node Model() const { return document_.child("OpenSimDocument").child("Model"); }
  pugi::xml_object_range<pugi::xml_node_iterator> Joints() const {
    return Model().child("JointSet").child("objects").children();
  }
  pugi::xml_node Body(const std::string& name) const {
    return Model().child("BodySet").child("objects").find_child_by_attribute("name", name.c_str());
  }
  pugi::xml_node Force(const std::string& name) const {
    return Model().child("ForceSet").child("objects").find_child_by_attribute("name", name.c_str());
  }
  const Values& Default() const { return default_; }

  // Where a component's frame stands on a body, by the socket's name.
  std::pair<std::string, Isometry3d> FrameAt(const pugi::xml_node& component, const char* socket) const {
    const std::string to = component.child(socket).text().get();
    if (to.starts_with("/")) return {BodyAt(to), Isometry3d::Identity()};
    const pugi::xml_node frame = component.child("frames").find_child_by_attribute("name", to.c_str());
    EXPECT_TRUE(frame) << to;
    const Vector3d turn = VectorIn(frame.child("orientation"));
    Isometry3d on_body(Eigen::Translation3d(VectorIn(frame.child("translation"))));
    on_body.rotate(Eigen::AngleAxisd(turn.x(), Vector3d::UnitX()));
    on_body.rotate(Eigen::AngleAxisd(turn.y(), Vector3d::UnitY()));
    on_body.rotate(Eigen::AngleAxisd(turn.z(), Vector3d::UnitZ()));
    return {BodyAt(frame.child("socket_parent").text().get()), on_body};
  }

  // All bodies in ground.
  std::map<std::string, Isometry3d> Poses(const Values& values) const {
    std::map<std::string, Isometry3d> poses{{"ground", Isometry3d::Identity()}};
    for (bool found = true; found;) {
      found = false;
      for (const pugi::xml_node joint : Joints()) {
        const auto [parent, on_parent] = FrameAt(joint, "socket_parent_frame");
        const auto [child, on_child] = FrameAt(joint, "socket_child_frame");
        if (!poses.contains(parent) || poses.contains(child)) continue;
        poses[child] = poses[parent] * on_parent * Moved(joint, values) * on_child.inverse();
        found = true;
      }
    }
    return poses;
  }

  // How far a loop's two pins stand apart, m, across the line.
  double Apart(const pugi::xml_node& constraint, const std::map<std::string, Isometry3d>& poses) const {
    const Isometry3d& line = poses.at(BodyAt(constraint.child("socket_line_body").text().get()));
    const Isometry3d& follower = poses.at(BodyAt(constraint.child("socket_follower_body").text().get()));
    const Vector3d along = line.linear() * VectorIn(constraint.child("line_direction_vec"));
    const Vector3d apart =
        follower * VectorIn(constraint.child("point_on_follower")) - line * VectorIn(constraint.child("point_on_line"));
    return along.cross(apart).norm();
  }

  double LoopsApart(const std::map<std::string, Isometry3d>& poses) const {
    double most = 0;
    int count = 0;
    for (const pugi::xml_node constraint : Model().child("ConstraintSet").child("objects")) {
      EXPECT_STREQ(constraint.name(), "PointOnLineConstraint");
      most = std::max(most, Apart(constraint, poses));
      ++count;
    }
    EXPECT_EQ(count, 2);
    return most;
  }

  std::string BodyAt(const std::string& path) const {
    if (path == "/ground") return "ground";
    const std::string set = "/bodyset/";
    EXPECT_TRUE(path.starts_with(set)) << path;
    EXPECT_TRUE(Body(path.substr(set.size()))) << path;
    return path.substr(set.size());
  }

 private:
  // As OpenSim's sources say of each type.
  static Isometry3d Moved(const pugi::xml_node& joint, const Values& values) {
    std::vector<double> q;
    for (const pugi::xml_node coordinate : joint.child("coordinates"))
      q.push_back(values.at(coordinate.attribute("name").value()));
    const std::string type = joint.name();
    const auto turned = [](double rad) { return Isometry3d(Eigen::AngleAxisd(rad, Vector3d::UnitZ())); };
    if (type == "WeldJoint") return Isometry3d::Identity();
    if (type == "PinJoint") return turned(q.at(0));
    if (type == "SliderJoint") return Isometry3d(Eigen::Translation3d(q.at(0), 0, 0));
    EXPECT_EQ(type, "PlanarJoint");
    return Eigen::Translation3d(q.at(1), q.at(2), 0) * turned(q.at(0));
  }

  pugi::xml_document document_;
  Values default_;
};

class WornOsim : public ::testing::Test {
 protected:
  WornOsim() {
    model::WriteCoupledOsim(folder_ / "design.osim", mechanism_, subject_);
    model::WriteOsimMotion(folder_ / "course.mot", mechanism_, subject_);
    file_.emplace(folder_ / "design.osim");
    motion_ = exchange::ReadMot(folder_ / "course.mot");
  }

  Values Row(std::size_t i) const {
    Values values;
    for (std::size_t k = 0; k < motion_.columns.size(); ++k) {
      const std::string& name = motion_.columns[k];
      const bool is_length = name == "stroke" || name == "exo_x" || name == "exo_y";
      values[name] = is_length ? motion_.rows[i][k] : RadiansFromDegrees(motion_.rows[i][k]);
    }
    return values;
  }

  const TemporaryFolder folder_;
  const parts::Mechanism mechanism_ = testing::Published();
  const model::Subject subject_ = testing::Wearing(mechanism_);
  std::optional<OsimFile> file_;
  exchange::MotTable motion_;
};

void CollectNames(const pugi::xml_node& node, std::set<std::string>& names) {
  for (const pugi::xml_node child : node.children()) {
    if (child.type() != pugi::node_element) continue;
    names.insert(child.name());
    CollectNames(child, names);
  }
}

// Classes, properties and sockets of opensim-core, from its headers and the files of opensim-models.
TEST_F(WornOsim, UsesOpenSimsNamesAlone) {
  std::set<std::string> names;
  CollectNames(file_->Model(), names);
  const std::set<std::string> known = {
      "Ground", "gravity", "length_units", "force_units", "BodySet", "JointSet", "ConstraintSet", "ForceSet", "objects",
      "groups",
      // ModelComponent, Body, PhysicalOffsetFrame
      "components", "Body", "mass", "mass_center", "inertia", "PhysicalOffsetFrame", "socket_parent", "translation",
      "orientation", "attached_geometry", "Brick", "half_lengths", "Cylinder", "radius", "half_height", "socket_frame",
      // Joint, Coordinate
      "WeldJoint", "PinJoint", "SliderJoint", "PlanarJoint", "socket_parent_frame", "socket_child_frame", "frames",
      "coordinates", "Coordinate", "default_value", "default_speed_value", "range", "clamped", "locked",
      "prescribed_function", "prescribed", "is_free_to_satisfy_constraints", "SimmSpline", "x", "y",
      // Constraint, Force
      "PointOnLineConstraint", "isEnforced", "socket_line_body", "socket_follower_body", "line_direction_vec",
      "point_on_line", "point_on_follower", "BushingForce", "appliesForce", "socket_frame1", "socket_frame2",
      "rotational_stiffness", "translational_stiffness", "rotational_damping", "translational_damping",
      "CoordinateActuator", "min_control", "max_control", "coordinate", "optimal_force"};
  for (const std::string& name : names) EXPECT_TRUE(known.contains(name)) << name;
}

TEST_F(WornOsim, EachBodyHangsOnOneJointAndEachActuatorOnACoordinate) {
  std::map<std::string, int> children;
  for (const pugi::xml_node joint : file_->Joints()) ++children[file_->FrameAt(joint, "socket_child_frame").first];
  const auto poses = file_->Poses(file_->Default());
  int bodies = 0;
  for (const pugi::xml_node body : file_->Model().child("BodySet").child("objects")) {
    EXPECT_EQ(children[body.attribute("name").value()], 1) << body.attribute("name").value();
    EXPECT_TRUE(poses.contains(body.attribute("name").value()));
    EXPECT_GT(body.child("mass").text().as_double(), 0);
    ++bodies;
  }
  EXPECT_EQ(bodies, 10);
  for (const char* name : {"actuator", "ankle_moment", "human_knee_moment", "hip_moment"})
    EXPECT_TRUE(file_->Default().contains(file_->Force(name).child("coordinate").text().get())) << name;
}

// Loops, person, mechanism and cuffs at each percent of the rise.
TEST_F(WornOsim, ItsMotionIsTheRise) {
  constexpr double kSame_m = 1e-9;
  ASSERT_EQ(motion_.rows.size(), subject_.rise.size());
  const double stiffness = std::sqrt(subject_.cuffs.softest_n_mm * subject_.cuffs.stiffest_n_mm);
  const Eigen::Vector2d on_thigh =
      cuffs::MisfitOf(Eigen::Vector2d::Zero(), subject_.hinge_mm, subject_.rise.back().knee_deg, 0);
  for (std::size_t i = 0; i < motion_.rows.size(); ++i) {
    const model::WornSample& sample = subject_.rise[i];
    EXPECT_EQ(motion_.time_s[i], sample.time_s);
    const auto poses = file_->Poses(Row(i));
    EXPECT_LT(file_->LoopsApart(poses), kSame_m) << i;
    // The person: leans forward are turns backward about z.
    const auto up = [](double lean_deg) {
      return Vector3d(std::sin(RadiansFromDegrees(lean_deg)), std::cos(RadiansFromDegrees(lean_deg)), 0);
    };
    const Vector3d knee = 0.42 * up(sample.shank_deg), hip = knee + 0.4 * up(sample.shank_deg - sample.knee_deg);
    EXPECT_LT(poses.at("shank").translation().norm(), kSame_m);
    EXPECT_LT((poses.at("thigh").translation() - knee).norm(), kSame_m) << i;
    EXPECT_LT((poses.at("trunk").translation() - hip).norm(), kSame_m) << i;
    EXPECT_LT((poses.at("trunk").linear() * Vector3d::UnitY() - up(sample.trunk_deg)).norm(), kSame_m) << i;
    // The mechanism on its plate, as the closed form has it.
    const linkage::Pose closed = linkage::RequirePose(mechanism_.links, sample.stroke_mm);
    for (const auto& [name, part] :
         {std::pair("shank_link", parts::Body::kShank), std::pair("coupler", parts::Body::kCoupler),
          std::pair("slewing_bar", parts::Body::kBar), std::pair("actuator_body", parts::Body::kActuator)}) {
      const Isometry3d on_plate = poses.at("thigh_plate").inverse() * poses.at(name);
      const parts::Placement expected = parts::PlacementOf(part, closed);
      EXPECT_LT((on_plate.translation().head<2>() - 1e-3 * expected.at_mm).norm(), kSame_m) << name << " " << i;
      EXPECT_NEAR(std::remainder(std::atan2(on_plate(1, 0), on_plate(0, 0)) - expected.turn_rad, 2 * M_PI), 0, 1e-9);
    }
    // Each cuff slips as its model says.
    const double hinge_deg = DegreesFromRadians(Row(i)["knee"]);
    const cuffs::LegLoad load = cuffs::LoadOnLeg({sample.shank_deg - sample.knee_deg, sample.shank_deg, on_thigh,
                                                  subject_.hinge_mm, 0, hinge_deg - sample.knee_deg},
                                                 subject_.cuffs, {stiffness, stiffness});
    const auto slips = [&](const char* name, const cuffs::CuffLoad& expected) {
      const pugi::xml_node cuff = file_->Force(name);
      const auto [segment, on_segment] = file_->FrameAt(cuff, "socket_frame1");
      const auto [link, on_link] = file_->FrameAt(cuff, "socket_frame2");
      const Isometry3d moved = (poses.at(segment) * on_segment).inverse() * poses.at(link) * on_link;
      EXPECT_LT((moved.translation().head<2>() - 1e-3 * expected.slip_mm).norm(), kSame_m) << name << " " << i;
      EXPECT_NEAR(moved.translation().z(), 0, kSame_m);
      const double turn_nm = VectorIn(cuff.child("rotational_stiffness")).z() * std::atan2(moved(1, 0), moved(0, 0));
      EXPECT_NEAR(turn_nm, -expected.moment_nm, 1e-6) << name << " " << i;
      EXPECT_NEAR(VectorIn(cuff.child("translational_stiffness")).x(), 1e3 * stiffness, 1e-9);
    };
    slips("thigh_cuff_1", load.thigh[0]);
    slips("thigh_cuff_2", load.thigh[1]);
    slips("shank_cuff_1", load.shank[0]);
  }
}

// Prescribed in the model is what the motion says.
TEST_F(WornOsim, ItsProgramIsTheRise) {
  for (const pugi::xml_node joint : file_->Joints())
    for (const pugi::xml_node coordinate : joint.child("coordinates")) {
      const std::string name = coordinate.attribute("name").value();
      const pugi::xml_node spline = coordinate.child("prescribed_function").child("SimmSpline");
      const bool driven = name == "ankle" || name == "human_knee" || name == "hip" || name == "stroke";
      EXPECT_EQ(static_cast<bool>(spline), driven) << name;
      EXPECT_EQ(coordinate.child("prescribed").text().as_bool(), driven) << name;
      if (!driven) continue;
      const std::vector<double> times = NumbersIn(spline.child("x")), values = NumbersIn(spline.child("y"));
      ASSERT_EQ(times.size(), motion_.rows.size());
      ASSERT_EQ(values.size(), motion_.rows.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_EQ(times[i], motion_.time_s[i]);
        EXPECT_NEAR(values[i], Row(i)[name], 1e-12) << name << " " << i;
      }
    }
}

TEST(Osim, TheMechanismAloneFollowsItsClosedForm) {
  const TemporaryFolder folder;
  const parts::Mechanism mechanism = testing::Published();
  model::WriteOsim(folder / "design.osim", mechanism);
  const OsimFile file(folder / "design.osim");
  const auto turns = [](const linkage::Pose& pose) {
    const auto turn = [&](parts::Body body) { return parts::PlacementOf(body, pose).turn_rad; };
    return Eigen::Vector3d(turn(parts::Body::kBar), turn(parts::Body::kCoupler) - turn(parts::Body::kBar),
                           turn(parts::Body::kActuator));
  };
  const Eigen::Vector3d then = turns(model::ReferencePose(mechanism));
  EXPECT_LT(file.LoopsApart(file.Poses(file.Default())), 1e-12);
  for (const double part : {0.1, 0.6, 0.9}) {
    const linkage::Pose pose =
        linkage::RequirePose(mechanism.links, mechanism.range.stroke.lower_mm + part * mechanism.range.stroke.Travel());
    const Eigen::Vector3d turned = turns(pose) - then;
    const auto poses = file.Poses({{"knee", pose.theta_rad},
                                   {"thigh_pin", turned[0]},
                                   {"tip", turned[1]},
                                   {"mount", turned[2]},
                                   {"stroke", 1e-3 * pose.stroke_mm}});
    EXPECT_LT(file.LoopsApart(poses), 1e-9) << part;
    // Flexion is positive, and takes the shank's pin behind the knee.
    EXPECT_NEAR(poses.at("coupler").translation().x(), -1e-3 * pose.tip.x(), 1e-9);
    EXPECT_NEAR(poses.at("coupler").translation().y(), 1e-3 * pose.tip.y(), 1e-9);
  }
}

#ifdef LAKE_HAS_MUJOCO

// MuJoCo's x, y, z are OpenSim's x, -z, y.
TEST_F(WornOsim, InItsPoseEachBodyIsWhereMuJoCoHasIt) {
  model::WriteCoupledMjcf(folder_ / "design.xml", mechanism_, subject_);
  testing::MujocoModel simulation(folder_ / "design.xml");
  mj_forward(simulation.Model(), simulation.Data());
  Eigen::Matrix3d osim_from_mujoco;
  osim_from_mujoco << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const auto poses = file_->Poses(file_->Default());
  for (const auto& [name, pose] : poses) {
    if (name == "ground") continue;
    const int id = simulation.Id(mjOBJ_BODY, name.c_str());
    const mjData& data = *simulation.Data();
    const Vector3d at = osim_from_mujoco * Vector3d::Map(data.xpos + 3 * id);
    EXPECT_LT((pose.translation() - at).norm(), 1e-9) << name;
    const pugi::xml_node body = file_->Body(name);
    EXPECT_NEAR(body.child("mass").text().as_double(), simulation.Model()->body_mass[id], 1e-12) << name;
    const Vector3d centre = osim_from_mujoco * Vector3d::Map(data.xipos + 3 * id);
    EXPECT_LT((pose * VectorIn(body.child("mass_center")) - centre).norm(), 1e-9) << name;
    const std::vector<double> i = NumbersIn(body.child("inertia"));
    ASSERT_EQ(i.size(), 6u);
    Eigen::Matrix3d inertia;
    inertia << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
    const Eigen::Matrix3d axes =
        osim_from_mujoco * Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(data.ximat + 9 * id);
    const Eigen::Matrix3d expected =
        axes * Vector3d::Map(simulation.Model()->body_inertia + 3 * id).asDiagonal() * axes.transpose();
    EXPECT_LT((pose.linear() * inertia * pose.linear().transpose() - expected).norm(), 1e-9) << name;
  }
}

#else
TEST_F(WornOsim, InItsPoseEachBodyIsWhereMuJoCoHasIt) {
  GTEST_SKIP() << "MuJoCo is not installed";
}
#endif

}  // namespace
}  // namespace lake
