// lake-live: a camera's frames as they come: the exoskeleton's joint against the knee after each rise, and a trial.
#include "lake/core/standard_output.h"
#include "lake/live/run_live.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program(
      "lake-live", "Align an exoskeleton while it is worn: where its joint sits against the knee after each rise",
      "lake-live /dev/video0 --size 1920x1080 --rate 60 --format mjpeg --camera camera.yaml -o trial --open");
  lake::live::LiveRunOptions options;
  program.Add(lake::OptionsOf(options).WithUsual({"size", "rate", "replay", "camera", "scale", "depth", "markers",
                                                  "seed", "technical", "knee-from", "joint-at", "tolerance", "listen",
                                                  "port", "open"}));
  const auto name = [&] {
    return lake::live::IsFolderToFinish(options) ? std::filesystem::absolute(options.input).string() : "live";
  };
  return program.Main(argc, argv, name, [&](lake::Run& run) {
    const auto programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    const lake::Json live = lake::live::RunLive(options, programs, run);
    // Its summary is live.json: summary.json is lake-track's.
    if (program.SaysJson())
      fmt::print("{}\n", live.dump(2, ' ', false, lake::Json::error_handler_t::replace));
    else
      fmt::print("{}results in {}\n", run.ReportText(), run.Folder().string());
    lake::FlushStdout();
    return lake::Json();
  });
}
