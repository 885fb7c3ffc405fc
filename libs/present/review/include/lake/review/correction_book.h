// What a person changed in a recording's tracks, step by step, so that each step can be taken back.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/motion/corrections.h"
#include "lake/motion/event_corrections.h"
#include "lake/motion/marker_recording.h"

namespace lake::review {

class CorrectionBook {
 public:
  // `detected`: what the tracker measured, px, before any correction, in pictures of this size. `repeated`: frames
  // whose picture is that of the frame before, which hold no measurement. `made`: corrections from before; only
  // TakeHistory() lets them be taken back as steps. Throws Error for a correction of a marker or frame that the
  // recording does not have, and for an event outside it.
  CorrectionBook(motion::MarkerRecording detected, int width, int height, std::vector<std::int64_t> repeated,
                 const std::vector<motion::Correction>& made = {},
                 const std::vector<motion::EventCorrection>& events = {});

  // Each is one step. They throw Error for a marker, frame or place that is not there, and where nothing would change.
  void Place(std::int64_t frame, const std::string& marker, const Eigen::Vector2d& px, double sigma_px);
  void Hide(std::int64_t frame, const std::string& marker);
  void Restore(std::int64_t frame, const std::string& marker);  // to what the tracker measured
  void SwapFrom(std::int64_t frame, const std::string& one, const std::string& other);
  void MoveEvent(int repetition, motion::StsEventKind kind, std::int64_t frame);
  void RestoreEvent(int repetition, motion::StsEventKind kind);  // to where it is found
  void Undo();
  void Redo();
  // The same by a message: {op: place|hide|restore|swap|move_event|restore_event|undo|redo, frame, marker, x, y, sigma,
  // other, repetition, event}; EditMessage in page/messages.ts.
  void Make(const Json& edit);

  // All steps, for a later session to take them back: {base: corrections before the first, steps: as Make() has them,
  // done}.
  Json History() const;
  // Takes over the steps of an earlier session. Throws Error, and changes nothing, where they do not lead to the
  // corrections that are made now.
  void TakeHistory(const Json& history);

  bool CanUndo() const { return done_ > 0; }
  bool CanRedo() const { return done_ < steps_.size(); }

  const motion::MarkerRecording& Detected() const { return detected_; }
  motion::MarkerRecording Corrected() const;

  // In the order of frames, then of the recording's markers. What equals the tracker's measurement is none.
  std::vector<motion::Correction> Corrections() const;
  bool IsCorrected(std::size_t row, std::size_t marker) const { return made_.contains({row, marker}); }
  // In the order of repetitions and, within each, of events.
  std::vector<motion::EventCorrection> Events() const;
  bool IsMoved(int repetition, motion::StsEventKind kind) const { return events_.contains({repetition, kind}); }
  std::size_t Count() const { return made_.size() + events_.size(); }
  // Of the steps that are done; each changes two markers in many frames.
  std::size_t Swaps() const;

 private:
  using Cell = std::pair<std::size_t, std::size_t>;  // row of the recording, marker
  struct Change {
    Cell cell;
    std::optional<motion::MarkerSample> before, after;  // nullopt: as the tracker measured
  };
  using EventKey = std::pair<int, motion::StsEventKind>;
  struct EventChange {
    EventKey key;
    std::optional<motion::EventCorrection> before, after;  // nullopt: as it is found
  };
  struct Step {
    std::vector<Change> cells;
    std::optional<EventChange> event;
  };

  std::size_t Row(std::int64_t frame) const;
  std::size_t Marker(const std::string& name) const;
  const motion::MarkerSample& Now(Cell cell) const;
  Change ChangeTo(Cell cell, const motion::MarkerSample& sample) const;
  void Do(std::vector<Change> cells, Json edit);
  void DoEvent(EventKey key, const std::optional<motion::EventCorrection>& after, Json edit);
  void Append(Step step, Json edit);
  void MakeEvent(const std::string& op, const Json& edit);
  void Set(Cell cell, const std::optional<motion::MarkerSample>& sample);
  void SetEvent(EventKey key, const std::optional<motion::EventCorrection>& event);

  motion::MarkerRecording detected_;
  int width_, height_;  // px
  std::vector<std::int64_t> repeated_;
  std::map<Cell, motion::MarkerSample> made_;
  std::map<EventKey, motion::EventCorrection> events_;
  std::vector<motion::Correction> base_;
  std::vector<motion::EventCorrection> base_events_;
  std::vector<Step> steps_;
  Json edits_ = Json::array();  // one for each step
  std::size_t done_ = 0;        // of the steps; those behind can be done again
};

// {frame, marker, x_px, y_px, sigma_px}, null where it is not visible.
Json CorrectionJson(const motion::Correction& correction);
motion::Correction CorrectionFrom(const Json& json);

}  // namespace lake::review
