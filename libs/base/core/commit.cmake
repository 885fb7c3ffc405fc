# Writes OUT, a header that names the commit of SOURCE and whether the programs' sources are as committed there, if it says otherwise
# now. Without git, or outside of a clone of this project's own (a tarball), both are "unknown".
set(commit unknown)
set(tree unknown)
execute_process(COMMAND git rev-parse --show-toplevel HEAD WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE answer ERROR_QUIET RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
file(REAL_PATH ${SOURCE} source)
if(NOT failed AND answer MATCHES "^(.*)\n([0-9a-f]+)$" AND CMAKE_MATCH_1 STREQUAL source)
  set(commit ${CMAKE_MATCH_2})
  execute_process(COMMAND git status --porcelain -- apps libs CMakeLists.txt CMakePresets.json
    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE changes ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(tree clean)
    if(changes)
      set(tree changed)
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT [[#define LAKE_COMMIT "@commit@"
#define LAKE_TREE "@tree@"
]] @ONLY)
