// Folders with names that other programs and libraries understand otherwise.
#include <gmock/gmock.h>

#include <filesystem>
#include <functional>

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
  std::filesystem::create_directories(folder / "after");
  figure.Write(folder / "figure.svg");
  WriteTextFile(folder / ".gnuplot", "set title 'mine'\nset xrange [0:1]\n");
  const HomeFolder home(folder.Path());
  figure.Write(folder / "after/figure.svg");
  EXPECT_EQ(ReadTextFile(folder / "after/figure.svg"), ReadTextFile(folder / "figure.svg"));
}

TEST(Figures, OfBothFormsAreAsEachAlone) {
  const TemporaryFolder folder;
  figure::GnuplotFigure figure(200, 100);
  figure.Line("set multiplot layout 1,2").Line("set logscale y").Line("plot x").Line("set title 'right'");
  figure.Line("plot " + figure.Data({{0, 1, 2}, {1, 10, 100}})).Line("unset multiplot");
  std::filesystem::create_directories(folder / "alone");
  for (const char* name : {"figure.png", "figure.svg"}) figure.Write(folder / "alone" / name);
  figure.Write(folder / "figure");
  for (const char* name : {"figure.png", "figure.svg"})
    EXPECT_EQ(ReadTextFile(folder / name), ReadTextFile(folder / "alone" / name)) << name;
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
