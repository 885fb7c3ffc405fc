#include "lake/video/video_reader.h"

namespace lake::video {

void Describe(VideoReaderOptions& o, OptionList& options) {
  options.Add("start", o.start_s, "Begin at this time of the file").Unit("s").Otherwise("its beginning");
  options.Add("end", o.end_s, "End at this time of the file").Unit("s").Otherwise("its end");
  DescribeCaptureRate(o, options);
  DescribeRotation(o, options);
  options.Check([&o](const OptionList& list) {
    if (o.start_s && o.end_s && *o.end_s < *o.start_s)
      throw UsageError("{} is before {}", list["end"].Said(), list["start"].Said());
  });
}

Option& DescribeCaptureRate(VideoReaderOptions& o, OptionList& options) {
  return options
      .Add("capture-rate", o.capture_rate_hz,
           "Rate at which the pictures were taken: of a slow-motion file; an image sequence needs it")
      .Unit("Hz")
      .Positive()
      .Otherwise("the file's own times");
}

Option& DescribeRotation(VideoReaderOptions& o, OptionList& options) {
  using Turns = OptionList::Choices<int>;
  return options.AddChoice("rotate", o.rotate_deg, Turns{{"0", 0}, {"90", 90}, {"180", 180}, {"270", 270}},
                           "Turn the pictures clockwise, beyond what the file says [degrees]");
}

}  // namespace lake::video
