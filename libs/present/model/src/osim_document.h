// An OpenSim model as its file says it (format 40000, of OpenSim 4.0 and later), put together from places in
// one pose. Ground's frame: x anterior, y up, z to the right; m, kg, rad.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

namespace lake::model {

// Euler angles about x, y and z of the turned axes, as OpenSim says how a frame is turned.
Eigen::Vector3d BodyFixedXyz(const Eigen::Matrix3d& turn);

struct OsimBody {
  std::string name;
  double mass_kg = 0;
  Eigen::Vector3d centre_m;
  Eigen::Matrix3d inertia_kg_m2;  // about the centre, the body's axes
  Eigen::Isometry3d ground_from_body;
};

struct OsimCourse {
  std::vector<double> time_s, values;
};

struct OsimCoordinate {
  std::string name;
  double value = 0;  // in the pose
  bool is_length = false;
  std::optional<std::pair<double, double>> range = {};
  bool follows_loops = false;                 // found from the loops' constraints where the model is posed
  std::optional<OsimCourse> prescribed = {};  // over time
};

// Joints by OpenSim's names, each about or along the axes of its frames.
enum class OsimJoint { kWeld, kPin, kSlider, kPlanar };

struct OsimBushing {
  std::string name, segment, link;
  Eigen::Isometry3d on_segment, on_link;  // in ground: the second turned and moved against the first
  Eigen::Vector3d stiffness_n_m, turn_nm, damping_n_s_m, turn_damping_nm_s;
};

class OsimDocument {
 public:
  explicit OsimDocument(const std::string& name);

  // To be shown on it: shapes of AddBrick and AddCylinder.
  void AddBody(const OsimBody& body);
  void AddBrick(const std::string& body, const Eigen::Vector3d& middle_m, const Eigen::Vector3d& half_m);
  // From one point to another, both on a line along x or y.
  void AddCylinder(const std::string& body, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                   double radius_m);

  // `at`: the child's frame of the joint in ground, in the pose. The parent is a body or `ground`.
  void AddJoint(OsimJoint type, const std::string& name, const std::string& parent, const std::string& child,
                const Eigen::Isometry3d& at, const std::vector<OsimCoordinate>& coordinates);
  // A pin through both along ground's z, which leaves no equation to what a planar mechanism cannot do anyway.
  void AddPin(const std::string& name, const std::string& line_body, const std::string& follower_body,
              const Eigen::Vector3d& at_m);
  void AddBushing(const OsimBushing& bushing);
  void AddActuator(const std::string& name, const std::string& coordinate);

  void Write(const std::filesystem::path& path) const;

 private:
  pugi::xml_node AddOffsetFrame(pugi::xml_node parent, const std::string& name, const std::string& body,
                                const Eigen::Isometry3d& ground_from_frame) const;
  Eigen::Isometry3d GroundFrom(const std::string& body) const;
  pugi::xml_node AddShape(const std::string& body, const Eigen::Isometry3d& body_from_shape, const char* type);

  pugi::xml_document document_;
  pugi::xml_node bodies_, joints_, constraints_, forces_;
  std::map<std::string, Eigen::Isometry3d> ground_from_;
};

}  // namespace lake::model
