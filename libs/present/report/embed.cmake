# Writes SOURCE: a function lake::ROOM::NAME() that returns the bytes of FILE.
file(READ ${FILE} bytes HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
file(WRITE ${SOURCE} "#include \"page_files.h\"

namespace lake::${ROOM} {

std::string_view ${NAME}() {
  static constexpr char kBytes[] = {${bytes}};
  return {kBytes, sizeof kBytes};
}

}  // namespace lake::${ROOM}
")
