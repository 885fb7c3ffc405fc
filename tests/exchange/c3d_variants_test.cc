// C3D files as other programs write them, with the blemishes of the format's public samples and of its readers' lists
// of faults.

#include "c3d_maker.h"
#include "lake/exchange/c3d.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

struct Variant {
  const char* name;
  void (*before)(C3dMaker&);  // the sizes
  void (*after)(C3dMaker&);   // the statements on them
  double mm_per_unit = 1;
};
void Nothing(C3dMaker&) {}
void WithAnalog(C3dMaker& c) {
  c.channels = 6;
}
void Long(C3dMaker& c) {
  c.points = 1, c.frames = 70'000;
}

const Variant kVariants[] = {
    {"plain", Nothing, Nothing},
    {"analogue channels", WithAnalog, Nothing},
    {"a crop", [](C3dMaker& c) { c.first = 200; }, Nothing},
    {"frames from 0", Nothing, [](C3dMaker& c) { c.h_first = 0, c.h_last = c.frames - 1; }},
    {"no scale", Nothing, [](C3dMaker& c) { c.Remove("POINT:SCALE"); }},
    {"scale of the header 0", Nothing, [](C3dMaker& c) { c.h_scale = 0; }},
    {"no rate", Nothing, [](C3dMaker& c) { c.Remove("POINT:RATE"); }},
    {"rate of the header 0", Nothing, [](C3dMaker& c) { c.h_rate = 0; }},
    {"no number of points", Nothing, [](C3dMaker& c) { c.Remove("POINT:USED"); }},
    {"no number of frames", Nothing, [](C3dMaker& c) { c.Remove("POINT:FRAMES"); }},
    {"frames are 0", Nothing, [](C3dMaker& c) { c.Find("POINT:FRAMES")->numbers = {0}; }},
    {"frames of the header are 0", Nothing, [](C3dMaker& c) { c.h_first = c.h_last = 0; }},
    {"parameters are 0", Nothing,
     [](C3dMaker& c) {
       for (const char* name : {"POINT:USED", "POINT:SCALE", "POINT:RATE"}) c.Find(name)->numbers = {0};
     }},
    {"no first block", Nothing, [](C3dMaker& c) { c.Remove("POINT:DATA_START"); }},
    {"first block of the header 0", Nothing, [](C3dMaker& c) { c.h_block = 0; }},
    {"points of the header", WithAnalog, [](C3dMaker& c) { c.h_points = 30; }},
    {"analogue words of the header count the channels", WithAnalog, [](C3dMaker& c) { c.h_analog = c.channels; }},
    {"no analogue samples in the header", WithAnalog, [](C3dMaker& c) { c.h_samples = 0; }},
    {"no analogue rate", WithAnalog, [](C3dMaker& c) { c.Remove("ANALOG:RATE"); }},
    {"no analogue group", WithAnalog, [](C3dMaker& c) { c.Remove("ANALOG:RATE"), c.Remove("ANALOG:USED"); }},
    {"the section states no length", Nothing, [](C3dMaker& c) { c.section_blocks = 0; }},
    {"the section states half its length", [](C3dMaker& c) { c.points = 200; },
     [](C3dMaker& c) { c.section_blocks = 1; }},
    {"the section states too much", Nothing, [](C3dMaker& c) { c.section_blocks = 255; }},
    {"blocks between section and data", Nothing, [](C3dMaker& c) { c.spare_blocks = 3; }},
    {"a block between header and section", Nothing, [](C3dMaker& c) { c.parameter_block = 4; }},
    {"locked entries", Nothing, [](C3dMaker& c) { c.name_sign = -1; }},
    {"groups behind their parameters", Nothing, [](C3dMaker& c) { c.groups_last = true; }},
    {"names in small letters, with blanks", Nothing,
     [](C3dMaker& c) {
       c.Find("POINT:USED")->name = "used  ";
       c.Find("POINT:LABELS")->name = "Labels";
     }},
    {"no labels", Nothing,
     [](C3dMaker& c) {
       c.Remove("POINT:LABELS"), c.read_labels = {"point1", "point2", "point3"};
     }},
    {"labels that are empty or doubled",
     [](C3dMaker& c) {
       c.labels = {"", "A", "A"};
     },
     [](C3dMaker& c) {
       c.read_labels = {"point1", "A", "A_2"};
     }},
    {"labels with zeros behind", Nothing,
     [](C3dMaker& c) {
       c.Remove("POINT:LABELS"), c.AddTexts("POINT", "LABELS", {"M1", "M2", "M3abcdef"}, '\0'),
           c.read_labels[2] = "M3abcdef";
     }},
    {"labels of Windows",
     [](C3dMaker& c) {
       c.labels = {
           "d\x92"
           "a",
           "\xFC", "c"};
     },
     [](C3dMaker& c) {
       c.read_labels = {"d’a", "ü", "c"};
     }},
    {"more labels than points", Nothing,
     [](C3dMaker& c) {
       c.Remove("POINT:LABELS"), c.AddTexts("POINT", "LABELS", {"M1", "M2", "M3", "M4"}, ' ');
     }},
    {"300 points", [](C3dMaker& c) { c.points = 300; }, Nothing},
    {"metres", [](C3dMaker& c) { c.scale = 1 / 1024.0; }, [](C3dMaker& c) { c.Find("POINT:UNITS")->texts = {"m "}; },
     1000},
    {"METERS", [](C3dMaker& c) { c.scale = 1 / 1024.0; },
     [](C3dMaker& c) { c.Remove("POINT:UNITS"), c.AddTexts("POINT", "UNITS", {"METERS"}, ' '); }, 1000},
    {"no unit", Nothing, [](C3dMaker& c) { c.Remove("POINT:UNITS"); }},
    {"another unit", Nothing, [](C3dMaker& c) { c.Find("POINT:UNITS")->texts = {"??"}; }},
    {"no event times", Nothing, [](C3dMaker& c) { c.Add("EVENT", "USED", 2, {3}); }},
    {"something behind the data", WithAnalog, [](C3dMaker& c) { c.behind = 2000; }},
    {"no padding", Nothing, [](C3dMaker& c) { c.is_padded = false; }},
    {"zeros before the header", Nothing, [](C3dMaker& c) { c.zeros_before = 37; }},
    {"no processor", Nothing, [](C3dMaker& c) { c.stated_processor = 0; }},
    {"a residual without a sign", Nothing, [](C3dMaker& c) { c.missing_residual = 65535; }},
    {"another negative residual", Nothing, [](C3dMaker& c) { c.missing_residual = -256; }},
    {"frames as a float", Nothing, [](C3dMaker& c) { c.Find("POINT:FRAMES")->type = 4; }},
    {"frames of a trial that was cropped later", Nothing,
     [](C3dMaker& c) {
       c.Add("TRIAL", "ACTUAL_START_FIELD", 2, {1, 0});
       c.Add("TRIAL", "ACTUAL_END_FIELD", 2, {900, 0});
     }},
    {"a scale with the wrong sign", Nothing,
     [](C3dMaker& c) {
       c.h_scale = c.is_float ? c.scale : -c.scale;
       c.Find("POINT:SCALE")->numbers = {*c.h_scale};
     }},
    {"a tiny scale of floats", Nothing,
     [](C3dMaker& c) {
       if (!c.is_float) return;
       c.h_scale = -1e-10;
       c.Find("POINT:SCALE")->numbers = {*c.h_scale};
     }},
    {"a rate of the cameras alone", Nothing,
     [](C3dMaker& c) {
       c.Remove("POINT:RATE"), c.h_rate = 0;
       c.Add("TRIAL", "CAMERA_RATE", 4, {c.rate_hz});
     }},
    {"a rate of the channels alone", WithAnalog, [](C3dMaker& c) { c.Remove("POINT:RATE"), c.h_rate = 0; }},
    {"a frame more in the header", Nothing, [](C3dMaker& c) { c.h_last = 41; }},
    {"three frames, twice the points in the header", [](C3dMaker& c) { c.frames = 3; },
     [](C3dMaker& c) { c.h_points = 6; }},
    {"two frames, the kind of numbers contradicted", [](C3dMaker& c) { c.frames = 2; },
     [](C3dMaker& c) { c.h_scale = c.is_float ? 0.1 : -1; }},
    {"65 536 frames", [](C3dMaker& c) { c.points = 1, c.frames = 65'536; }, Nothing},
    {"40 000 frames", [](C3dMaker& c) { c.points = 1, c.frames = 40'000; }, Nothing},
    {"70 000 frames by the file's size", Long, Nothing},
    {"70 000 frames by LONG_FRAMES, something behind", Long,
     [](C3dMaker& c) { c.Add("POINT", "LONG_FRAMES", 4, {70'000}), c.behind = 5000; }},
    {"70 000 frames by TRIAL, something behind", Long,
     [](C3dMaker& c) {
       c.Add("TRIAL", "ACTUAL_START_FIELD", 2, {1, 0});
       c.Add("TRIAL", "ACTUAL_END_FIELD", 2, {70'000 - 65536, 1});
       c.behind = 5000;
     }},
    {"70 000 frames, counted by 16 bits", Long,
     [](C3dMaker& c) { c.h_last = c.Find("POINT:FRAMES")->numbers[0] = 70'000 - 65536; }}};

class C3dVariants : public testing::TestWithParam<Variant> {};

TEST_P(C3dVariants, AreReadAsTheyWereMade) {
  const TemporaryFolder folder;
  for (const int processor : {84, 85, 86})
    for (const bool is_float : {true, false}) {
      SCOPED_TRACE(testing::Message() << "processor " << processor << (is_float ? ", floats" : ", integers"));
      C3dMaker made;
      made.processor = processor;
      made.is_float = is_float;
      GetParam().before(made);
      made.Fill();
      GetParam().after(made);
      exchange::PointRecording read;
      ASSERT_EQ(MessageOf([&] { read = exchange::ReadC3d(WriteFile(folder / "a.c3d", made.Bytes())); }), "");
      ASSERT_EQ(read.points.size(), static_cast<std::size_t>(made.points));
      ASSERT_EQ(read.time_s.size(), static_cast<std::size_t>(made.frames)) << testing::PrintToString(read.warnings);
      EXPECT_NEAR(read.time_s.front(), (made.first - 1) / made.rate_hz, 1e-9);
      EXPECT_NEAR(read.time_s.back(), (made.first + made.frames - 2) / made.rate_hz, 1e-9);
      for (int p = 0; p < made.points; ++p) {
        const exchange::PointTrack& point = read.points[static_cast<std::size_t>(p)];
        EXPECT_EQ(point.name, made.read_labels[static_cast<std::size_t>(p)]);
        for (int f = 0; f<made.frames; f += made.frames> 1000 ? 137 : 1) {
          const Eigen::Vector3d& position = point.positions[static_cast<std::size_t>(f)];
          ASSERT_EQ(position.allFinite(), !C3dMaker::IsMissing(p, f)) << p << ", " << f;
          for (int axis = 0; axis < 3 && position.allFinite(); ++axis)
            ASSERT_NEAR(position[axis], C3dMaker::Stored(p, f, axis) * made.scale * GetParam().mm_per_unit, 1e-9);
        }
      }
    }
}

INSTANTIATE_TEST_SUITE_P(All, C3dVariants, testing::ValuesIn(kVariants), [](const auto& variant) {
  std::string name;
  for (const char c : std::string(variant.param.name)) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace lake
