#include <optional>
#include <variant>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/prototype_validation.h"
#include "lake/camera/camera.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/exchange/ground_forces.h"
#include "lake/exchange/trial.h"
#include "lake/linkage/design_file.h"
#include "lake/motion/corrections.h"
#include "lake/motion/event_corrections.h"
#include "lake/problem/linear_actuator.h"
#include "lake/study/study.h"
#include "lake/sync/clock.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

// Reads the files of one study by the readers of the steps that they are for.
class InputReader {
 public:
  explicit InputReader(const fs::path& study) : study_(study) {}

  // A pipe can be read once, and a folder is its step's.
  template <typename Read>
  void Check(const char* key, const fs::path& file, const Read& read) const {
    if (!fs::is_regular_file(file)) return;
    try {
      read(file);
    } catch (const Error& error) {
      throw Fail("{}: '{}': {}", study_.string(), key, error.what());
    }
  }

  template <typename Read>
  void Check(const char* key, const std::optional<fs::path>& file, const Read& read) const {
    if (file) Check(key, *file, read);
  }

 private:
  const fs::path& study_;
};

void CheckCamera(const InputReader& reader, const char* key, const std::optional<fs::path>& camera) {
  reader.Check(key, camera, [](const fs::path& file) { camera::ReadCameraProfile(file); });
}

// A marker's place in the picture is held against the picture by the step itself.
void CheckVideo(const InputReader& reader, const char* key, const commands::TrackRunOptions& options) {
  constexpr int kAnySize_px = 1 << 20;
  reader.Check(key, options.video, video::HasTimes);
  CheckCamera(reader, key, options.camera);
  reader.Check(key, options.events, motion::ReadEventCorrections);
  reader.Check(key, options.corrections, [&](const fs::path& file) {
    motion::ReadCorrections(file, options.track.names, kAnySize_px, kAnySize_px);
  });
}

void CheckTrial(const InputReader& reader, const char* key, const StudyTrial& trial) {
  if (trial.IsVideo()) return CheckVideo(reader, key, std::get<commands::TrackRunOptions>(trial.work));
  const commands::GaitRunOptions& options = std::get<commands::GaitRunOptions>(trial.work);
  reader.Check(key, options.trial, [&](const fs::path& file) { exchange::ReadTrial(file, options.reading); });
  CheckCamera(reader, key, options.camera);
  reader.Check(key, options.events, motion::ReadEventCorrections);
}

}  // namespace

void CheckFiles(const StudyFile& study) {
  const InputReader reader(study.file);
  CheckCamera(reader, "camera", study.camera);
  if (study.calibration && study.calibration->plane)
    reader.Check("plane", study.calibration->plane->picture,
                 [](const fs::path& file) { video::ReadImage(file, false); });
  CheckTrial(reader, "human", study.human);
  if (study.exo) CheckTrial(reader, "exo", *study.exo);
  reader.Check("worn", study.worn, linkage::ReadDesign);
  if (study.loads) {
    reader.Check("forces", study.loads->forces, exchange::ReadGroundForces);
    reader.Check("sync", study.loads->sync, sync::ReadClock);
  }
  if (study.assistance) reader.Check("actuators", study.assistance->options.actuators, problem::ReadActuators);
  reader.Check("torques", study.simulation.torques, [](const fs::path& file) { CsvTable::Read(file); });
  if (!study.stroke) return;
  reader.Check("duty_table", study.stroke->duty_table, actuator::ReadDutyTable);
  reader.Check("stroke_log", study.stroke->stroke_log, actuator::ReadMeasuredStrokes);
}

}  // namespace lake::study
