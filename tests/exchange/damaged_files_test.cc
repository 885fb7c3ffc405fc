// Every reader, on files that are damaged: an answer or an Error of one line, never anything else. The same for longer,
// and led by coverage, in tests/fuzz.

#include <map>
#include <random>

#include "lake/core/atomic_file.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

void ReadAny(const fs::path& path) {
  if (path.extension() == ".mot")
    exchange::ReadMot(path);
  else
    exchange::ReadPoints(path, {.rate_hz = 50});
}

// Of programs whose files lake does not write.
const std::map<std::string, std::string> kTexts = {
    {"dltdv.csv", "pt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y\n1,2,3,4\nNaN,NaN,5,6\n7,8,9,10\n"},
    {"xypts.tsv", "row\tcolumn\tvalue\n3\t2\t0\n1\t1\t10.5\n1\t2\t20\n2\t1\t11\n2\t2\t21\n"},
    {"deeplabcut.csv",
     "scorer,S,S,S\nbodyparts,knee,knee,knee\ncoords,x,y,likelihood\n0,100.5,90.2,0.99\n1,100.6,90.2,0.99\n"},
    {"sleap.csv", "track,frame_idx,instance.score,knee.x,knee.y,knee.score\n,0,0.9,10,20,0.8\n,2,0.9,11,21,0.7\n"},
    {"motive.csv",
     "Format Version,1.23,Length Units,Meters\n\n,Type,Marker,Marker,Marker\n,Name,a,a,a\n,ID,1,1,1\n"
     ",,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n0,0.000,0.1,0.2,0.3\n1,0.010,0.1,0.2,0.4\n"},
    {"kinovea.txt", "#Kinovea Trajectory data export\n#T X Y\n\n# ankle\n0.000 77,20 -21,97 \n0.008 77,19 -21,96 \n"}};

class DamagedFiles : public testing::TestWithParam<const char*> {
 protected:
  fs::path WriteSample() const {
    const std::string name = GetParam();
    const fs::path path = folder_ / name;
    const bool in_image = name.ends_with(".trk") || name.ends_with(".kva") || name.ends_with(".trz");
    const exchange::PointRecording points =
        MakePoints(in_image ? exchange::PointSpace::kImage : exchange::PointSpace::kPlane, 12, 3, 6);
    if (name.ends_with(".mot"))
      exchange::WriteMot(path, {"knee", true, {"a", "b"}, {0, 0.1, 0.2}, {{1, 2}, {3, std::nan("")}, {5, 6}}});
    else if (const auto text = kTexts.find(name); text != kTexts.end())
      WriteFile(path, text->second);
    else if (name.ends_with(".trz")) {
      exchange::WritePoints(folder_ / "inner.trk", points);
      WriteZip(path, "inner.trk", ReadTextFile(folder_ / "inner.trk"));
    } else
      exchange::WritePoints(path, points);
    return path;
  }

  // Whether it was refused.
  bool Refuses(const std::string& bytes) const {
    const fs::path path = WriteFile(folder_ / (std::string("bad_") + GetParam()), bytes);
    try {
      ReadAny(path);
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      return true;
    }
    return false;
  }

  TemporaryFolder folder_;
};

TEST_P(DamagedFiles, NeverCrash) {
  const std::string good = ReadTextFile(WriteSample());
  EXPECT_FALSE(Refuses(good));
  std::mt19937 random(6);
  int refused = 0;
  for (int round = 0; round < 1500; ++round) {
    std::string bad = good;
    // The head decides most, so half of the changes go there.
    for (int i = 0; i < 3; ++i)
      bad[random() % (i % 2 ? bad.size() : std::min<std::size_t>(bad.size(), 800))] = static_cast<char>(random());
    if (round % 4 == 0) bad.resize(random() % bad.size());
    if (round % 7 == 0) bad.insert(random() % (bad.size() + 1), bad.substr(random() % (bad.size() + 1), 60));
    refused += Refuses(bad) ? 1 : 0;
  }
  EXPECT_GT(refused, 30);
}

TEST_P(DamagedFiles, NumbersThatAskForTooMuchAreRefusedOrRead) {
  const std::string good = ReadTextFile(WriteSample());
  for (const char* number :
       {"99999999999", "-1", "1e308", "4294967295", "nan", "inf", "1e-320", "18446744073709551616"})
    for (std::size_t at = good.find_first_of("0123456789"); at < std::min<std::size_t>(good.size(), 3000);
         at = good.find_first_of("0123456789", good.find_first_not_of("0123456789.", at))) {
      std::string bad = good;
      bad.replace(at, good.find_first_not_of("0123456789.", at) - at, number);
      Refuses(bad);
    }
}

TEST_P(DamagedFiles, CutAnywhereNeverCrash) {
  const std::string good = ReadTextFile(WriteSample());
  for (std::size_t size = 0; size < good.size(); size += 1 + good.size() / 400) Refuses(good.substr(0, size));
  EXPECT_TRUE(Refuses(""));
}

INSTANTIATE_TEST_SUITE_P(, DamagedFiles,
                         testing::Values("a.trc", "a.c3d", "a.txt", "a.trk", "a.trz", "a_kinovea.csv", "a.kva",
                                         "lake.csv", "dltdv.csv", "xypts.tsv", "deeplabcut.csv", "sleap.csv",
                                         "motive.csv", "kinovea.txt", "a.mot"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

}  // namespace
}  // namespace lake
