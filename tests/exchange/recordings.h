// Recordings to write and read back, for the tests of the formats.
#pragma once

#include <gtest/gtest.h>
#include <zip.h>

#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>

#include "lake/core/error.h"
#include "lake/exchange/point_recording.h"
#include "message_of.h"

namespace lake {

inline exchange::PointRecording MakePoints(exchange::PointSpace space, std::size_t frames, std::size_t points,
                                           unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> position(-1500, 1500);
  exchange::PointRecording recording;
  recording.space = space;
  recording.events = {{0.025, "Left", "Foot Strike"}, {0.05, "General", "seat_off"}};  // where the format has them
  for (std::size_t i = 0; i < frames; ++i)
    recording.frame.push_back(static_cast<std::int64_t>(i)), recording.time_s.push_back(static_cast<double>(i) / 120);
  for (std::size_t p = 0; p < points; ++p) {
    recording.points.push_back({"marker " + std::to_string(p + 1), {}});
    for (std::size_t i = 0; i < frames; ++i) {
      Eigen::Vector3d place{position(random), position(random),
                            space == exchange::PointSpace::kSpace ? position(random) : 0};
      // The first and the last marker are missing now and then, also at the end of a row.
      if ((p == 0 || p + 1 == points) && i % 7 == 3) place = exchange::PointTrack::Missing();
      recording.points.back().positions.push_back(place);
    }
  }
  return recording;
}

inline void ExpectSame(const exchange::PointRecording& a, const exchange::PointRecording& b, double tolerance) {
  ASSERT_EQ(a.points.size(), b.points.size());
  ASSERT_EQ(a.time_s.size(), b.time_s.size());
  for (std::size_t i = 0; i < a.time_s.size(); ++i) EXPECT_NEAR(a.time_s[i], b.time_s[i], 1e-6);
  for (std::size_t p = 0; p < a.points.size(); ++p) {
    EXPECT_EQ(a.points[p].name, b.points[p].name);
    ASSERT_EQ(a.points[p].positions.size(), b.points[p].positions.size());
    for (std::size_t i = 0; i < a.time_s.size(); ++i) {
      const Eigen::Vector3d &x = a.points[p].positions[i], &y = b.points[p].positions[i];
      ASSERT_EQ(x.allFinite(), y.allFinite()) << a.points[p].name << " frame " << i;
      EXPECT_TRUE(!x.allFinite() || (x - y).norm() <= tolerance) << x.transpose() << ", " << y.transpose();
    }
  }
}

// The error of a reader, or the warnings of what it read.
inline std::string SaidOf(const std::function<std::vector<std::string>()>& read) {
  std::string said;
  const std::string error = MessageOf([&] {
    for (const std::string& warning : read()) said += warning + "; ";
  });
  return said.empty() ? error : said;
}

// Anew, as file systems write to the disk at once what was cut to nothing and is written again: thousands of damaged
// files would wait for it.
inline std::filesystem::path WriteFile(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

// A zip archive with one entry.
inline void WriteZip(const std::filesystem::path& path, const std::string& name, const std::string& content) {
  std::filesystem::remove(path);
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE, nullptr);
  zip_source_t* source = zip_source_buffer(archive, content.data(), content.size(), 0);
  if (!archive || zip_file_add(archive, name.c_str(), source, 0) < 0 || zip_close(archive) != 0)
    throw std::runtime_error("the zip archive cannot be written");
}

}  // namespace lake
