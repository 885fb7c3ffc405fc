// A C3D file of ours, field by field against the rules of the format's user guide (c3d.org), read here on its own.
#include <gmock/gmock.h>

#include <cstring>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

struct Parameter {
  int type = 0;
  std::vector<int> dimensions;
  std::string data;
};

struct C3dFile {
  std::string bytes;

  int Byte(std::size_t at) const { return static_cast<unsigned char>(bytes.at(at)); }
  int SignedByte(std::size_t at) const { return static_cast<signed char>(bytes.at(at)); }
  int Word(std::size_t at) const { return Byte(at) + 256 * Byte(at + 1); }
  float Float(std::size_t at) const {
    float value = 0;
    std::memcpy(&value, bytes.data() + at, 4);  // the tests run on little-endian machines
    return value;
  }
};

// The guide's walk through the parameter section.
std::map<std::string, Parameter> Walk(const C3dFile& file) {
  std::map<int, std::string> groups;
  std::map<std::string, Parameter> parameters;
  const std::size_t section = 512, end = section + 512 * static_cast<std::size_t>(file.Byte(section + 2));
  std::size_t at = section + 4;
  while (file.SignedByte(at) != 0) {
    const auto length = static_cast<std::size_t>(std::abs(file.SignedByte(at)));
    const int id = file.SignedByte(at + 1);
    const std::string name = file.bytes.substr(at + 2, length);
    const std::size_t offset_at = at + 2 + length;
    const auto offset = static_cast<std::size_t>(file.Word(offset_at));
    if (id < 0) {
      groups[-id] = name;
      EXPECT_EQ(offset, 3u + static_cast<std::size_t>(file.Byte(offset_at + 2))) << name;  // word, length, description
    } else {
      EXPECT_TRUE(groups.contains(id)) << name << " stands before its group";
      Parameter parameter;
      parameter.type = file.SignedByte(offset_at + 2);
      const int dimensions = file.Byte(offset_at + 3);
      std::size_t size = static_cast<std::size_t>(std::abs(parameter.type));
      for (int d = 0; d < dimensions; ++d) {
        parameter.dimensions.push_back(file.Byte(offset_at + 4 + static_cast<std::size_t>(d)));
        size *= static_cast<std::size_t>(parameter.dimensions.back());
      }
      const std::size_t data = offset_at + 4 + static_cast<std::size_t>(dimensions);
      parameter.data = file.bytes.substr(data, size);
      const auto description = static_cast<std::size_t>(file.Byte(data + size));
      EXPECT_EQ(offset_at + offset, data + size + 1 + description) << name << ": the pointer to the next entry";
      parameters[groups[id] + ":" + name] = parameter;
    }
    at = offset_at + offset;
    EXPECT_LT(at, end);
    if (at >= end) break;
  }
  return parameters;
}

int WordOf(const Parameter& parameter, std::size_t i = 0) {
  return static_cast<unsigned char>(parameter.data.at(2 * i)) +
         256 * static_cast<unsigned char>(parameter.data.at(2 * i + 1));
}

