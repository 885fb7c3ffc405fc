#include "source_stamp.h"

#include "commit.h"  // made at each build, by commit.cmake

namespace lake {

const SourceStamp kSourceStamp = {"lake commit is", LAKE_COMMIT, LAKE_TREE};

}  // namespace lake
