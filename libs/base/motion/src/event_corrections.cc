#include "lake/motion/event_corrections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::motion {
namespace {

StsEventKind KindAt(int number) {
  return static_cast<StsEventKind>(number);
}

using Key = std::pair<int, StsEventKind>;

std::int64_t WholeNumber(const CsvTable& table, std::size_t row, std::string_view column, double least, double most) {
  const double number = table.RequiredNumber(row, table.Column(column));
  if (!(number >= least && number <= most && number == std::floor(number)))
    throw Fail("{}: {} {} is not a whole number from {}", table.Where(row), column, number, least);
  return static_cast<std::int64_t>(number);
}

bool IsOfWalking(StsEventKind kind) {
  return kind >= StsEventKind::kHeelStrike;
}

std::string NamesOfEvents() {
  std::string names;
  for (int i = 0; i < kEventKinds; ++i) names += (names.empty() ? "" : ", ") + std::string(ToString(KindAt(i)));
  return names;
}

EventCorrection ReadRow(const CsvTable& table, std::size_t row) {
  constexpr double kMostRepetitions = 1e6, kMostFrames = 1e12;
  EventCorrection correction;
  correction.where = table.Where(row);
  const std::string& name = table.Text(row, table.Column("event"));
  const std::optional<StsEventKind> kind = FindEventKind(name);
  if (!kind) throw Fail("{}: '{}' is not an event; there are {}", table.Where(row), name, NamesOfEvents());
  correction.kind = *kind;
  correction.repetition =
      static_cast<int>(WholeNumber(table, row, "repetition", IsOfWalking(*kind) ? 0 : 1, kMostRepetitions));
  if (table.Has("sd_s")) correction.sd_s = table.Number(row, table.Column("sd_s")).value_or(LegSample::kUnknown);
  if (table.Has("others")) correction.others_stay = table.Text(row, table.Column("others")) == "stay";
  if (table.Has("frame") && table.Number(row, table.Column("frame")))
    correction.frame = WholeNumber(table, row, "frame", 0, kMostFrames);
  if (table.Has("time_s")) correction.time_s = table.Number(row, table.Column("time_s"));
  return correction;
}

// nullopt where there is to be none.
std::optional<StsEvent> EventOf(const EventCorrection& said, const std::vector<std::int64_t>& frame,
                                const std::vector<double>& time_s) {
  if (!said.frame && !said.time_s) return std::nullopt;
  if (said.time_s && !(*said.time_s >= time_s.front() && *said.time_s <= time_s.back()))
    throw Fail("{}: {} s is outside the recording, which is from {:.3f} to {:.3f} s", said.where, *said.time_s,
               time_s.front(), time_s.back());
  if (!said.frame) {
    const std::size_t row = NearestRow(time_s, *said.time_s);
    return StsEvent{.repetition = said.repetition, .kind = said.kind, .frame = frame[row], .time_s = *said.time_s};
  }
  const auto found = std::lower_bound(frame.begin(), frame.end(), *said.frame);
  if (found == frame.end() || *found != *said.frame)
    throw Fail("{}: frame {} is not in the recording; its frames are {} to {}", said.where, *said.frame, frame.front(),
               frame.back());
  const auto row = static_cast<std::size_t>(found - frame.begin());
  if (said.time_s && time_s[NearestRow(time_s, *said.time_s)] != time_s[row])
    throw Fail("{}: frame {} is at {:.3f} s, not at {} s: give one of the two, and leave the other empty", said.where,
               *said.frame, time_s[row], *said.time_s);
  return StsEvent{.repetition = said.repetition,
                  .kind = said.kind,
                  .frame = *said.frame,
                  .time_s = said.time_s.value_or(time_s[row])};
}

std::string TextOf(const StsEvent& event) {
  return fmt::format("{} of repetition {} at {:.3f} s", ToString(event.kind), event.repetition, event.time_s);
}

// Where a person said something of the events.
using Said = std::map<Key, std::string>;

// The first of these rows that there is; nullptr if nobody said anything of these events.
const std::string* WhereOf(const Said& said, std::initializer_list<Key> keys) {
  for (const Key& key : keys)
    if (const auto found = said.find(key); found != said.end()) return &found->second;
  return nullptr;
}

void CheckOrder(const std::vector<StsEvent>& events, const Said& said) {
  const StsEvent* before = nullptr;
  for (const StsEvent& event : events) {
    const Key key{event.repetition, event.kind}, onset{event.repetition, StsEventKind::kOnset};
    const bool is_first = !before || before->repetition != event.repetition;
    const std::string* where = WhereOf(said, {key, onset});
    if (where && is_first && event.kind != StsEventKind::kOnset)
      throw Fail("{}: repetition {} has no onset; give it, or leave all of its events empty", *where, event.repetition);
    if (before) where = WhereOf(said, {key, {before->repetition, before->kind}});
    if (where && before && event.time_s < before->time_s)
      throw Fail("{}: {} is before {}", *where, TextOf(event), TextOf(*before));
    before = &event;
  }
}

void CheckDurations(const std::vector<StsEvent>& events, const Said& said) {
  double onset_s = 0;
  for (const StsEvent& event : events) {
    if (event.kind == StsEventKind::kOnset) onset_s = event.time_s;
    if (event.kind != StsEventKind::kStanding || event.time_s > onset_s) continue;
    const Key onset{event.repetition, StsEventKind::kOnset};
    if (const std::string* where = WhereOf(said, {{event.repetition, event.kind}, onset}))
      throw Fail("{}: {} is at its onset: a rise takes time", *where, TextOf(event));
  }
}

// The rows as they are, in the order of time.
std::vector<StsEvent> EventsOfWalk(const std::vector<EventCorrection>& corrections,
                                   const std::vector<std::int64_t>& frame, const std::vector<double>& time_s) {
  std::vector<StsEvent> events;
  for (const EventCorrection& correction : corrections)
    if (auto event = EventOf(correction, frame, time_s)) {
      event->sd_s = correction.sd_s;
      events.push_back(*event);
    }
  std::ranges::stable_sort(events, {}, &StsEvent::time_s);
  for (std::size_t i = 1; i < events.size(); ++i)
    if (events[i].repetition < events[i - 1].repetition)
      throw Fail("{}: {} is before {}", corrections.front().where, TextOf(events[i - 1]), TextOf(events[i]));
  return events;
}

}  // namespace

