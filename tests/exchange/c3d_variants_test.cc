// C3D files as other programs write them, with the blemishes of the format's public samples and of its readers' lists
// of faults. They are made here by the user guide (c3d.org), so that what they hold is known independently of the
// reader.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "lake/exchange/c3d.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

struct Entry {
  std::string group, name;
  int type = 4;  // −1 text, 1 byte, 2 integer, 4 float
  std::vector<int> dimensions;
  std::vector<double> numbers;
  std::vector<std::string> texts;  // of dimensions[0] bytes each
};

// What is stored for each point and frame is `Stored`, times the scale; missing where IsMissing.
struct C3dMaker {
  int processor = 84;
  bool is_float = true;
  int points = 3, frames = 40, channels = 0, samples = 4, first = 1;
  double scale = 0.125, rate_hz = 100;  // exact in single precision
  double missing_residual = -1;
  std::vector<Entry> entries;
  // Of the header, where it is not as the data are.
  std::optional<double> h_points, h_analog, h_first, h_last, h_scale, h_block, h_samples, h_rate;
  std::optional<int> section_blocks, stated_processor;
  int parameter_block = 2, zeros_before = 0, behind = 0, spare_blocks = 0;
  bool is_padded = true, groups_last = false;
  int name_sign = 1;  // −1: locked
  std::vector<std::string> labels, read_labels;

  static double Stored(int point, int frame, int axis) {
    const int values[] = {100 * point + frame % 1000, point - 2 * (frame % 500), 500 + frame % 7};
    return values[axis];
  }
  static bool IsMissing(int point, int frame) { return (point + frame) % 7 == 6; }
  int Analog() const { return channels * samples; }

  void Add(const std::string& group, const std::string& name, int type, std::vector<double> numbers) {
    std::vector<int> dimensions;
    if (numbers.size() > 1) dimensions.push_back(static_cast<int>(numbers.size()));
    entries.push_back({group, name, type, dimensions, std::move(numbers), {}});
  }
  void AddTexts(const std::string& group, const std::string& name, const std::vector<std::string>& texts, char pad) {
    std::size_t length = 1;
    for (const std::string& text : texts) length = std::max(length, text.size());
    std::vector<std::string> padded;
    for (const std::string& text : texts) padded.push_back(text + std::string(length - text.size(), pad));
    entries.push_back({group, name, -1, {static_cast<int>(length), static_cast<int>(texts.size())}, {}, padded});
  }
  Entry* Find(const std::string& name) {
    for (Entry& entry : entries)
      if (entry.group + ":" + entry.name == name) return &entry;
    throw std::runtime_error(name);
  }
  void Remove(const std::string& name) {
    std::erase_if(entries, [&](const Entry& entry) { return entry.group + ":" + entry.name == name; });
  }
  void Fill() {
    Add("POINT", "USED", 2, {static_cast<double>(points)});
    Add("POINT", "FRAMES", 2, {static_cast<double>(std::min(frames, 65535))});
    Add("POINT", "DATA_START", 2, {0});  // set when the section is written
    Add("POINT", "SCALE", 4, {is_float ? -scale : scale});
    Add("POINT", "RATE", 4, {rate_hz});
    AddTexts("POINT", "UNITS", {"mm"}, ' ');
    if (labels.empty())
      for (int p = 0; p < points; ++p) labels.push_back("M" + std::to_string(p + 1));
    read_labels = labels;
    AddTexts("POINT", "LABELS", {labels.begin(), labels.begin() + std::min(points, 255)}, ' ');
    if (points > 255) AddTexts("POINT", "LABELS2", {labels.begin() + 255, labels.end()}, ' ');
    Add("ANALOG", "USED", 2, {static_cast<double>(channels)});
    if (channels > 0) Add("ANALOG", "RATE", 4, {rate_hz * samples});
  }

