// A disk that takes no more: every writer says so, and leaves no half file under the final name.
#include <gmock/gmock.h>

#include <functional>

#include "file_limit.h"
#include "lake/camera/board.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/drawing/linkage_dxf.h"
#include "lake/figure/gnuplot.h"
#include "lake/model/simulator_model.h"
#include "lake/model/step_file.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

void ExpectRefused(const char* name, rlim_t bytes, const std::function<void(const std::filesystem::path&)>& write) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(write(folder / name));
  std::filesystem::remove(folder / name);
  {
    const FileLimit full(bytes);
    EXPECT_THAT([&] { write(folder / name); }, ThrowsMessage<Error>(HasSubstr(name))) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path())) << name;
}

TEST(FullDisk, LinkPlates) {
  for (const rlim_t bytes : {0, 1000, 8000})
    ExpectRefused("plates.dxf", bytes, [](const auto& path) {
      drawing::WriteLinkPlates(path, {59.081, 68.840, 55.964, 71.849, 118.630, 287.310});
    });
}

TEST(FullDisk, Solids) {
  const linkage::Links links{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  const parts::Mechanism mechanism = parts::MakeMechanism(links, linkage::FindUsedRange(links, 245, {}), {});
  for (const rlim_t bytes : {0, 1000, 100'000})
    ExpectRefused("solids.step", bytes,
                  [&](const auto& path) { model::WriteStep(path, mechanism, model::ReferencePose(mechanism)); });
}

TEST(FullDisk, BoardSheets) {
  for (const rlim_t bytes : {0, 1000, 4000})
    ExpectRefused("board.pdf", bytes, [](const auto& path) {
      camera::WriteBoardSheet(path, camera::ParseBoard("chessboard:9x6:25"), camera::ParsePaper("a4"));
    });
}

TEST(FullDisk, Tables) {
  ExpectRefused("table.csv", 5000, [](const auto& path) {
    CsvWriter table({"a", "b"});
    for (int i = 0; i < 2000; ++i) table.Add(i).Add(0.5 * i).EndRow();
    table.Write(path);
  });
  ExpectRefused("summary.json", 5000, [](const auto& path) { WriteJsonFile(path, Json(std::vector<int>(3000, 1))); });
}

TEST(FullDisk, Figures) {
  figure::GnuplotFigure figure(800, 600);
  figure.Line("plot sin(x), cos(x), sin(2 * x)");
  for (const char* name : {"figure.png", "figure.svg"})
    ExpectRefused(name, 4000, [&](const auto& path) { figure.Write(path); });
  ExpectRefused("figure.gif", 4000, [&](const auto& path) { figure.WriteGif(path, 10); });
}

}  // namespace
}  // namespace lake
