#include "lake/loads/inverse_dynamics.h"

#include "lake/core/cross.h"

namespace lake::loads {

Wrench RequiredWrench(std::span<const Body> bodies, const Eigen::Vector2d& about_m) {
  Wrench wrench;
  for (const Body& body : bodies) {
    const Eigen::Vector2d force_n = body.mass_kg * (body.acceleration_m_s2 + kGravity_m_s2 * Eigen::Vector2d::UnitY());
    wrench.force_n += force_n;
    wrench.moment_nm += Cross(body.centre_m - about_m, force_n) + body.inertia_kg_m2 * body.angular_acceleration_rad_s2;
  }
  return wrench;
}

Wrench About(const Wrench& wrench, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) {
  return {wrench.force_n, wrench.moment_nm + Cross(from_m - to_m, wrench.force_n)};
}

}  // namespace lake::loads