  std::string Word(double value) const {
    const auto bits = static_cast<std::uint16_t>(static_cast<std::int64_t>(value));
    const char low = static_cast<char>(bits & 0xFF), high = static_cast<char>(bits >> 8);
    return processor == 86 ? std::string{high, low} : std::string{low, high};
  }
  // IEEE in either order of bytes; DEC's exponent is larger by two, and its high word stands first.
  std::string Float(double value) const {
    const auto stored = static_cast<float>(processor == 85 ? 4 * value : value);
    char bytes[4];
    std::memcpy(bytes, &stored, 4);
    if (processor == 86) return {bytes[3], bytes[2], bytes[1], bytes[0]};
    if (processor == 85) return {bytes[2], bytes[3], bytes[0], bytes[1]};
    return {bytes, 4};
  }
  std::string Named(const std::string& name, int id, const std::string& content) const {
    const char description[] = "what it is";
    const std::string rest = content + static_cast<char>(sizeof description - 1) + description;
    return std::string{static_cast<char>(name_sign * static_cast<int>(name.size())), static_cast<char>(id)} + name +
           Word(2 + static_cast<double>(rest.size())) + rest;
  }
  std::string Section(int data_block) const {
    std::vector<std::string> names;
    std::string groups, parameters;
    for (const Entry& entry : entries) {
      const auto found = std::find(names.begin(), names.end(), entry.group);
      const int id = 3 + 5 * static_cast<int>(found - names.begin());
      if (found == names.end()) {
        names.push_back(entry.group);
        groups += Named(entry.group, -id, "");
      }
      std::string content{static_cast<char>(entry.type), static_cast<char>(entry.dimensions.size())};
      for (const int dimension : entry.dimensions) content += static_cast<char>(dimension);
      for (double number : entry.numbers) {
        if (entry.name == "DATA_START" && number == 0) number = data_block;
        content += entry.type == 4   ? Float(number)
                   : entry.type == 2 ? Word(number)
                                     : std::string(1, static_cast<char>(number));
      }
      for (const std::string& text : entry.texts) content += text;
      parameters += Named(entry.name, id, content);
    }
    return groups_last ? parameters + groups : groups + parameters;
  }
  std::string Bytes() const {
    const auto length = static_cast<int>(Section(0).size()) + 6, blocks = (length + 511) / 512;
    const int data_block = parameter_block + blocks + spare_blocks;
    std::string section = std::string{1, 0x50, static_cast<char>(section_blocks.value_or(blocks)),
                                      static_cast<char>(stated_processor.value_or(processor))} +
                          Section(data_block);
    section.resize(static_cast<std::size_t>(512 * (blocks + spare_blocks)), '\0');
    const double last = std::min(first + frames - 1, 65535);
    std::string header = std::string{static_cast<char>(parameter_block), 0x50} + Word(h_points.value_or(points)) +
                         Word(h_analog.value_or(Analog())) + Word(h_first.value_or(first)) +
                         Word(h_last.value_or(last)) + Word(10) + Float(h_scale.value_or(is_float ? -scale : scale)) +
                         Word(h_block.value_or(data_block)) + Word(h_samples.value_or(channels > 0 ? samples : 0)) +
                         Float(h_rate.value_or(rate_hz));
    header.resize(static_cast<std::size_t>(512 * (parameter_block - 1)), '\0');
    std::string data;
    const auto put = [&](double stored, double factor) { data += is_float ? Float(stored * factor) : Word(stored); };
    for (int f = 0; f < frames; ++f) {
      for (int p = 0; p < points; ++p) {
        for (int axis = 0; axis < 3; ++axis) put(Stored(p, f, axis), scale);
        put(IsMissing(p, f) ? missing_residual : 3, 1);
      }
      for (int a = 0; a < Analog(); ++a) put(17 + a, 1);
    }
    if (is_padded) data.resize((data.size() + 511) / 512 * 512, '\0');
    return std::string(static_cast<std::size_t>(zeros_before), '\0') + header + section + data +
           std::string(static_cast<std::size_t>(behind), 'x');
  }
};

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
