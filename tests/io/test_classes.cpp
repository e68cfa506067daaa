// One folder a class, with and without halves; and what must not be taken for such.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/io/sequence.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Classes : public ::testing::Test {
 protected:
  void add(const std::string& name, double blue = 9) {
    test::writeFile(folder_ / name, test::encoded(".png", test::plain(2, 2, {blue, 2, 3})));
  }
  std::unique_ptr<Sequence> open(const std::string& type = "auto", const std::string& split = "") {
    SequenceOptions options;
    options.type = type;
    options.split = split;
    return openSequence(folder_.path(), options);
  }
  static std::vector<std::string> told(const Sequence& sequence) {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < sequence.size(); ++i)
      all.push_back(sequence.frame(i).name + "=" + sequence.frame(i).room);
    return all;
  }
  test::ScratchFolder folder_;
};

TEST_F(Classes, AreTheFoldersOfTheImages) {
  for (const char* name :
       {"kitchen/image_10.png", "kitchen/image_9.png", "bedroom/image_9.png", "MITforest/a.png"})
    add(name);
  add("kitchen/image_2.png", 77);
  test::writeFile(folder_ / "kitchen/notes.txt", "no image");
  test::writeFile(folder_ / ".git/image.png", "");
  const auto sequence = open("classes");
  EXPECT_THAT(told(*sequence), ElementsAre("MITforest/a.png=MITforest", "bedroom/image_9.png=bedroom",
                                           "kitchen/image_2.png=kitchen", "kitchen/image_9.png=kitchen",
                                           "kitchen/image_10.png=kitchen"));
  EXPECT_EQ(sequence->image(2).at<cv::Vec3b>(0, 0)[0], 77);
  EXPECT_FALSE(sequence->hasDepth());
  EXPECT_THAT(sequence->warnings(), IsEmpty());
}

TEST_F(Classes, HalvesOfTheSameClassesAreFoundByThemselves) {
  for (const char* name : {"train/hall/1.png", "train/office/1.png", "train/office/2.png", "test/hall/1.png",
                           "test/office/1.png"})
    add(name);
  EXPECT_EQ(open()->size(), 5U);
  EXPECT_THAT(told(*open("auto", "train")),
              ElementsAre("train/hall/1.png=hall", "train/office/1.png=office", "train/office/2.png=office"));
  EXPECT_THAT(told(*open("classes", "test")),
              ElementsAre("test/hall/1.png=hall", "test/office/1.png=office"));
  EXPECT_THAT([&] { open("auto", "val"); }, FailsWith(ErrorCode::unknownName));
}

TEST_F(Classes, OtherFoldersAreTakenForClassesOnlyWhenAskedFor) {
  add("2026-11-01/1.png");
  add("2026-11-02/1.png");
  EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_EQ(open("classes")->size(), 2U);
  add("0.png");
  EXPECT_THAT(told(*open()), ElementsAre("0.png=")) << "images of its own make it a plain folder";
}

TEST_F(Classes, WithoutImagesAreRefused) {
  EXPECT_THAT([&] { open("classes"); }, FailsWith(ErrorCode::insufficientData));
  test::writeFile(folder_ / "file", "x");
  SequenceOptions options;
  options.type = "classes";
  EXPECT_TRUE(test::caught([&] { openSequence(folder_ / "file", options); }).code);
}

}  // namespace
}  // namespace estancia
