// The label file keeps everything, and believes nothing.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/io/label_file.hpp"
#include "estancia/io/sequence.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
namespace fs = std::filesystem;
using testing::ElementsAre;

DescriptorSequence sample() {
  DescriptorSequence sequence{
      Vocabulary({"cup", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}}), "net 0123", {}, DescriptorMatrix(3)};
  sequence.frames.push_back({"a.jpg", 1.25, Pose{1, 2, 3, 0, 0, 0, 1}, "kitchen"});
  sequence.frames.push_back({"b \xff.jpg", {}, {}, ""});
  sequence.descriptors.append(LexicalDescriptor{0.1F, 0.9F, 1});
  sequence.descriptors.append(LexicalDescriptor{1e-30F, 1.0F / 3, 0});
  return sequence;
}

TEST(LabelFile, KeepsEverythingExactly) {
  const test::ScratchFolder scratch;
  const fs::path file = scratch / "words.labels";
  const DescriptorSequence before = sample();
  io::writeLabelFile(before, file);
  const DescriptorSequence after = io::readLabelFile(file);
  EXPECT_EQ(after.vocabulary, before.vocabulary);
  EXPECT_EQ(after.vocabulary.layout().parts, before.vocabulary.layout().parts);
  EXPECT_EQ(after.model, before.model);
  EXPECT_EQ(after.descriptors.values(), before.descriptors.values());
  ASSERT_EQ(after.frames.size(), 2U);
  EXPECT_EQ(after.frames[0].name, "a.jpg");
  EXPECT_EQ(after.frames[0].timestamp, 1.25);
  EXPECT_EQ(after.frames[0].pose->z, 3);
  EXPECT_EQ(after.frames[0].room, "kitchen");
  EXPECT_EQ(after.frames[1].name, "b \\xFF.jpg");
  EXPECT_FALSE(after.frames[1].timestamp || after.frames[1].pose);
}

TEST(LabelFile, TextsOfOthersAreReadWithoutControlCharacters) {
  const test::ScratchFolder scratch;
  DescriptorSequence recording = sample();
  recording.vocabulary = Vocabulary({"cup\x1B[2J", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}});
  recording.model = "net\x1B";
  recording.frames[0].room = "kitchen\x1B";
  io::writeLabelFile(recording, scratch / "words.labels");
  const DescriptorSequence after = io::readLabelFile(scratch / "words.labels");
  EXPECT_EQ(after.vocabulary, Vocabulary({"cup\\x1B[2J", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}}));
  EXPECT_EQ(after.model, "net\\x1B");
  EXPECT_EQ(after.frames[0].room, "kitchen\\x1B");
}

TEST(LabelFile, CutAnywhereIsRefused) {
  const test::ScratchFolder scratch;
  io::writeLabelFile(sample(), scratch / "whole.labels");
  const std::string whole = test::readFile(scratch / "whole.labels");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    test::writeFile(scratch / "cut.labels", whole.substr(0, size));
    EXPECT_TRUE(test::caught([&] { io::readLabelFile(scratch / "cut.labels"); }).code) << size;
  }
  test::writeFile(scratch / "long.labels", whole + "x");
  EXPECT_TRUE(test::caught([&] { io::readLabelFile(scratch / "long.labels"); }).code);
}

TEST(LabelFile, SaysWhatItIsNot) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "text.labels", "cup\ncat\n");
  EXPECT_THAT([&] { io::readLabelFile(scratch / "text.labels"); }, FailsWith(ErrorCode::unsupportedFile));
  io::writeLabelFile(sample(), scratch / "new.labels");
  std::string newer = test::readFile(scratch / "new.labels");
  newer[8] = 2;
  test::writeFile(scratch / "new.labels", newer);
  EXPECT_THAT([&] { io::readLabelFile(scratch / "new.labels"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { writeDescriptors(sample(), scratch / "words.txt"); },
              FailsWith(ErrorCode::unsupportedFile));
}

TEST(DescriptorSequence, IsPutInOtherWords) {
  const DescriptorSequence other = toVocabulary(sample(), Vocabulary({"kitchen", "dog", "cup"}));
  EXPECT_THAT(other.descriptors.row(0), ElementsAre(1, 0, 0.1F));
  EXPECT_EQ(other.frames.size(), 2U);
  DescriptorSequence cranes{
      Vocabulary({"cup", "crane", "crane"}), "m", {{"a", {}, {}, ""}}, DescriptorMatrix(3)};
  cranes.descriptors.append(LexicalDescriptor{0.1F, 0.7F, 0.2F});
  EXPECT_THAT(toVocabulary(cranes, Vocabulary({"crane", "cup", "crane"})).descriptors.row(0),
              ElementsAre(0.7F, 0.1F, 0.2F));
}

}  // namespace
}  // namespace estancia
