// A folder that a test fills and opens as a sequence.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// What a test opens of the folder.
struct Taken {
  std::string type = "auto", split = {};
  std::vector<std::string> only = {};
};

class SequenceFolder : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) { writeFile(folder_ / name, bytes); }
  /// An image of 4 × 3 pixels, as PNG whatever its name.
  void add(const std::string& name, double blue = 1) {
    write(name, encoded(".png", plain(4, 3, {blue, 2, 3})));
  }
  std::unique_ptr<Sequence> open() { return openSequence(folder_.path(), options_); }
  std::unique_ptr<Sequence> open(const Taken& taken) {
    SequenceOptions options;
    options.type = taken.type;
    options.split = taken.split;
    options.only = taken.only;
    return openSequence(folder_.path(), options);
  }
  Caught refusal() {
    return caught([&] { open(); });
  }
  Caught refusal(const Taken& taken) {
    return caught([&] { open(taken); });
  }

  ScratchFolder folder_;
  SequenceOptions options_;
};

inline std::vector<std::string> namesOf(const Sequence& sequence) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sequence.size(); ++i) names.push_back(sequence.frame(i).name);
  return names;
}

inline std::vector<std::string> roomsOf(const Sequence& sequence) {
  std::vector<std::string> rooms;
  for (std::size_t i = 0; i < sequence.size(); ++i) rooms.push_back(sequence.frame(i).room);
  return rooms;
}

}  // namespace estancia::test
