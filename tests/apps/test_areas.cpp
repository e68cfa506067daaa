// `estancia areas find` refuses what it cannot use.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/io/descriptor_sequence.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

class AreasCommand : public testing::Test {
 protected:
  void SetUp() override {
    SyntheticPlaces places(2, 3);
    DescriptorSequence recording{Vocabulary({"stove", "bed", "tub"}), "test", {}, DescriptorMatrix(3)};
    for (std::size_t i = 0; i < 6; ++i) {
      Frame frame;
      frame.name = std::to_string(i);
      recording.frames.push_back(frame);
      recording.descriptors.append(places.image(i / 3));
    }
    writeDescriptors(recording, words_);
  }

  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "home.labels", file_ = scratch_ / "home.zones";
};

TEST_F(AreasCommand, NeedsDepth) {
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_}), FailsWith(ErrorCode::insufficientData, words_));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(AreasCommand, ChecksOptionsAndOutputsFirst) {
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_, "--set", "areas.cell=0"}),
              FailsWith(ErrorCode::invalidOption, "areas.cell"));
  writeFile(file_, "not ours");
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_}), FailsWith(ErrorCode::fileExists, file_));
  EXPECT_EQ(readFile(file_), "not ours");
}

TEST_F(AreasCommand, ZonesOfAnotherDriveSayNothingOfAMap) {
  const std::string map = scratch_ / "home.estancia";
  ASSERT_EQ(run({"map", words_, "-o", map}).exitCode, 0);
  ASSERT_EQ(run({"zones", "find", words_, "-o", file_, "--count", "2"}).exitCode, 0);
  const auto found = run({"localize", map, words_, "--zones", file_, "--json"});
  EXPECT_EQ(found.exitCode, 0) << found.err;
  EXPECT_THAT(found.out, testing::HasSubstr("\"belief_zone\":"));
  std::string text = readFile(file_);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string from = "\"name\":\"" + std::to_string(i) + "\"",
                      to = "\"name\":\"x" + std::to_string(i) + "\"";
    if (const auto at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
  }
  writeFile(file_, text);
  EXPECT_THAT(run({"localize", map, words_, "--zones", file_}), FailsWith(ErrorCode::mismatch, file_));
}

}  // namespace
}  // namespace estancia::test
