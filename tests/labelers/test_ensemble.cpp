// Labelers without a network of their own: several together, and recordings, also those by people.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/ensemble.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::FloatEq;
using testing::FloatNear;

/// Gives one answer for every image, and counts the calls.
class Constant final : public Labeler {
 public:
  Constant(std::vector<std::string> labels, LexicalDescriptor says, std::string name = "constant")
      : vocabulary_(std::move(labels)), says_(std::move(says)), name_(std::move(name)) {}
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return name_; }
  bool discovers() const override { return discovering; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& /*prepared*/) override {
    ++asked;
    return says_;
  }
  int asked = 0;
  bool discovering = false;

 private:
  Vocabulary vocabulary_;
  LexicalDescriptor says_;
  std::string name_;
};

EnsembleMember member(std::vector<std::string> labels, LexicalDescriptor says, float weight = 1,
                      float temperature = 1) {
  return {std::make_unique<Constant>(std::move(labels), std::move(says)), weight, temperature};
}

template <class... Members>
std::vector<EnsembleMember> list(Members... members) {
  std::vector<EnsembleMember> all;
  (all.push_back(std::move(members)), ...);
  return all;
}

const cv::Mat image(2, 2, CV_8UC3, cv::Scalar::all(7));

TEST(Ensemble, PutsVocabulariesSideBySideAsParts) {
  Ensemble both("both",
                list(member({"cup", "cat"}, {0.25F, 0.75F}, 2), member({"kitchen", "cup"}, {0.9F, 0.1F})),
                Fusion::distances);
  EXPECT_THAT(both.vocabulary().labels(), ElementsAre("cup", "cat", "kitchen", "cup"));
  EXPECT_THAT(both.vocabulary().layout().parts, ElementsAre(LabelPart{2, 2}, LabelPart{2, 1}));
  EXPECT_THAT(both.label(image), ElementsAre(0.25F, 0.75F, 0.9F, 0.1F));
}

/// Labels regions, too.
class ConstantDetector final : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "detector"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& /*prepared*/) override { return {0.5F, 0.5F}; }
  std::vector<std::size_t> regionLabels() const override { return {0, 1}; }
  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& /*bgr*/,
                                              std::span<const cv::Rect2d> regions) override {
    std::vector<LexicalDescriptor> all;
    for (const cv::Rect2d& region : regions) all.push_back({static_cast<float>(region.x), 0.25F});
    return all;
  }

 private:
  Vocabulary vocabulary_{{"bed", "cup"}};
};

TEST(Ensemble, TellsOfRegionsWhatItsDetectorsTell) {
  const std::array regions{cv::Rect2d(0.5, 0, 0.5, 1), cv::Rect2d(0, 0, 1, 1)};
  const auto with = [](Fusion fusion) {
    std::vector<EnsembleMember> members = list(member({"cup", "cat"}, {0.25F, 0.75F}));
    members.push_back({std::make_unique<ConstantDetector>()});
    return Ensemble("both", std::move(members), fusion);
  };
  Ensemble both = with(Fusion::distances);
  EXPECT_THAT(both.regionLabels(), ElementsAre(2, 3));
  EXPECT_THAT(both.labelRegions(image, regions),
              ElementsAre(ElementsAre(0.5F, 0.25F), ElementsAre(0.0F, 0.25F)));
  Ensemble merged = with(Fusion::probabilities);
  EXPECT_TRUE(merged.regionLabels().empty());
  EXPECT_THAT([&] { merged.labelRegions(image, regions); }, FailsWith(ErrorCode::invalidInput));
}

TEST(Ensemble, MergesEqualLabelsByWeight) {
  Ensemble both("both",
                list(member({"cup", "cat"}, {0.2F, 0.8F}, 3), member({"kitchen", "cup"}, {0.4F, 0.6F})),
                Fusion::probabilities);
  EXPECT_THAT(both.vocabulary().labels(), ElementsAre("cup", "cat", "kitchen"));
  EXPECT_EQ(both.vocabulary().layout().parts.size(), 1U);
  EXPECT_THAT(both.label(image), ElementsAre(FloatNear(0.75F * 0.2F + 0.25F * 0.6F, 1e-6F),
                                             FloatNear(0.6F, 1e-6F), FloatNear(0.1F, 1e-6F)));
}

TEST(Ensemble, AllThatChangesItsWordsChangesItsIdentity) {
  const auto identity = [](float weight, float temperature, Fusion fusion) {
    return Ensemble("e", list(member({"a"}, {1}, weight, temperature), member({"b"}, {1})), fusion)
        .identity();
  };
  const std::string base = identity(1, 1, Fusion::distances);
  EXPECT_EQ(base, identity(1, 1, Fusion::distances));
  EXPECT_NE(base, identity(2, 1, Fusion::distances));
  EXPECT_NE(base, identity(1, 2, Fusion::distances));
  EXPECT_NE(base, identity(1, 1, Fusion::probabilities));
}

