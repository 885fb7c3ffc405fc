// Folders with names that other programs and libraries understand otherwise, and figures under other odd conditions.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <regex>
#include <vector>

#include "home_folder.h"
#include "lake/core/atomic_file.h"
#include "lake/figure/gnuplot.h"
#include "lake/model/simulator_model.h"
#include "lake/model/step_file.h"
#include "temporary_folder.h"

namespace lake {
namespace {

void ExpectSame(const char* file, const std::function<void(const std::filesystem::path&)>& write) {
  const TemporaryFolder folder;
  write(folder / file);
  const std::string plain = ReadTextFile(folder / file);
  for (const char* name : {"a b 'c' \"d\" $HOME `id` \\n", "a\nb\tc", "-rf", "100%d %s {}", "<b>&alert(1)07", "[0-9]*",
                           "J\xFCrgen", "膝"}) {
    std::filesystem::create_directory(folder / name);
    write(folder / name / file);
    EXPECT_EQ(ReadTextFile(folder / name / file), plain) << name;
  }
}

TEST(OddNames, Figures) {
  figure::GnuplotFigure figure(200, 100);
  figure.Line("plot x");
  ExpectSame("figure.svg", [&](const auto& path) { figure.Write(path); });
}

TEST(Figures, AreTheSameWhateverTheUsersOwnSettingsSay) {
  const TemporaryFolder folder;
  figure::GnuplotFigure figure(200, 100);
  figure.Line("plot x");
  figure.Write(folder / "before.svg");
  WriteTextFile(folder / ".gnuplot", "set title 'mine'\nset xrange [0:1]\n");
  const HomeFolder home(folder.Path());
  figure.Write(folder / "after.svg");
  EXPECT_EQ(ReadTextFile(folder / "after.svg"), ReadTextFile(folder / "before.svg"));
}

// 55 minutes at 60 Hz: a wave with one sample far above it, and a gap.
TEST(Figures, LongCurvesKeepTheirExtremesAndGapsInASmallFile) {
  std::vector<double> x, y;
  for (int i = 0; i < 200000; ++i) {
    x.push_back(i / 200000.0);
    y.push_back(i == 123456 ? 10 : std::sin(0.01 * i));
    if (i > 60000 && i < 80000) y.back() = std::nan("");
  }
  const TemporaryFolder folder;
  figure::GnuplotFigure figure(200, 120);
  figure.Line("set margins 0, 0, 0, 0\nunset border\nunset tics\nset xrange [0:1]\nset yrange [-2:10]");
  figure.Line(fmt::format("plot {} using 1:2 with lines notitle", figure.Data({x, y}))).Write(folder / "figure.svg");
  const std::string svg = ReadTextFile(folder / "figure.svg");
  EXPECT_LT(svg.size(), 500000u);
  const std::regex place("[ML]([0-9.]+),([0-9.]+)");
  double highest = 120, at = 0, left_of_gap = 0, right_of_gap = 200;
  for (std::sregex_iterator
           match(svg.begin() + static_cast<std::ptrdiff_t>(svg.find("gnuplot_plot_1")), svg.end(), place),
       end;
       match != end; ++match) {
    const double px = std::stod((*match)[1]), py = std::stod((*match)[2]);
    if (py < highest) highest = py, at = px;
    if (px < 0.35 * 200) left_of_gap = std::max(left_of_gap, px);
    if (px > 0.35 * 200) right_of_gap = std::min(right_of_gap, px);
  }
  EXPECT_NEAR(highest, 0, 1);
  EXPECT_NEAR(at, 0.61728 * 200, 1);
  EXPECT_NEAR(left_of_gap, 0.3 * 200, 1);
  EXPECT_NEAR(right_of_gap, 0.4 * 200, 1);
}

TEST(OddNames, Solids) {
  const linkage::Links links{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  const parts::Mechanism mechanism = parts::MakeMechanism(links, linkage::FindUsedRange(links, 245, {}), {});
  const TemporaryFolder folder;
  for (const char* name : {"a\nb", "J\xFCrgen"}) {
    std::filesystem::create_directory(folder / name);
    model::WriteStep(folder / name / "solids.step", mechanism, model::ReferencePose(mechanism));
    EXPECT_THAT(ReadTextFile(folder / name / "solids.step"), testing::EndsWith("END-ISO-10303-21;\n")) << name;
  }
}

}  // namespace
}  // namespace lake