std::size_t NearestRow(const std::vector<double>& times, double time_s) {
  const auto after = std::lower_bound(times.begin(), times.end(), time_s);
  if (after == times.begin()) return 0;
  const auto row = static_cast<std::size_t>(after - times.begin());
  return after == times.end() || time_s - times[row - 1] <= times[row] - time_s ? row - 1 : row;
}

std::optional<StsEventKind> FindEventKind(std::string_view name) {
  for (int i = 0; i < kEventKinds; ++i)
    if (name == ToString(KindAt(i))) return KindAt(i);
  return std::nullopt;
}

std::vector<EventCorrection> ReadEventCorrections(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  if (!table.Has("frame") && !table.Has("time_s"))
    throw Fail("{}: no column 'frame' or 'time_s': one of them says when an event is", path.string());
  std::vector<EventCorrection> corrections;
  std::set<Key> seen;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    corrections.push_back(ReadRow(table, row));
    const EventCorrection& read = corrections.back();
    if (!seen.insert({read.repetition, read.kind}).second && !IsOfWalking(read.kind))
      throw Fail("{}: {} of repetition {} is given twice", read.where, ToString(read.kind), read.repetition);
  }
  return corrections;
}

void WriteEventCorrections(const std::filesystem::path& path, const std::vector<EventCorrection>& corrections) {
  const bool is_walk = std::ranges::any_of(corrections, IsOfWalking, &EventCorrection::kind);
  std::vector<std::string> header = {"repetition", "event", "frame", "time_s"};
  if (is_walk) header.emplace_back("others");
  CsvWriter csv(header);
  for (const EventCorrection& correction : corrections) {
    csv.Add(correction.repetition).Add(ToString(correction.kind)).Add(correction.frame).Add(correction.time_s);
    if (is_walk) csv.Add("stay");
    csv.EndRow();
  }
  csv.Write(path);
}

void CheckAreInside(const std::vector<EventCorrection>& corrections, const std::vector<std::int64_t>& frame,
                    const std::vector<double>& time_s) {
  for (const EventCorrection& correction : corrections) EventOf(correction, frame, time_s);
}

std::vector<StsEvent> ApplyEventCorrections(const std::vector<EventCorrection>& corrections,
                                            const std::vector<std::int64_t>& frame, const std::vector<double>& time_s,
                                            const std::vector<StsEvent>& found) {
  if (corrections.empty()) return found;
  if (std::ranges::any_of(corrections, IsOfWalking, &EventCorrection::kind)) {
    std::vector<EventCorrection> all = corrections;
    const bool others_stay = std::ranges::all_of(corrections, &EventCorrection::others_stay);
    for (const StsEvent& event : found)
      if (others_stay && std::ranges::none_of(corrections, [&](const EventCorrection& correction) {
            return correction.repetition == event.repetition && correction.kind == event.kind;
          }))
        all.push_back({event.repetition, event.kind, {}, event.time_s, {}, event.sd_s});
    return EventsOfWalk(all, frame, time_s);
  }
  std::map<Key, StsEvent> merged;
  Said said;
  for (const StsEvent& event : found) merged[{event.repetition, event.kind}] = event;
  for (const EventCorrection& correction : corrections) {
    const Key key{correction.repetition, correction.kind};
    said[key] = correction.where;
    if (const auto event = EventOf(correction, frame, time_s))
      merged[key] = *event;
    else
      merged.erase(key);
  }
  std::vector<StsEvent> events;
  for (const auto& [key, event] : merged) events.push_back(event);
  CheckOrder(events, said);
  CheckDurations(events, said);
  return events;
}

}  // namespace lake::motion