TEST(Ensemble, RefusesWhatCannotWorkTogether) {
  const auto refusal = [](std::vector<EnsembleMember> members) {
    return test::caught([&] { Ensemble("e", std::move(members), Fusion::distances); });
  };
  EXPECT_THAT(refusal({}), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusal(list(member({"a"}, {1}, 0))), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(refusal(list(member({"a"}, {1}, 1, NAN))), FailsWith(ErrorCode::invalidOption));
  auto inner = std::make_unique<Ensemble>("inner", list(member({"a"}, {1})), Fusion::distances);
  EXPECT_THAT(refusal(list(EnsembleMember{std::move(inner)})), FailsWith(ErrorCode::invalidInput));
  auto open = std::make_unique<Constant>(std::vector<std::string>{"a"}, LexicalDescriptor{1});
  open->discovering = true;
  EXPECT_THAT(refusal(list(EnsembleMember{std::move(open)})), FailsWith(ErrorCode::invalidInput));
}

/// Three frames, three images.
class Frames final : public Sequence {
 public:
  Frames() {
    for (int i = 0; i < 3; ++i) frames_.push_back({"frame " + std::to_string(i), {}, {}, ""});
  }
  std::string name() const override { return "frames"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override {
    ++decoded;
    return cv::Mat(2, 2, CV_8UC3, cv::Scalar::all(static_cast<double>(i)));
  }
  std::string fingerprint(std::size_t i) const override { return "image " + std::to_string(i); }
  mutable std::atomic<int> decoded = 0;

 private:
  std::vector<Frame> frames_;
};

std::vector<LabeledFrame> all(const Sequence& sequence, Labeler& labeler, LabelCache* cache) {
  std::vector<LabeledFrame> frames;
  LabelStream stream(sequence, labeler, {.cache = cache});
  while (auto frame = stream.next()) frames.push_back(std::move(*frame));
  return frames;
}

TEST(Ensemble, MembersRememberForThemselves) {
  const test::ScratchFolder scratch;
  LabelCache cache(scratch.path(), 1 << 20);
  const Frames frames;
  Constant alone({"cup", "cat"}, {0.25F, 0.75F}, "first");
  all(frames, alone, &cache);
  EXPECT_EQ(alone.asked, 3);

  auto first = std::make_unique<Constant>(std::vector<std::string>{"cup", "cat"},
                                          LexicalDescriptor{0.25F, 0.75F}, "first");
  auto second = std::make_unique<Constant>(std::vector<std::string>{"dog"}, LexicalDescriptor{1}, "second");
  const auto* firstSeen = first.get();
  const auto* secondSeen = second.get();
  std::vector<EnsembleMember> members;
  members.push_back({std::move(first)});
  members.push_back({std::move(second)});
  Ensemble both("both", std::move(members), Fusion::distances);
  for (const auto& frame : all(frames, both, &cache))
    EXPECT_THAT(frame.descriptor, ElementsAre(0.25F, 0.75F, 1));
  EXPECT_EQ(firstSeen->asked, 0) << "known from when it was alone";
  EXPECT_EQ(secondSeen->asked, 3);

  frames.decoded = 0;
  LabelStream stream(frames, both, {.cache = &cache});
  while (const auto frame = stream.next()) EXPECT_TRUE(frame->remembered);
  EXPECT_EQ(secondSeen->asked, 3);
  EXPECT_EQ(frames.decoded, 0) << "nothing to look at";
}

class EnsembleFile : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ESTANCIA_HOME", scratch_.path().c_str(), 1);
    test::writeSmallModel(scratch_ / "models/small");
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }
  test::Caught refusal(const std::string& toml) {
    write(toml);
    return test::caught([&] { loadModel("pair"); });
  }
  void write(const std::string& toml) {
    test::writeFile(scratch_ / "models/pair/model.toml", "name = \"pair\"\ntype = \"ensemble\"\n" + toml);
  }
  test::ScratchFolder scratch_;
};

