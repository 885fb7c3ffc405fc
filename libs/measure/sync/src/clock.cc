#include "lake/sync/clock.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/yaml.h"

namespace lake::sync {

void WriteClock(const std::filesystem::path& path, const Clock& clock) {
  WriteTextFile(path, fmt::format("# A's time = t + offset_s + 1e-6 drift_ppm (t - from_s), t on B's clock\n"
                                  "offset_s: {}\ndrift_ppm: {}\nfrom_s: {}\nsd_s: {}\nmethod: {}\na: {}\nb: {}\n",
                                  FormatNumber(clock.offset_s), FormatNumber(clock.drift_ppm),
                                  FormatNumber(clock.from_s), FormatNumber(clock.sd_s), clock.method,
                                  Json(clock.a.string()).dump(), Json(clock.b.string()).dump()));
}

Clock ReadClock(const std::filesystem::path& path) {
  YamlNode node = YamlNode::ReadFile(path);
  const auto offset_s = node.Number("offset_s");
  if (!offset_s) throw Fail("{}: no offset_s; give a sync.yaml that lake-sync wrote", path.string());
  Clock clock{.offset_s = *offset_s,
              .drift_ppm = node.Number("drift_ppm").value_or(0),
              .from_s = node.Number("from_s").value_or(0),
              .sd_s = node.Number("sd_s").value_or(0),
              .method = node.Text("method").value_or(""),
              .a = node.Text("a").value_or(""),
              .b = node.Text("b").value_or("")};
  node.Finish();
  constexpr double kMost_ppm = 1e5;  // a rate that is wrong by more is no clock's drift
  if (clock.sd_s < 0 || !(std::abs(clock.drift_ppm) < kMost_ppm))
    throw Fail("{}: an SD of {} s and a drift of {} ppm are none of a clock's", path.string(), clock.sd_s,
               clock.drift_ppm);
  return clock;
}

Clock ReadClockOf(const std::filesystem::path& path, const std::filesystem::path& b) {
  Clock clock = ReadClock(path);
  if (clock.a.filename() == b.filename() && clock.b.filename() != b.filename())
    throw Fail("{}: brings the times of {} to the clock of {}, not the other way: run lake sync with {} second",
               path.string(), clock.b.string(), clock.a.string(), b.string());
  return clock;
}

}  // namespace lake::sync
