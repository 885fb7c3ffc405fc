#include "lake/review/live_page.h"

#include <cstdint>

#include "jpeg_encoder.h"
#include "lake/core/error.h"
#include "page_server.h"

namespace lake::review {

void ServeLive(const PageOptions& options, const LiveWork& work) {
  constexpr int kQuality = 80;
  const auto state = [&work] {
    Json message = work.state();
    message["mode"] = "live";
    return message;
  };
  PageServer page(options, state);
  page.Get("live", work.about);
  page.Post("view", [&work](const Json& message) {
    const Json& after = message.at("after");
    const bool fits = after.is_number_integer() &&
                      (!after.is_number_unsigned() || std::in_range<std::int64_t>(after.get<std::uint64_t>()));
    if (!fits) throw Fail("{} is not the number of a frame", after.dump());
    return work.view(after.get<std::int64_t>());
  });
  page.GetOther("picture/", [&work](const LocalRequest& request) {
    return LocalReply{.type = "image/jpeg",
                      .body = JpegEncoder(kQuality).Encode(work.picture(FrameNumber(request.rest)))};
  });
  page.Post("act", [&work, &state](const Json& act) {
    work.act(act);
    return state();
  });
  page.ServeUntil(work.is_over);
}

}  // namespace lake::review
