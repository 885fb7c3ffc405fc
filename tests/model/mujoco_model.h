// A model that MuJoCo has loaded, for tests.
#pragma once

#ifdef LAKE_HAS_MUJOCO
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

namespace lake::testing {

class MujocoModel {
 public:
  explicit MujocoModel(const std::filesystem::path& path) {
    char error[1000] = "";
    model_.reset(mj_loadXML(path.c_str(), nullptr, error, sizeof(error)));
    if (!model_) throw std::runtime_error(std::string("MuJoCo: ") + error);
    data_.reset(mj_makeData(model_.get()));
  }

  mjModel* Model() { return model_.get(); }
  mjData* Data() { return data_.get(); }
  int Id(mjtObj type, const char* name) const {
    const int id = mj_name2id(model_.get(), type, name);
    if (id < 0) throw std::runtime_error(std::string("the model has no ") + name);
    return id;
  }
  double& Position(const char* joint) { return data_->qpos[model_->jnt_qposadr[Id(mjOBJ_JOINT, joint)]]; }
  double& AppliedForce(const char* joint) { return data_->qfrc_applied[model_->jnt_dofadr[Id(mjOBJ_JOINT, joint)]]; }

  // Commands the actuator there at 0.1 m/s, and waits until nothing moves any more.
  void MoveTo(double stroke_m) {
    const double step_m = 0.1 * model_->opt.timestep;
    double& command = data_->ctrl[0];
    if (command == 0) command = Position("stroke");
    while (command != stroke_m) {
      command += std::clamp(stroke_m - command, -step_m, step_m);
      mj_step(model_.get(), data_.get());
    }
    Settle();
  }

  void Settle() {
    constexpr double kStill = 1e-7;
    for (int step = 0; step < 20000; ++step) {
      mj_step(model_.get(), data_.get());
      if (step > 100 && mju_norm(data_->qvel, model_->nv) < kStill) return;
    }
    ADD_FAILURE() << "the model does not come to rest; speed " << mju_norm(data_->qvel, model_->nv);
  }

 private:
  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

}  // namespace lake::testing
#endif