TEST(C3dRules, EveryFieldOfAFileOfOurs) {
  const TemporaryFolder folder;
  constexpr std::size_t kFrames = 50, kPoints = 4;
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, kFrames, kPoints, 2);
  points.up_axis = 'y';
  for (double& time : points.time_s) time += 0.5;  // 60 frames of 120 Hz
  exchange::WriteC3d(folder / "a.c3d", points);
  const C3dFile file{ReadTextFile(folder / "a.c3d")};
  EXPECT_EQ(file.bytes.size() % 512, 0u);
  // The header: parameter block, 0x50, points, analogue samples, first and last frame, gap, scale, data block, rate.
  EXPECT_EQ(file.Byte(0), 2);
  EXPECT_EQ(file.Byte(1), 0x50);
  EXPECT_EQ(file.Word(2), static_cast<int>(kPoints));
  EXPECT_EQ(file.Word(4), 0);
  EXPECT_EQ(file.Word(6), 61);
  EXPECT_EQ(file.Word(8), 110);
  EXPECT_EQ(file.Float(12), -1.0f);
  EXPECT_EQ(file.Float(20), 120.0f);
  // The parameter section's own header: its blocks, Intel.
  EXPECT_EQ(file.Byte(515), 84);
  const std::size_t blocks = static_cast<std::size_t>(file.Byte(514)), data = 512 * (1 + blocks);
  EXPECT_EQ(static_cast<std::size_t>(file.Word(16)), 2 + blocks);

  const auto parameters = Walk(file);
  EXPECT_EQ(WordOf(parameters.at("POINT:USED")), static_cast<int>(kPoints));
  EXPECT_EQ(WordOf(parameters.at("POINT:FRAMES")), static_cast<int>(kFrames));
  EXPECT_EQ(WordOf(parameters.at("POINT:DATA_START")), file.Word(16));
  EXPECT_EQ(parameters.at("POINT:SCALE").type, 4);
  EXPECT_EQ(parameters.at("POINT:RATE").type, 4);
  EXPECT_EQ(parameters.at("POINT:UNITS").data, "mm");
  EXPECT_EQ(parameters.at("POINT:Y_SCREEN").data, "+Y");
  EXPECT_EQ(WordOf(parameters.at("ANALOG:USED")), 0);
  EXPECT_EQ(WordOf(parameters.at("TRIAL:ACTUAL_START_FIELD")), 61);
  EXPECT_EQ(WordOf(parameters.at("TRIAL:ACTUAL_END_FIELD")), 110);
  const Parameter& labels = parameters.at("POINT:LABELS");
  EXPECT_EQ(labels.type, -1);
  ASSERT_EQ(labels.dimensions, (std::vector<int>{8, static_cast<int>(kPoints)}));
  EXPECT_EQ(labels.data.substr(8, 8), "marker 2");

  // The data: x, y, z and a residual, −1 where the point is missing.
  ASSERT_GE(file.bytes.size(), data + kFrames * kPoints * 16);
  for (std::size_t i = 0; i < kFrames; ++i)
    for (std::size_t p = 0; p < kPoints; ++p) {
      const std::size_t at = data + 16 * (i * kPoints + p);
      const Eigen::Vector3d& written = points.points[p].positions[i];
      EXPECT_EQ(file.Float(at + 12), written.allFinite() ? 0.0f : -1.0f);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(file.Float(at + 4 * axis),
                  written.allFinite() ? static_cast<float>(written[static_cast<int>(axis)]) : 0.0f);
    }
  const exchange::PointRecording read = exchange::ReadC3d(folder / "a.c3d");
  EXPECT_EQ(read.frame.front(), 60);
  ExpectSame(points, read, 1e-3);
}

exchange::PointRecording WithEvents() {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 20, 3, 7);
  points.events = {{0.25, "Left", "Foot Strike"}, {61.5, "General", "seat_off"}, {179.875, "", "x"}};
  return points;
}

TEST(C3dRules, EventsAreMinutesAndSecondsInAGroupOfTheirOwn) {
  const TemporaryFolder folder;
  const exchange::PointRecording points = WithEvents();
  exchange::WriteC3d(folder / "a.c3d", points);
  const C3dFile file{ReadTextFile(folder / "a.c3d")};
  const auto parameters = Walk(file);
  EXPECT_EQ(WordOf(parameters.at("EVENT:USED")), 3);
  const Parameter& times = parameters.at("EVENT:TIMES");
  EXPECT_EQ(times.type, 4);
  EXPECT_EQ(times.dimensions, (std::vector<int>{2, 3}));
  EXPECT_EQ((C3dFile{times.data}.Float(8)), 1.0f);
  EXPECT_EQ((C3dFile{times.data}.Float(12)), 1.5f);
  EXPECT_EQ(parameters.at("EVENT:LABELS").data, "Foot Strikeseat_off   x          ");
  EXPECT_EQ(parameters.at("EVENT:CONTEXTS").dimensions, (std::vector<int>{7, 3}));
  // Contexts are chosen from a list.
  EXPECT_EQ(WordOf(parameters.at("EVENT_CONTEXT:USED")), 3);
  EXPECT_EQ(parameters.at("EVENT_CONTEXT:LABELS").data, "       GeneralLeft   ");

  const exchange::PointRecording read = exchange::ReadC3d(folder / "a.c3d");
  ASSERT_EQ(read.events.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.events[i].time_s, points.events[i].time_s);  // all whole in single precision
    EXPECT_EQ(read.events[i].context, points.events[i].context);
    EXPECT_EQ(read.events[i].label, points.events[i].label);
  }
}

// Points have whole frames for times, and events keep their places among them.
TEST(C3dRules, EventsMoveWithThePointsToWholeFrames) {
  const TemporaryFolder folder;
  for (const double start_s : {0.5 / 120, -2.0, 1000.0}) {
    exchange::PointRecording points = WithEvents();
    for (double& time : points.time_s) time += start_s;
    for (exchange::PointEvent& event : points.events) event.time_s += start_s;
    exchange::WriteC3d(folder / "a.c3d", points);
    const exchange::PointRecording read = exchange::ReadC3d(folder / "a.c3d");
    for (std::size_t i = 0; i < points.events.size(); ++i)
      EXPECT_NEAR(read.events[i].time_s - read.time_s.front(), points.events[i].time_s - points.time_s.front(), 1e-5)
          << start_s;
  }
}

