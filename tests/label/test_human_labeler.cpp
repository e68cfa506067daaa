// People as labelers.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/label/model.hpp"
#include "estancia/label/recorded_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::FloatEq;

class Human : public testing::Test {
 protected:
  DescriptorSequence read(const std::string& csv, double certainty = 1,
                          const std::optional<Vocabulary>& given = {}) {
    writeFile(scratch_ / "h.csv", csv);
    return readHumanLabels(scratch_ / "h.csv", given, certainty);
  }
  test::Caught refusal(const std::string& csv) {
    return test::caught([&] { read(csv); });
  }
  test::ScratchFolder scratch_;
};

TEST_F(Human, LabelsShareTheProbability) {
  const auto recording =
      read("image,label\n1.png,kitchen\n2.png,\"office; meeting, room\"\n3.png,office;kitchen;office\n");
  EXPECT_THAT(recording.vocabulary.labels(), ElementsAre("kitchen", "meeting, room", "office"));
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(1, 0, 0));
  EXPECT_THAT(recording.descriptors.row(1), ElementsAre(0, 0.5F, 0.5F));
  EXPECT_THAT(recording.descriptors.row(2), ElementsAre(0.5F, 0, 0.5F)) << "said twice is said once";
  const auto lines = read("1.png,\"cup, mug\"\n1.png,spoon\n");
  EXPECT_THAT(lines.vocabulary.labels(), ElementsAre("cup, mug", "spoon"));
  EXPECT_THAT(lines.descriptors.row(0), ElementsAre(0.5F, 0.5F));
}

TEST_F(Human, GivesConfidences) {
  const auto recording = read("image,label,confidence\n1,cup,0.75\n1,mug,0.5\n2,cup,1\n");
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(0.75F, 0.5F))
      << "several labels need not add up to 1";
  EXPECT_THAT(recording.descriptors.row(1), ElementsAre(1, 0));
}

TEST_F(Human, LeavesALittleToTheOtherWords) {
  const auto recording = read("1,cup\n2,cup;mug\n", 0.9, Vocabulary({"mug", "cup", "spoon", "fork"}));
  EXPECT_THAT(recording.descriptors.row(0),
              ElementsAre(FloatEq(0.025F), FloatEq(0.925F), FloatEq(0.025F), FloatEq(0.025F)));
  EXPECT_THAT(recording.descriptors.row(1),
              ElementsAre(FloatEq(0.475F), FloatEq(0.475F), FloatEq(0.025F), FloatEq(0.025F)));
}

TEST_F(Human, RefusesWhatIsUnclear) {
  for (const std::string csv :
       {"1.png\n", "1.png,cup\n2.png,cup,mug\n", "1.png,cup,high\n", "1.png,cup,nan\n", "1.png,cup,95\n",
        "1.png,cup,0.5\n1.png,cup,0.7\n", "1.png,\n", "1.png,cup;;mug\n", ",cup\n"})
    EXPECT_THAT(refusal(csv), FailsWith(ErrorCode::malformedFile)) << csv;
  for (const std::string csv : {"", "image,label\n"})
    EXPECT_THAT(refusal(csv), FailsWith(ErrorCode::insufficientData)) << csv;
  EXPECT_THAT([&] { read("1,cpu\n", 1, Vocabulary({"cup"})); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { read("1,cup\n", 1.5); }, FailsWith(ErrorCode::invalidOption));
}

TEST_F(Human, IsAModel) {
  writeFile(scratch_ / "h.csv", "room/1.png,cup\n2.png,mug\n");
  const auto open = [&](const std::string& more) {
    writeFile(scratch_ / "model.toml", "name = \"me\"\ntype = \"human\"\nfile = \"h.csv\"\n" + more + "\n");
    return loadModel(scratch_.path().string());
  };
  EXPECT_FALSE(open("")->needsImage());
  EXPECT_THAT(open("")->label({}, "1.png"), ElementsAre(FloatEq(0.975F), FloatEq(0.025F)));
  EXPECT_THAT(open("certainty = 1")->label({}, "2.png"), ElementsAre(0, 1));
  EXPECT_THROW(open("")->label({}, "3.png"), FrameError);
  EXPECT_NE(open("certainty = 0.5")->identity(), open("")->identity());
  EXPECT_THAT([&] { open("certanty = 1"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { open("certainty = 2"); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia
