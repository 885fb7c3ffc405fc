#include "file_state.h"

#include "lake/core/provenance.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAbsent = "absent";

}  // namespace

bool FileState::IsAbsent() const {
  return sha256 == kAbsent;
}

FileState StateOf(const fs::path& path, const FileState* known) {
  const std::optional<FileStamp> now = FileStamp::Of(path);
  if (!now) return {path, kAbsent, {}};
  if (known && IsUntouched(*now, known->stamp)) return {path, known->sha256, known->stamp};
  return {path, Sha256OfFile(path), *now};
}

Json FileStateJson(const FileState& state) {
  const FileStamp& stamp = state.stamp;
  return {{"path", state.path.string()},      {"sha256", state.sha256},         {"size", stamp.size},
          {"modified_ns", stamp.modified_ns}, {"changed_ns", stamp.changed_ns}, {"inode", stamp.inode},
          {"seen_ns", stamp.seen_ns}};
}

FileState FileStateFrom(const Json& json) {
  FileState state;
  state.path = json.at("path").get<std::string>();
  state.sha256 = json.at("sha256").get<std::string>();
  FileStamp& stamp = state.stamp;
  stamp.size = json.at("size");
  stamp.inode = json.at("inode");
  stamp.seen_ns = json.at("seen_ns");
  stamp.modified_ns = json.at("modified_ns");
  stamp.changed_ns = json.at("changed_ns");
  return state;
}

}  // namespace lake::steps
