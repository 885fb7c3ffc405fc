// Which sources a program was built from, as bytes of a fixed size in its file.
#pragma once

namespace lake {

struct SourceStamp {
  char marker[16];  // by which it is found in a program's file
  char commit[48];
  char tree[16];
};
extern const SourceStamp kSourceStamp;

}  // namespace lake
