// The page on which an exoskeleton is aligned while it is worn: what the camera sees, what was measured, where the
// joint is to go.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>

#include "lake/core/json.h"
#include "lake/review/page_options.h"

namespace lake::review {

// All may be called by several threads at once.
struct LiveWork {
  std::function<Json()> about;                         // LiveMessage in page/messages.ts
  std::function<Json()> state;                         // LiveStateMessage, less its mode
  std::function<Json(std::int64_t after)> view;        // LiveViewMessage; waits a little for a later frame
  std::function<cv::Mat(std::int64_t frame)> picture;  // CV_8UC1, at most as wide as `about` says. Throws Error: gone
  std::function<void(const Json& act)> act;            // LiveAct. Throws Error saying why not
  std::function<bool()> is_over;                       // then the page ends with its last window
};

// Throws Error where the port is taken, Interrupted once a signal has arrived.
void ServeLive(const PageOptions& options, const LiveWork& work);

}  // namespace lake::review
