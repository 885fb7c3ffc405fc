// What both models for MuJoCo have.
#pragma once

#include "rigid_bodies.h"
#include "xml.h"

namespace lake::model {

// A body in its parent, with inertia and shape. Both turn about z alone.
pugi::xml_node AddBody(pugi::xml_node parent, const RigidBody& body, const Eigen::Isometry3d& thigh_from_parent);

void AddOptions(pugi::xml_node model);
void AddMeshes(pugi::xml_node model, const RigidBodies& bodies);

// All but the thigh plate, in the thigh plate's body.
void AddMechanism(pugi::xml_node frame, const RigidBodies& bodies, const linkage::StrokeRange& stroke);

// What closes its loops.
void AddLoops(pugi::xml_node equality, const linkage::Links& links);

void AddActuator(pugi::xml_node actuators, const linkage::StrokeRange& stroke, double stiffness_n_m);

}  // namespace lake::model
