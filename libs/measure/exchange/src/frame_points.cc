#include <zip.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "readers.h"

namespace lake::exchange {

PointRecording AsDrawn(PointRecording points) {
  if (points.space == PointSpace::kImage)
    for (PointTrack& point : points.points)
      for (Eigen::Vector3d& p : point.positions) p = {p.x() + kPixelCentre, -p.y() - kPixelCentre, p.z()};
  return points;
}

PointRecording PointsByFrame(const std::vector<FramePoints>& points, std::size_t file_bytes,
                             const std::filesystem::path& path, double rate_hz, const LeftOut& left_out) {
  std::int64_t last = -1;
  std::vector<std::string> names;
  for (const FramePoints& point : points) {
    names.push_back(point.name);
    if (!point.positions.empty()) last = std::max(last, point.positions.rbegin()->first);
  }
  if (last < 0) throw Fail("{}: no track with positions{}", path.string(), left_out.InBrackets());
  constexpr std::size_t kAlwaysBelievable = 2'000'000;  // four markers over two hours of a video
  const std::size_t frames = static_cast<std::size_t>(last) + 1;
  if (frames > (kAlwaysBelievable + file_bytes) / points.size())
    throw Fail("{}: {} tracks and a frame with the number {}: no such long video is described by {} bytes",
               path.string(), points.size(), last, file_bytes);

  PointRecording recording;
  recording.space = PointSpace::kImage;
  for (std::int64_t frame = 0; frame <= last; ++frame) {
    recording.frame.push_back(frame);
    if (rate_hz > 0) recording.time_s.push_back(static_cast<double>(frame) / rate_hz);
  }
  AddPoints(std::move(names), path.string(), recording);
  for (std::size_t p = 0; p < points.size(); ++p) {
    recording.points[p].positions.assign(frames, PointTrack::Missing());
    for (const auto& [frame, position] : points[p].positions)
      recording.points[p].positions[static_cast<std::size_t>(frame)] = position;
  }
  left_out.AppendTo(recording.warnings);
  return recording;
}

std::vector<std::string> ParseXml(const std::string& text, const std::filesystem::path& path,
                                  pugi::xml_document& document) {
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (parsed) return {};
  if (!document.document_element().first_child())
    throw Fail("{}: not XML: {} at byte {}", path.string(), parsed.description(), parsed.offset);
  return {fmt::format("{}: damaged or cut off at byte {} ({}); what stands before it is read", path.string(),
                      parsed.offset, parsed.description())};
}

void WriteXml(const std::filesystem::path& path, const pugi::xml_document& document) {
  std::ostringstream text;
  document.save(text, "  ", pugi::format_indent, pugi::encoding_utf8);
  WriteTextFile(path, text.str());
}

std::string ReadZipEntry(const std::filesystem::path& path, const std::string& ending) {
  constexpr std::size_t kMostBytes = std::size_t{256} << 20;  // unpacked: a small archive may unpack to anything
  int error = 0;
  zip_t* opened = zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &error);
  if (!opened) throw Fail("{}: not a zip archive that can be read (error {} of libzip)", path.string(), error);
  const std::unique_ptr<zip_t, decltype(&zip_discard)> archive(opened, zip_discard);
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive.get(), 0); ++i) {
    const char* name = zip_get_name(archive.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_RAW);
    if (!name || !std::string_view(name).ends_with(ending)) continue;
    const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> entry(
        zip_fopen_index(archive.get(), static_cast<zip_uint64_t>(i), 0), zip_fclose);
    if (!entry) throw Fail("{}: {}: {}", path.string(), name, zip_strerror(archive.get()));
    zip_stat_t stat;
    if (zip_stat_index(archive.get(), static_cast<zip_uint64_t>(i), 0, &stat) != 0 || stat.size > kMostBytes)
      throw Fail("{}: {} unpacks to more than {} bytes", path.string(), name, kMostBytes);
    std::string text(stat.size, '\0');
    char more = 0;  // the checksum is compared by the read that meets the end
    if (zip_fread(entry.get(), text.data(), text.size()) != static_cast<zip_int64_t>(text.size()) ||
        zip_fread(entry.get(), &more, 1) != 0)
      throw Fail("{}: {} cannot be unpacked: {}", path.string(), name, zip_file_strerror(entry.get()));
    return text;
  }
  throw Fail("{}: the archive holds no *{}", path.string(), ending);
}

}  // namespace lake::exchange
