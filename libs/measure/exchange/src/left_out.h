// What a reader leaves out of a file, by kind: the one rule of all readers is that what is consistent is read, and the
// rest is named in a warning. Not part of the interface.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace lake::exchange {

class LeftOut {
 public:
  // One more of a kind, as "a row without a time"; `where` is the place of the first.
  void Add(const std::string& kind, const std::string& where);

  // " (the first warning)", for the error where nothing usable remains; empty if nothing was left out.
  std::string InBrackets() const;

  // A warning for each kind: its first place and how many there are.
  void AppendTo(std::vector<std::string>& warnings) const;

 private:
  struct Kind {
    std::string name, first;
    std::size_t count = 0;
  };
  std::vector<Kind> kinds_;
};

}  // namespace lake::exchange
