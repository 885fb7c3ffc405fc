// What is recorded as a command line is one.
#include "lake/core/shell_word.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <random>

#include "home_folder.h"

namespace lake {
namespace {

// The words that sh finds in a line.
std::vector<std::string> ReadByShell(const std::string& line) {
  std::vector<std::string> words;
  FILE* pipe = popen(("printf '%s\\0' " + line).c_str(), "r");
  std::string word;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
    if (c == 0)
      words.push_back(std::exchange(word, {}));
    else
      word += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0) << line;
  return words;
}

// Any bytes but 0, those that mean something to a shell more often than others.
std::string RandomWord(std::mt19937& random) {
  constexpr std::string_view kSpecial = "'\"`\\$ \t\n[]{}()<>!~*?#&;|=%^-.a";
  std::string word;
  for (auto length = random() % 9; length > 0; --length)
    word += random() % 4 ? kSpecial[random() % kSpecial.size()] : static_cast<char>(1 + random() % 255);
  return word;
}

TEST(ShellWord, IsReadBackByTheShell) {
  std::mt19937 random(1);
  std::vector<std::string> words = {"it's.mp4", "", "~", "~root", "a b", "`id`", "{a,b}", "[ab]*", "!!", "-x", "--a=b"};
  for (int i = 0; i < 2000; ++i) words.push_back(RandomWord(random));
  std::string line;
  for (const std::string& word : words) line += " " + ShellWord(word);
  EXPECT_EQ(ReadByShell(line), words);
}

TEST(ShellWord, IsPlainWhereItCanBe) {
  for (const char* word : {"lake-track", "../data/a_1.mp4", "--seed", "knee=12.5,34@7", "frames/%05d.png", "a:b+c"})
    EXPECT_EQ(ShellWord(word), word);
}

TEST(CommandLine, HasNoHomeFolderAndIsReadBackByTheShell) {
  const HomeFolder anna("/home/anna lee");
  const std::vector<std::string> words = {"lake-track",
                                          "/home/anna lee",
                                          "/home/anna lee/it's.mp4",
                                          "--camera=/home/anna lee/camera.yaml",
                                          "/home/anna lee:/home/anna lee/b c",
                                          "",
                                          "/home/anna lees/other.mp4"};
  const std::string line = CommandLine(words);
  EXPECT_EQ(ReadByShell(line), words) << line;
  EXPECT_THAT(line, testing::StartsWith("lake-track ~ ~/'it'\\''s.mp4' --camera=\"$HOME\"/camera.yaml \"$HOME\":"));
  EXPECT_EQ(line.find("anna lee/"), std::string::npos) << line;
}

}  // namespace
}  // namespace lake
