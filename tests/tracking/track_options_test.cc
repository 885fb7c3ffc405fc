// What lake-track can be told that contradicts itself, refused before a video is opened.
#include <gmock/gmock.h>

#include "lake/tracking/track_markers.h"

namespace lake {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

// As on a command line: pairs of an option and its value.
tracking::TrackOptions Told(const std::vector<std::pair<std::string, OptionTexts>>& words) {
  tracking::TrackOptions options;
  OptionList list = OptionsOf(options);
  for (const auto& [name, texts] : words)
    for (Option& option : list.All())
      if (option.Name() == name) option.Give(texts);
  list.Apply();
  return options;
}

void ExpectTrackRefusal(const std::vector<std::pair<std::string, OptionTexts>>& words, const std::string& message) {
  EXPECT_THAT([&] { Told(words).Check(); }, ThrowsMessage<UsageError>(HasSubstr(message)));
}

TEST(TrackOptions, ThatContradictEachOtherAreRefused) {
  EXPECT_NO_THROW(Told({}).Check());
  ExpectTrackRefusal({{"markers", {"knee,knee"}}}, "--markers: 'knee' stands twice");
  ExpectTrackRefusal({{"markers", {"knee,a b"}}}, "--markers: 'a b' is not a name");
  ExpectTrackRefusal({{"seed", {"elbow=1,2"}}}, "--seed elbow: not one of the markers (ankle, knee, hip, waist)");
  ExpectTrackRefusal({{"seed", {"knee=1,2", "knee=3,4"}}}, "--seed knee: given twice");
  ExpectTrackRefusal({{"color", {"#ff0000"}}}, "--color is for --detector color");
  ExpectTrackRefusal({{"detector", {"color"}}}, "needs at least one --color");
  ExpectTrackRefusal({{"detector", {"color"}}, {"color", {"#ff0000,#00ff00"}}}, "2 colours for 4 markers");
  ExpectTrackRefusal({{"detector", {"color"}}, {"color", {"red"}}}, "--color 'red'");
  ExpectTrackRefusal({{"detector", {"template"}}, {"seed", {"knee=1,2"}}}, "a --seed for each marker");
  ExpectTrackRefusal({{"detector", {"template"}}, {"markers", {"knee"}}, {"seed", {"knee=#7"}}},
                     "--seed knee=#7: --detector template needs the place in px");
  ExpectTrackRefusal({{"crop", {"1,2,3.5,4"}}}, "four whole numbers of px");
  ExpectTrackRefusal({{"crop", {"1,2,0,4"}}}, "width and height must be positive");
  EXPECT_THAT([] { tracking::MakeArucoDetector("5X5_7", {}); },
              ThrowsMessage<UsageError>(testing::AllOf(HasSubstr("'5X5_7' is not known"), HasSubstr("4X4_50"))));
}

TEST(TrackOptions, ColoursAreTakenByTheirLevelsAndByTheirPlaces) {
  const tracking::TrackOptions options =
      Told({{"detector", {"color"}}, {"color", {"#ff0000,@12,34@5", "#00ff00", "@6,7"}}});
  EXPECT_NO_THROW(options.Check());
  EXPECT_THAT(options.colors, ElementsAre("#ff0000", "@12,34@5", "#00ff00", "@6,7"));
}

}  // namespace
}  // namespace lake
