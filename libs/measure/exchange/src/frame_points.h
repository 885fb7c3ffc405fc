// Points of project files, which are kept by the number of the video's frame. Not part of the interface.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// Tracker and Kinovea place a position on the picture as it is drawn: the top-left pixel's centre is at (0.5, 0.5).
constexpr double kPixelCentre = 0.5;

// Positions in the image as tables in px have them: from the picture's top-left corner, y up. Others as they are.
PointRecording AsDrawn(PointRecording points);

struct FramePoints {
  std::string name;
  std::map<std::int64_t, Eigen::Vector3d> positions;  // by frame, not negative; image frame
};

// All frames from 0 to the last that has a position, with the times of a frame rate if it is given. Throws Error if
// there is no position, and if a frame's number asks for more memory than the size of the file makes believable.
PointRecording PointsByFrame(const std::vector<FramePoints>& points, std::size_t file_bytes,
                             const std::filesystem::path& path, double rate_hz = 0);

// What stands before a place where the file is no XML, or cut off, is kept: a warning names the byte. Throws Error if
// nothing does.
std::vector<std::string> ParseXml(const std::string& text, const std::filesystem::path& path,
                                  pugi::xml_document& document);

// Whole and atomically.
void WriteXml(const std::filesystem::path& path, const pugi::xml_document& document);

// The first entry of a zip archive whose name has this ending. Throws Error if there is none or the archive is damaged.
std::string ReadZipEntry(const std::filesystem::path& path, const std::string& ending);

}  // namespace lake::exchange
