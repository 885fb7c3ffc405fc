// Seeds for the fuzz targets, made by our own writers or taken from the repository: FOLDER/<target>/<seed>.
#include <cmath>
#include <cstdio>

#include "exchange/recordings.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"
#include "places.h"

namespace {

namespace fs = std::filesystem;

fs::path SeedPath(const fs::path& folder, const std::string& target, const std::string& name) {
  fs::create_directories(folder / target);
  return folder / target / name;
}

void WriteSeeds(const fs::path& folder, std::size_t frames, std::size_t points) {
  const std::string size = std::to_string(frames) + "x" + std::to_string(points);
  const lake::exchange::PointRecording plane = lake::MakePoints(lake::exchange::PointSpace::kPlane, frames, points, 1);
  lake::exchange::PointRecording image = lake::MakePoints(lake::exchange::PointSpace::kImage, frames, points, 2);
  for (const auto& [target, ending] : {std::pair{"trc", ".trc"},
                                       {"c3d", ".c3d"},
                                       {"tracker_text", ".txt"},
                                       {"kinovea_csv", "_kinovea.csv"},
                                       {"lake_csv", ".csv"}})
    lake::exchange::WritePoints(SeedPath(folder, target, size + ending), plane);
  image.mm_per_px = 2;
  image.axes = lake::exchange::ImageAxes{{3, 4}, 5};
  image.video = lake::exchange::SourceVideo{"a.mp4", 640, 480};
  const fs::path trk = SeedPath(folder, "trk", size + ".trk");
  lake::exchange::WritePoints(trk, image);
  lake::exchange::WritePoints(SeedPath(folder, "kva", size + ".kva"), image);
  lake::WriteZip(SeedPath(folder, "trz", size + ".trz"), "a.trk", lake::ReadTextFile(trk));
  lake::exchange::WriteMot(SeedPath(folder, "mot", size + ".mot"),
                           {"knee", true, {"a", "b"}, {0, 0.1}, {{1, 2}, {3, 4}}});
  lake::WriteFile(SeedPath(folder, "dltdv", size + ".csv"), "pt1_cam1_X,pt1_cam1_Y\n1,2\nNaN,NaN\n3.5,4\n");
}

// The files that a user writes: those of the repository, and each kind of section once.
void WriteUserFiles(const fs::path& folder) {
  const fs::path source = SourceDir();
  const auto copy = [&](const char* target, const fs::path& file) {
    fs::copy_file(source / file, SeedPath(folder, target, file.filename()), fs::copy_options::overwrite_existing);
  };
  copy("camera", "data/sts-study/camera.yaml");
  copy("study", "data/sts-study/study.yaml");
  copy("design", "data/sts-study/worn.yaml");
  for (const char* problem : {"buildable.yaml", "paper.yaml", "wearable.yaml"})
    copy("problem", fs::path("calibration/problems") / problem);
  lake::WriteTextFile(
      SeedPath(folder, "cohort", "three.yaml"),
      "name: Three\ntask: sts\nsteps: [comparison]\nstudy:\n  human: {video: human.mp4, end_s: 4}\n"
      "  camera: $cohort/camera.yaml\n  simulate: {mass_kg: $mass_kg}\npeople: {sub-01: {camera: ~}}\n"
      "population: {max_misalignment_percent: 3}\n\fparticipant_id\tmass_kg\nsub-01\t70\nsub-02\tn/a\n");
  lake::WriteTextFile(SeedPath(folder, "duty_log", "log.csv"),
                      "# bench\ntime_s,stroke_mm,duty\n0,300,0\n0.02,300.1,0.3\nok\n0.04,,0.3\n0.06,299,-1\n");
  lake::WriteTextFile(SeedPath(folder, "corrections", "corrections.csv"),
                      "frame,marker,x_px,y_px,sigma_px\n5,knee,,,\n6,hip,320.5,180,0.5\n");
}

void WriteComparison(const fs::path& folder) {
  const auto constant = [](const auto& value) {
    return lake::Json(std::vector<std::decay_t<decltype(value)>>(101, value));
  };
  lake::Json curves;
  for (int percent = 0; percent <= 100; ++percent) curves["percent"].push_back(percent);
  for (const std::string who : {"human", "exo"}) {
    for (const auto& [joint, x, y] : {std::tuple{"ankle", 0, 0}, {"knee", 30, 400}, {"hip", -350, 500}}) {
      curves[who + "_" + joint + "_x_mm"] = constant(x);
      curves[who + "_" + joint + "_y_mm"] = constant(y);
    }
    curves[who + "_knee_deg"] = constant(80);
    curves[who + "_knee_sigma_mm"] = constant(1);
  }
  curves["exo_leg_knee_x_mm"] = constant(30);
  curves["exo_leg_knee_y_mm"] = constant(400);
  curves["shank_mm"] = constant(std::hypot(30, 400));
  curves["spike"] = constant(false);
  lake::WriteTextFile(SeedPath(folder, "comparison", "constant.json"),
                      lake::Json{{"format", 1},
                                 {"metrics", lake::Json::object()},
                                 {"noise_floor_mm", 1},
                                 {"noise_floor_relative", 0.01},
                                 {"duration_s", {{"human", 2}, {"exo", 3}}},
                                 {"curves", curves}}
                          .dump());
  lake::compare::ReadComparison(folder / "comparison/constant.json");  // a seed that is refused leads nowhere
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: lake_fuzz_corpus FOLDER\n");
    return 2;
  }
  for (const std::size_t frames : {2u, 9u})
    for (const std::size_t points : {1u, 3u}) WriteSeeds(argv[1], frames, points);
  WriteUserFiles(argv[1]);
  WriteComparison(argv[1]);
  return 0;
}
