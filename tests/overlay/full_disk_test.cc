// A disk that takes no more: every writer says so, and leaves no half file under the final name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "file_limit.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/drawing/linkage_dxf.h"
#include "lake/figure/gnuplot.h"
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
