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
  PointRecording points = MakePoints(PointSpace::kSpace, kFrames, kPoints, 2);
  points.up_axis = 'y';
  for (double& time : points.time_s) time += 0.5;  // 60 frames of 120 Hz
  WriteC3d(folder / "a.c3d", points);
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
  const PointRecording read = ReadC3d(folder / "a.c3d");
  EXPECT_EQ(read.frame.front(), 60);
  ExpectSame(points, read, 1e-3);
}

TEST(C3dRules, HeadersThatLieAreRefusedBeforeAnythingIsAllocated) {
  const TemporaryFolder folder;
  WriteC3d(folder / "a.c3d", MakePoints(PointSpace::kSpace, 20, 3, 5));
  const std::string good = ReadTextFile(folder / "a.c3d");
  const auto message_with = [&](const char* name, const std::string& data) {
    std::string bad = good;
    const std::size_t at = bad.find(name) + std::strlen(name) + 4;  // behind offset, type and number of dimensions
    bad.replace(at, data.size(), data);
    return MessageOf([&] { ReadC3d(WriteFile(folder / "e.c3d", bad)); });
  };
  EXPECT_THAT(message_with("\4\1USED", std::string("\0\0", 2)), testing::HasSubstr("no points"));
  EXPECT_THAT(message_with("\4\1USED", "\xFF\xFF"), testing::HasSubstr("cut off"));
  // Infinity and NaN, little-endian.
  EXPECT_THAT(message_with("\4\1RATE", std::string("\0\0\x80\x7F", 4)), testing::HasSubstr("POINT:RATE"));
  EXPECT_THAT(message_with("\5\1SCALE", std::string("\0\0\xC0\x7F", 4)), testing::HasSubstr("POINT:SCALE"));
  std::string frames = good;
  const std::size_t end_field = frames.find("ACTUAL_END_FIELD") + 16 + 5;
  frames.replace(end_field, 4, "\xFF\xFF\xFF\xFF");
  EXPECT_THAT(MessageOf([&] { ReadC3d(WriteFile(folder / "e.c3d", frames)); }), testing::HasSubstr("cut off"));
}

}  // namespace
}  // namespace lake
