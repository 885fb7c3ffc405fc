// The rules of BIDS (1.9) and its Motion extension that a derivative of motion data must keep, checked file by file.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {

inline std::vector<std::vector<std::string>> TsvRows(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : SplitText(ReadTextFile(path), '\n'))
    if (!line.empty()) rows.push_back(SplitText(line, '\t'));
  return rows;
}

// One recording: its tables and sidecar, found by the name of its …_motion.tsv.
inline void ExpectMotionHolds(const std::filesystem::path& motion_tsv) {
  const std::string path = motion_tsv.string(), stem = path.substr(0, path.size() - std::string("_motion.tsv").size());
  const std::regex name(
      "sub-[A-Za-z0-9]+(_ses-[A-Za-z0-9]+)?_task-[A-Za-z0-9]+_tracksys-[A-Za-z0-9]+(_acq-[A-Za-z0-9]+)?(_run-[0-9]+)?_"
      "motion.tsv");
  EXPECT_TRUE(std::regex_match(motion_tsv.filename().string(), name)) << motion_tsv;
  EXPECT_EQ(motion_tsv.parent_path().filename(), "motion");

  const auto channels = TsvRows(stem + "_channels.tsv");
  ASSERT_FALSE(channels.empty());
  const std::vector<std::string> required = {"name", "component", "type", "tracked_point", "units"};
  EXPECT_TRUE(std::equal(required.begin(), required.end(), channels[0].begin())) << "columns in this order";
  const std::set<std::string> types = {"ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY",
                                       "MAGN",  "MISC",     "ORNT", "POS",    "VEL"};
  std::set<std::string> names;
  for (std::size_t i = 1; i < channels.size(); ++i) {
    ASSERT_EQ(channels[i].size(), channels[0].size());
    EXPECT_TRUE(names.insert(channels[i][0]).second) << channels[i][0] << " stands twice";
    EXPECT_TRUE(types.contains(channels[i][2])) << channels[i][2];
    EXPECT_EQ(channels[i][1] == "n/a", channels[i][2] != "POS") << "positions have an axis, others none";
  }

  const std::size_t frame =
      static_cast<std::size_t>(std::ranges::find(channels[0], "reference_frame") - channels[0].begin());
  const Json levels = ReadJsonFile(stem + "_channels.json")["reference_frame"]["Levels"];
  for (const auto& [name, level] : levels.items())
    EXPECT_TRUE(std::regex_match(level["SpatialAxes"].get<std::string>(), std::regex("[APLRSI_]{3}"))) << name;
  for (std::size_t i = 1; i < channels.size(); ++i) {
    const std::string& of = channels[i].at(frame);
    EXPECT_TRUE(of == "n/a" || levels.contains(of)) << of;
  }

  const auto samples = TsvRows(motion_tsv);
  ASSERT_FALSE(samples.empty());
  for (const auto& row : samples) {
    ASSERT_EQ(row.size(), channels.size() - 1) << "a column for each channel";
    for (const std::string& cell : row) EXPECT_TRUE(cell == "n/a" || ParseNumber(cell)) << cell << ": no header";
  }
  EXPECT_EQ(samples[0][0], "0") << "latency from the first sample";

  const Json sidecar = ReadJsonFile(stem + "_motion.json");
  for (const char* key : {"TaskName", "TrackingSystemName", "SamplingFrequency"})
    EXPECT_TRUE(sidecar.contains(key)) << key;
  EXPECT_GT(sidecar["SamplingFrequency"].get<double>(), 0);
  EXPECT_EQ(sidecar["MotionChannelCount"].get<std::size_t>(), channels.size() - 1);
  const auto events = TsvRows(stem + "_events.tsv");
  EXPECT_EQ(events[0][0], "onset");
  EXPECT_EQ(events[0][1], "duration");
}

// By the validator of BIDS, where it is installed (npm: bids-validator).
inline void ExpectValidatorAgrees(const std::filesystem::path& folder) {
  if (std::system("command -v bids-validator >/dev/null 2>&1") != 0) return;
  EXPECT_EQ(std::system(fmt::format("bids-validator '{0}' > '{0}.validator' 2>&1", folder.string()).c_str()), 0)
      << ReadTextFile(folder.string() + ".validator");
}

// The whole data set; returns how many recordings it has.
inline int ExpectDerivativeHolds(const std::filesystem::path& folder) {
  const Json description = ReadJsonFile(folder / "dataset_description.json");
  for (const char* key : {"Name", "BIDSVersion"}) EXPECT_TRUE(description.contains(key)) << key;
  EXPECT_EQ(description.value("DatasetType", ""), "derivative");
  EXPECT_FALSE(description.value("GeneratedBy", Json::array()).empty()) << "required of derivatives";
  for (const Json& by : description["GeneratedBy"]) EXPECT_TRUE(by.contains("Name"));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder / "README"));
  EXPECT_EQ(TsvRows(folder / "participants.tsv")[0][0], "participant_id");
  ExpectValidatorAgrees(folder);
  int recordings = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().string().ends_with("_motion.tsv")) ExpectMotionHolds(entry.path()), ++recordings;
  return recordings;
}

}  // namespace lake
