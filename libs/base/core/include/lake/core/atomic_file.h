// Files that appear under their final name only when they are whole.
#pragma once

#include <filesystem>
#include <string_view>

namespace lake {

// A file that is written under a temporary name beside its final one. Commit() moves it there; without it the
// destructor removes it. The temporary name is unique (mkstemp). Other libraries (video writers, gnuplot) write to
// TemporaryPath() themselves.
class AtomicFile {
 public:
  // Throws Error if a file cannot be made there, or a pipe or device has that name.
  explicit AtomicFile(std::filesystem::path final_path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  // Has the extension of the final path, so that libraries which choose a format by it choose rightly.
  const std::filesystem::path& TemporaryPath() const { return temporary_path_; }

  // Throws Error if nothing was written to the temporary file or it cannot be moved.
  void Commit();

 private:
  friend void WriteTextFile(const std::filesystem::path& path, std::string_view text);
  void Move();

  std::filesystem::path final_path_;
  std::filesystem::path temporary_path_;
  bool committed_ = false;
};

// Writes the whole text, atomically. Throws Error (a full disk, a folder that cannot be written).
void WriteTextFile(const std::filesystem::path& path, std::string_view text);

// Reads the whole file; of a pipe or terminal, until it ends. Throws Error if it is absent, a folder, or larger than
// `max_bytes`; Interrupted while it waits for a pipe.
std::string ReadTextFile(const std::filesystem::path& path, std::size_t max_bytes = std::size_t{1} << 30);

}  // namespace lake
