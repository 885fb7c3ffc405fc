// Seeds for the fuzz targets, made by our own writers: FOLDER/<target>/<seed>.
#include <cstdio>

#include "exchange/recordings.h"
#include "lake/core/atomic_file.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"

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

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: lake_fuzz_corpus FOLDER\n");
    return 2;
  }
  for (const std::size_t frames : {2u, 9u})
    for (const std::size_t points : {1u, 3u}) WriteSeeds(argv[1], frames, points);
  return 0;
}
