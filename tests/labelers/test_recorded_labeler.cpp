// Recordings, also those by people, as labelers.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/labelers/model.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::FloatEq;

class Recorded : public testing::Test {
 protected:
  std::unique_ptr<Labeler> open(const std::string& more) {
    writeFile(scratch_ / "model.toml", "name = \"old\"\ntype = \"recorded\"\n" + more + "\n");
    return loadModel(scratch_.path().string());
  }
  test::ScratchFolder scratch_;
};

TEST_F(Recorded, KnowsFramesByTheirNames) {
  writeFile(scratch_ / "r.csv",
            "image,cup\na/1.png,0.1\nb/1.png,0.2\n2.jpg,0.3\nc/3.png,0.4\nd/3.jpg,0.5\nframe 000004,0.6\n");
  const auto labeler = open("file = \"r.csv\"");
  EXPECT_FALSE(labeler->needsImage());
  EXPECT_FALSE(labeler->discovers());
  const auto label = [&](const std::string& frame) { return labeler->label({}, frame)[0]; };
  EXPECT_EQ(label("a/1.png"), 0.1F);
  EXPECT_EQ(label("b/1.png"), 0.2F);
  EXPECT_EQ(label("elsewhere/2.jpg"), 0.3F) << "by the last part";
  EXPECT_EQ(label("2.png"), 0.3F) << "by that without its extension";
  EXPECT_EQ(label("x/3.jpg"), 0.5F) << "the last part before the stem";
  EXPECT_EQ(label("frame 000004"), 0.6F);
  EXPECT_THROW(label("5.png"), FrameError);
  EXPECT_THAT([&] { label("5.png"); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_THROW(label("c/1.png"), FrameError);
  EXPECT_THAT([&] { label("c/1.png"); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_THROW(label(""), FrameError);
  EXPECT_THROW(labeler->prepare({}, "5.png"), FrameError) << "said before the labeling begins";
}

TEST_F(Recorded, ReadsWhatItsSettingsName) {
  writeFile(scratch_ / "deep/r.jsonl", R"({"image": "1", "labels": {"cup": 0.25, "mug": 1}})");
  writeFile(scratch_ / "words.txt", "spoon\ncup\n");
  EXPECT_THAT(open("file = \"deep/r.jsonl\"\nlabels = \"words.txt\"")->label({}, "1"), ElementsAre(0, 0.25F));
  DescriptorSequence recording{Vocabulary({"a", "b"}), "m", {}, DescriptorMatrix(2)};
  for (const std::string name : {"0", "1"}) {
    Frame frame;
    frame.name = name;
    recording.frames.push_back(frame);
    recording.descriptors.append(std::vector<float>{0.5F, name == "0" ? 0.25F : 1});
  }
  EXPECT_EQ(RecordedLabeler(recording).identity(), "m");
  writeDescriptors(recording, scratch_ / "n.npy");
  EXPECT_THAT(open("file = \"n.npy\"")->label({}, "1"), ElementsAre(0.5F, 1));
  writeFile(scratch_ / "others.csv", "image\nx\ny\n");
  EXPECT_THAT(open("file = \"n.npy\"\nframes = \"others.csv\"")->label({}, "y"), ElementsAre(0.5F, 1));
}

TEST_F(Recorded, IsAnotherModelWithOtherNumbers) {
  writeFile(scratch_ / "r.csv", "image,cup\n1,0.1\n");
  const std::string identity = open("file = \"r.csv\"")->identity();
  EXPECT_EQ(identity.substr(0, 4), "old ");
  writeFile(scratch_ / "r.csv", "image,cup\n1,0.2\n");
  EXPECT_NE(open("file = \"r.csv\"")->identity(), identity);
}

TEST_F(Recorded, ChecksItsSettings) {
  EXPECT_THAT([&] { open("file = \"r.csv\""); }, FailsWith(ErrorCode::fileNotFound));
  writeFile(scratch_ / "r.csv", "image,cup\n1,7\n");
  for (const std::string line : {"", "file = \"../r.csv\"", "fle = \"r.csv\"", "file = \"r.csv\""})
    EXPECT_THAT([&] { open(line); }, FailsWith(ErrorCode::malformedFile)) << line;
}

TEST_F(Recorded, IsCheckedWithoutAImage) {
  writeFile(scratch_ / "r.csv", "image,cup,mug\n1,0.1,0.2\n");
  open("file = \"r.csv\"");
  EXPECT_EQ(checkModel(scratch_.path().string()).labels, 2U);
}

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
