#include "lake/review/page_options.h"

#include <fmt/format.h>

namespace lake::review {

void Describe(PageOptions& o, OptionList& options) {
  options.Add("listen", o.listen, "Address of this machine at which the page is served; 0.0.0.0 for all of them")
      .Value("ADDRESS");
  options.Add("port", o.port, "Port of that address").Between(0, 65535).Otherwise("any that is free");
  options.Add("open", o.open, "Open the page in the browser");
}

std::string WhoCanReach(const PageOptions& page) {
  if (page.listen.starts_with("127.")) return {};
  return fmt::format(
      "warning: --listen {}: whoever reaches this machine over its network and knows the page's address, with its "
      "token, can see and change what the page shows; the connection is not encrypted",
      page.listen);
}

}  // namespace lake::review
