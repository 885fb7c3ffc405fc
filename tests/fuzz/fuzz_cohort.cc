#include "fuzz_reader.h"
#include "lake/cohort/cohort_file.h"
#include "lake/core/atomic_file.h"

namespace {

namespace fs = std::filesystem;

// A cohort's folder with everything but what is fuzzed.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("lake-fuzz-cohort-" + std::to_string(getpid()))) {
    for (const char* person : {"sub-01", "sub-02/ses-1"}) fs::create_directories(path_ / "sourcedata" / person);
  }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& Path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

// cohort.yaml, and after a form feed participants.tsv.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(text.find('\f'), size);
  try {
    lake::WriteTextFile(folder.Path() / "cohort.yaml", text.substr(0, end));
    lake::WriteTextFile(folder.Path() / "participants.tsv",
                        end < size ? text.substr(end + 1) : "participant_id\nsub-01");
    lake::cohort::ReadCohort(folder.Path());
  } catch (const lake::Error&) {
  }
  return 0;
}
