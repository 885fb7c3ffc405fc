// A table that grows while the program works, so that nothing of it is lost if that ends.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::live {

class AppendedTable {
 public:
  AppendedTable(std::filesystem::path path, const std::vector<std::string>& header)
      : path_(std::move(path)), file_(path_, std::ios::binary | std::ios::trunc) {
    Row(header);
    Flush();
  }

  void Row(const std::vector<std::string>& cells) { file_ << fmt::format("{}\n", fmt::join(cells, ",")); }

  // Throws Error where the disk takes no more.
  void Flush() {
    if (!file_.flush()) throw Fail("{}: cannot be written further; is the disk full?", path_.string());
  }

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace lake::live
