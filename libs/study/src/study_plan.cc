#include <algorithm>
#include <array>

#include "lake/study/study.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

// What a step needs and always leaves. Memory and time are limits for a scheduler, several times what the sample study
// takes (330 MB, 25 s on one core at most): recordings are longer and larger elsewhere.
struct StepNeeds {
  const char* step;
  int threads, memory_mb, minutes;
  std::vector<const char*> outputs;
};

const StepNeeds& NeedsOf(const std::string& step) {
  static const std::array kNeeds = {
      StepNeeds{"calibration", 2, 2000, 60, {"camera.yaml", "summary.json"}},
      StepNeeds{"plane", 1, 1000, 10, {"camera.yaml", "summary.json"}},
      StepNeeds{"human", 2, 2000, 60, {"kinematics.csv", "events.csv", "summary.json"}},
      StepNeeds{"exo", 2, 2000, 60, {"kinematics.csv", "events.csv", "summary.json"}},
      StepNeeds{"comparison", 1, 1000, 10, {"comparison.json", "misalignment.csv", "summary.json"}},
      StepNeeds{"optimum", 1, 1000, 120, {"design.yaml", "summary.json"}},
      StepNeeds{"redesign", 1, 1000, 120, {"design.yaml", "summary.json"}},
      StepNeeds{"simulation", 1, 1000, 30, {"angle_vs_stroke.csv", "summary.json"}},
      StepNeeds{"stroke", 1, 1000, 10, {"program.csv", "summary.json"}},
      StepNeeds{"report", 1, 1000, 10, {"report.html"}},
      StepNeeds{nullptr, 1, 1000, 60, {"summary.json"}},  // any other
  };
  return *std::find_if(kNeeds.begin(), kNeeds.end() - 1, [&](const StepNeeds& needs) { return step == needs.step; });
}

std::string Absolute(const fs::path& path) {
  return fs::absolute(path).lexically_normal().string();
}

Json StepPlan(const steps::StudyStep& step, const std::vector<std::string>& before, const std::string& why) {
  const StepNeeds& needs = NeedsOf(step.name);
  Json plan = {{"name", step.name},
               {"what", step.what},
               {"program", step.program},
               {"folder", Absolute(step.folder)},
               {"after", before},
               {"inputs", Json::array()},
               {"outputs", Json::array()},
               {"due", why.empty() ? Json() : Json(why)},
               {"resources", {{"threads", needs.threads}, {"memory_mb", needs.memory_mb}, {"minutes", needs.minutes}}}};
  for (const fs::path& input : step.inputs) plan["inputs"].push_back(Absolute(input));
  for (const char* output : needs.outputs) plan["outputs"].push_back(Absolute(step.folder / output));
  return plan;
}

}  // namespace

Json StudyPlan(const StudyFile& study, const fs::path& out, const std::string& made_by) {
  const std::vector<steps::StudyStep> steps = StudySteps(study, out, Json::object());
  const std::vector<std::string> reasons = steps::WhyDoSteps(steps, made_by);
  Json plan = {{"name", study.name}, {"study", Absolute(study.file)}, {"out", Absolute(out)}, {"steps", Json::array()}};
  for (std::size_t i = 0; i < steps.size(); ++i)
    plan["steps"].push_back(StepPlan(steps[i], steps::StepsBefore(steps, steps[i]), reasons[i]));
  return plan;
}

}  // namespace lake::study