TEST(C3dRules, LongTextsOfEventsAreCutBetweenLetters) {
  const TemporaryFolder folder;
  exchange::PointRecording points = WithEvents();
  points.events[0].label.assign(126, 'a');
  points.events[0].label += "ä";
  exchange::WriteC3d(folder / "a.c3d", points);
  EXPECT_EQ(exchange::ReadC3d(folder / "a.c3d").events[0].label, std::string(126, 'a'));
}

// Five of each of 60 sit-to-stands. A dimension of an array is a byte; the list goes on in a second parameter.
TEST(C3dRules, MoreEventsThanOneArrayHoldsGoOnInTheNext) {
  const TemporaryFolder folder;
  exchange::PointRecording points = WithEvents();
  points.events.clear();
  for (int i = 0; i < 300; ++i) points.events.push_back({i / 4.0, "General", "event " + std::to_string(i)});
  exchange::WriteC3d(folder / "a.c3d", points);
  const auto parameters = Walk({ReadTextFile(folder / "a.c3d")});
  EXPECT_EQ(WordOf(parameters.at("EVENT:USED")), 300);
  for (const char* name : {"EVENT:TIMES", "EVENT:LABELS", "EVENT:CONTEXTS"}) {
    EXPECT_EQ(parameters.at(name).dimensions[1], 255) << name;
    EXPECT_EQ(parameters.at(std::string(name) + "2").dimensions[1], 45) << name;
    EXPECT_EQ(parameters.at(std::string(name) + "2").dimensions[0], parameters.at(name).dimensions[0]) << name;
  }
  const exchange::PointRecording read = exchange::ReadC3d(folder / "a.c3d");
  ASSERT_EQ(read.events.size(), 300u);
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(read.events[i].time_s, points.events[i].time_s);
    EXPECT_EQ(read.events[i].label, points.events[i].label);
    EXPECT_EQ(read.events[i].context, "General");
  }
}

TEST(C3dRules, MoreNamesThanTheSectionHoldsAreRefused) {
  const TemporaryFolder folder;
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 2, 1100, 7);
  for (exchange::PointTrack& point : points.points) point.name += std::string(110, 'n');
  EXPECT_THAT(MessageOf([&] { exchange::WriteC3d(folder / "a.c3d", points); }),
              testing::HasSubstr("names and events take"));
}

// Their times count from the first frame stored, here frame 61 of 120 Hz; those of the group from frame 1.
TEST(C3dRules, EventsOfTheHeaderCountFromTheFirstFrameStored) {
  const TemporaryFolder folder;
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 20, 3, 7);
  for (double& time : points.time_s) time += 0.5;
  points.events = {{0.75, "Left", "Foot Strike"}};
  exchange::WriteC3d(folder / "a.c3d", points);
  std::string bytes = ReadTextFile(folder / "a.c3d");
  const auto put_word = [&](std::size_t word, int value) {  // counted from 1, as the guide does
    bytes[2 * word - 2] = static_cast<char>(value % 256), bytes[2 * word - 1] = static_cast<char>(value / 256);
  };
  const auto put_event = [&](std::size_t i, float time_s, const char* label) {
    std::memcpy(&bytes[2 * (153 + 2 * i) - 2], &time_s, 4);
    bytes.replace(2 * (199 + 2 * i) - 2, 4, label, 4);
  };
  put_word(150, 12345);
  put_word(151, 2);
  put_event(0, 1.25f, "LTO ");
  put_event(1, 0.25f, "LHS ");  // the second is the group's own
  exchange::PointRecording read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  ASSERT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.events[0].label, "Foot Strike");
  EXPECT_EQ(read.events[0].time_s, 0.75);
  EXPECT_EQ(read.events[1].label, "LTO");
  EXPECT_EQ(read.events[1].time_s, 1.75);
  bytes[bytes.find("\4\4USED") + 10] = 0;  // an empty group
  read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  ASSERT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.events[0].label, "LHS");
  put_word(151, 65535);  // more than there is room for
  read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  EXPECT_TRUE(read.events.empty());
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], testing::HasSubstr("65535 events"));
  bytes[bytes.find("\4\4USED") + 10] = 1;  // those of the group are read all the same
  read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  ASSERT_EQ(read.events.size(), 1u);
  EXPECT_EQ(read.events[0].label, "Foot Strike");
}

TEST(C3dRules, EventsThatAreDamagedAreLeftOutWithAWarning) {
  const TemporaryFolder folder;
  exchange::WriteC3d(folder / "a.c3d", WithEvents());
  std::string bytes = ReadTextFile(folder / "a.c3d");
  bytes[bytes.find("\4\4USED") + 10] = 9;  // behind name, offset, type and number of dimensions
  const exchange::PointRecording read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  EXPECT_TRUE(read.events.empty());
  EXPECT_EQ(read.points.size(), 3u);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], testing::HasSubstr("EVENT:USED is 9, but there are 3 times"));
}

