#include "lake/core/provenance.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/file_stamp.h"
#include "source_stamp.h"

namespace lake {
namespace fs = std::filesystem;
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw Fail("SHA-256 is not available");
  }
  void Update(std::string_view bytes) {
    if (EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) != 1) throw Fail("SHA-256 failed");
  }
  std::string Hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned size = 0;
    if (EVP_DigestFinal_ex(context_.get(), digest.data(), &size) != 1) throw Fail("SHA-256 failed");
    return fmt::format("{:02x}", fmt::join(digest.begin(), digest.begin() + size, ""));
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

std::string Sha256OfContent(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Fail("{}: cannot be read", path.string());
  Sha256 hash;
  std::vector<char> buffer(1 << 20);
  while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || stream.gcount() > 0)
    hash.Update({buffer.data(), static_cast<std::size_t>(stream.gcount())});
  if (stream.bad()) throw Fail("{}: cannot be read", path.string());
  return hash.Hex();
}

// What this process, or the one that it was forked from, has read: a recording that stays as it is is read once.
class KnownHashes {
 public:
  std::string Of(const fs::path& path) {
    const std::optional<FileStamp> now = FileStamp::Of(path);
    std::error_code error;
    const std::string name = fs::absolute(path, error).string();
    if (now && !error) {
      const std::lock_guard lock(mutex_);
      if (const auto known = hashes_.find(name); known != hashes_.end() && IsUntouched(*now, known->second.stamp))
        return known->second.sha256;
    }
    std::string sha256 = Sha256OfContent(path);
    if (now && !error) {
      const std::lock_guard lock(mutex_);
      hashes_[name] = {*now, sha256};
    }
    return sha256;
  }

 private:
  struct Known {
    FileStamp stamp;
    std::string sha256;
  };
  std::mutex mutex_;
  std::map<std::string, Known> hashes_;  // by absolute path
};

std::string Sha256OfFolder(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Sha256 hash;
  for (const fs::path& file : files) hash.Update(fmt::format("{} {}\n", file.filename().string(), Sha256OfFile(file)));
  return hash.Hex();
}

// Empty if there is none by which users differ.
std::string Home() {
  const char* home = std::getenv("HOME");
  const std::string path = home ? fs::path(home).lexically_normal().string() : "";
  const std::size_t end = path.find_last_not_of('/');
  return end == std::string::npos ? "" : path.substr(0, end + 1);
}

bool IsInName(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' || (c & 0x80);
}

}  // namespace

std::string_view Version() {
  return LAKE_VERSION;
}

std::string_view Commit() {
  return kSourceStamp.commit;
}

std::string_view SourceTree() {
  return kSourceStamp.tree;
}

std::string VersionAndCommit() {
  constexpr std::size_t kShort = 12;
  return fmt::format("{} (commit {}, {})", Version(), Commit().substr(0, kShort), SourceTree());
}

std::string Sha256OfFile(const fs::path& path) {
  if (fs::is_directory(path)) return Sha256OfFolder(path);
  if (fs::is_other(path))
    throw Fail("{}: can be read only once, so the summary cannot record its content; save it as a file", path.string());
  static KnownHashes known;
  return known.Of(path);
}

namespace {

std::string Sha256WithoutCommit(const fs::path& binary) {
  std::string content = ReadTextFile(binary);
  const std::string_view marker(kSourceStamp.marker, sizeof kSourceStamp.marker);
  for (std::size_t at = content.find(marker); at != std::string::npos; at = content.find(marker, at)) {
    const std::size_t size = std::min(sizeof kSourceStamp, content.size() - at);
    std::fill_n(content.begin() + static_cast<std::ptrdiff_t>(at), size, '\0');
  }
  return Sha256OfText(content);
}

// Of the shared libraries of the project beside a program; empty where there are none. Hashed once in a process.
std::string Sha256OfLibraries(const fs::path& folder) {
  static std::mutex mutex;
  static std::map<fs::path, std::string> known;
  const std::lock_guard lock(mutex);
  if (const auto found = known.find(folder); found != known.end()) return found->second;
  std::vector<fs::path> libraries;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".so") libraries.push_back(entry.path());
  std::sort(libraries.begin(), libraries.end());
  std::string hashes;
  for (const fs::path& library : libraries) hashes += Sha256WithoutCommit(library);
  return known[folder] = hashes;
}

}  // namespace

std::string Sha256OfProgram(const fs::path& program) {
  const fs::path folder = fs::canonical(program).parent_path().parent_path() / "lib/lake";
  return Sha256OfText(Sha256WithoutCommit(program) + Sha256OfLibraries(folder));
}

std::string Sha256OfText(std::string_view text) {
  Sha256 hash;
  hash.Update(text);
  return hash.Hex();
}

std::string WithoutHome(const std::string& text, std::string_view written) {
  const std::string home = Home();
  if (home.empty()) return text;
  std::string short_text;
  std::size_t done = 0;
  for (std::size_t at = text.find(home); at != std::string::npos; at = text.find(home, at + 1)) {
    const std::size_t end = at + home.size();
    const bool begins_path = at == 0 || !(IsInName(text[at - 1]) || text[at - 1] == '/');
    const bool ends_name = end == text.size() || !IsInName(text[end]);
    if (!begins_path || !ends_name) continue;
    short_text.append(text, done, at - done).append(written);
    done = end;
  }
  return short_text + text.substr(done);
}

fs::path FromHome(const fs::path& path) {
  const std::string home = Home(), text = path.string();
  return home.empty() || (text != "~" && !text.starts_with("~/")) ? path : fs::path(home + text.substr(1));
}

}  // namespace lake