TEST_F(EnsembleFile, IsOpenedByNameAndNotNeededForEqualPartners) {
  write("members = [\"small\", {model = \"small\", weight = 0.5, temperature = 2}]");
  const auto pair = loadModel("pair");
  EXPECT_THAT(pair->vocabulary().layout().parts, ElementsAre(LabelPart{4, 2}, LabelPart{4, 0.5F}));
  EXPECT_EQ(pair->label(image).size(), 8U);
  EXPECT_EQ(pair->identity().substr(0, 5), "pair ");
  const auto partners = loadModel("small+small");
  EXPECT_EQ(partners->vocabulary().size(), 8U);
  EXPECT_THAT([] { loadModel("small++small"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([] { loadModel("small+smal"); }, FailsWith(ErrorCode::unknownName));
}

TEST_F(EnsembleFile, IsRefusedWithAnyMistakeAndWhenItNamesItself) {
  for (const std::string toml :
       {"members = [\"pair\"]", "members = [{model = \"small\", weight = -1}]", "members = [{weight = 1}]",
        "members = [\"small\"]\nfusion = \"cold\"", "members = [\"small\"]\nfile = \"x\"", ""})
    EXPECT_THAT(refusal(toml), FailsWith(ErrorCode::malformedFile)) << toml;
  write("members = [\"other\"]");
  test::writeFile(scratch_ / "models/other/model.toml",
                  "name = \"other\"\ntype = \"ensemble\"\nmembers = [\"pair\"]\n");
  EXPECT_THAT([] { loadModel("pair"); }, FailsWith(ErrorCode::malformedFile));
}

TEST(Ensemble, NoTemperatureMakesWordsVanish) {
  for (const float temperature : {0.01F, 0.5F, 100.0F}) {
    Ensemble one("one", list(member({"a", "b", "c"}, {0.02F, 0.01F, -1e-6F}, 1, temperature)),
                 Fusion::distances);
    const auto p = one.label(image);
    EXPECT_NEAR(p[0] + p[1] + p[2], 0.03, 1e-6) << "the sum it had, at T = " << temperature;
    EXPECT_NEAR(p[1] / p[0], std::pow(0.5, 1 / static_cast<double>(temperature)), 1e-5)
        << "softmax of logits / T";
    EXPECT_GE(p[2], 0) << "rounding below 0 is no number to take roots of";
  }
}

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

TEST_F(Recorded, ReadsWhatItsSettingsNameAndIsAnotherModelWithOtherNumbers) {
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
  DescriptorSequence empty = recording;
  empty.descriptors = DescriptorMatrix(2);
  for (const float p : {0.0F, 0.5F}) empty.descriptors.append(std::vector<float>{p, 0});
  RecordedLabeler withoutLabels(empty);
  EXPECT_THROW(withoutLabels.label({}, "0"), FrameError) << "no label is not known to be improbable";
  EXPECT_THAT(withoutLabels.label({}, "1"), ElementsAre(0.5F, 0));
  writeDescriptors(recording, scratch_ / "n.npy");
  EXPECT_THAT(open("file = \"n.npy\"")->label({}, "1"), ElementsAre(0.5F, 1));
  writeFile(scratch_ / "others.csv", "image\nx\ny\n");
  EXPECT_THAT(open("file = \"n.npy\"\nframes = \"others.csv\"")->label({}, "y"), ElementsAre(0.5F, 1));
  writeFile(scratch_ / "r.csv", "image,cup\n1,0.1\n");
  const std::string identity = open("file = \"r.csv\"")->identity();
  EXPECT_EQ(identity.substr(0, 4), "old ");
  writeFile(scratch_ / "r.csv", "image,cup\n1,0.2\n");
  EXPECT_NE(open("file = \"r.csv\"")->identity(), identity);
}

TEST_F(Recorded, ChecksItsSettingsAndIsCheckedWithoutAnImage) {
  EXPECT_THAT([&] { open("file = \"r.csv\""); }, FailsWith(ErrorCode::fileNotFound));
  writeFile(scratch_ / "r.csv", "image,cup\n1,7\n");
  for (const std::string line : {"", "file = \"../r.csv\"", "fle = \"r.csv\"", "file = \"r.csv\""})
    EXPECT_THAT([&] { open(line); }, FailsWith(ErrorCode::malformedFile)) << line;
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

TEST_F(Human, LabelsShareTheProbabilityUnlessTheyHaveConfidences) {
  const auto recording =
      read("image,label\n1.png,kitchen\n2.png,\"office; meeting, room\"\n3.png,office;kitchen;office\n");
  EXPECT_THAT(recording.vocabulary.labels(), ElementsAre("kitchen", "meeting, room", "office"));
  EXPECT_THAT(recording.descriptors.row(0), ElementsAre(1, 0, 0));
  EXPECT_THAT(recording.descriptors.row(1), ElementsAre(0, 0.5F, 0.5F));
  EXPECT_THAT(recording.descriptors.row(2), ElementsAre(0.5F, 0, 0.5F)) << "said twice is said once";
  const auto lines = read("1.png,\"cup, mug\"\n1.png,spoon\n");
  EXPECT_THAT(lines.vocabulary.labels(), ElementsAre("cup, mug", "spoon"));
  EXPECT_THAT(lines.descriptors.row(0), ElementsAre(0.5F, 0.5F));
  const auto sure = read("image,label,confidence\n1,cup,0.75\n1,mug,0.5\n2,cup,1\n");
  EXPECT_THAT(sure.descriptors.row(0), ElementsAre(0.75F, 0.5F)) << "several labels need not add up to 1";
  EXPECT_THAT(sure.descriptors.row(1), ElementsAre(1, 0));
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