// The last entry points to what lies behind the section, whose length stands at its beginning.
TEST(C3dRules, ParametersEndWithTheirSection) {
  const TemporaryFolder folder;
  const exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 20, 3, 5);
  exchange::WriteC3d(folder / "a.c3d", points);
  std::string bytes = ReadTextFile(folder / "a.c3d");
  const std::size_t end = 512 + 512 * static_cast<std::size_t>(bytes[514]);
  const std::size_t pointer = bytes.find("\12\1DATA_START") + 12;
  bytes[pointer] = static_cast<char>((end - pointer) & 0xFF);
  bytes[pointer + 1] = static_cast<char>((end - pointer) >> 8);
  bytes.replace(end, 16, std::string("\4\1WXYZ\7\0\2\11\7\0\0\0\0\0", 16));
  exchange::PointRecording read = exchange::ReadC3d(WriteFile(folder / "b.c3d", bytes));
  EXPECT_EQ(read.points.size(), 3u);
  EXPECT_EQ(read.points[0].name, points.points[0].name);
  EXPECT_TRUE(read.warnings.empty());
}

// 16 bits hold a count up to 65535; the parameters that say it in 32 bits may be missing.
TEST(C3dRules, MoreFramesThanSixteenBitsCountAreAllRead) {
  const TemporaryFolder folder;
  const exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 70'000, 1, 0);
  exchange::WriteC3d(folder / "a.c3d", points);
  ExpectSame(points, exchange::ReadC3d(folder / "a.c3d"), 1e-3);
  std::string header = ReadTextFile(folder / "a.c3d");
  for (const char* name : {"ACTUAL_START_FIELD", "ACTUAL_END_FIELD"}) header[header.find(name)] = 'X';
  const exchange::PointRecording cut = exchange::ReadC3d(WriteFile(folder / "b.c3d", header));
  ExpectSame(points, cut, 1e-3);
  EXPECT_THAT(cut.warnings, testing::ElementsAre(testing::HasSubstr(
                                "frames: 65535 by the header, 65535 by POINT:FRAMES, 70000 in the file")));
}

TEST(C3dRules, HeadersThatLieAreRefusedBeforeAnythingIsAllocated) {
  const TemporaryFolder folder;
  exchange::WriteC3d(folder / "a.c3d", MakePoints(exchange::PointSpace::kSpace, 20, 3, 5));
  const std::string good = ReadTextFile(folder / "a.c3d");
  const auto message_with = [&](const char* name, std::size_t header, const std::string& data) {
    std::string bad = good;
    const std::size_t at = bad.find(name) + std::strlen(name) + 4;  // behind offset, type and number of dimensions
    bad.replace(at, data.size(), data).replace(header, data.size(), data);
    return MessageOf([&] { exchange::ReadC3d(WriteFile(folder / "e.c3d", bad)); });
  };
  // Each in its parameter and in the header; infinity and NaN are little-endian.
  EXPECT_THAT(message_with("\4\1USED", 2, std::string("\0\0", 2)), testing::HasSubstr("holds no frame of points"));
  EXPECT_THAT(message_with("\4\1USED", 2, "\xFF\xFF"), testing::HasSubstr("of 65535 points are stated"));
  EXPECT_THAT(message_with("\4\1RATE", 20, std::string("\0\0\x80\x7F", 4)), testing::HasSubstr("POINT:RATE"));
  EXPECT_EQ(message_with("\5\1SCALE", 12, std::string("\0\0\xC0\x7F", 4)), "");
  EXPECT_THAT(exchange::ReadC3d(folder / "e.c3d").warnings,
              testing::ElementsAre(testing::HasSubstr("scale: not stated, floats in the file")));
  std::string frames = good;
  for (const char* name : {"ACTUAL_START_FIELD", "\6\1FRAMES"}) frames[frames.find(name) + 3] = 'X';
  frames.replace(8, 2, "\xFF\xFE");
  const std::size_t end_field = frames.find("ACTUAL_END_FIELD") + 16 + 5;
  frames.replace(end_field, 4, "\xFF\xFF\xFF\xFF");
  const exchange::PointRecording read = exchange::ReadC3d(WriteFile(folder / "e.c3d", frames));
  EXPECT_LE(read.time_s.size(), good.size() / 48);  // of three points
  EXPECT_THAT(read.warnings, testing::Contains(testing::HasSubstr("frames")));
}

}  // namespace
}  // namespace lake
