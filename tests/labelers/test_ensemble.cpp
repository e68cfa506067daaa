// Several models in conjunction: words side by side or merged, each member's own cache.
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
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using testing::ElementsAre;
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

TEST_F(EnsembleFile, IsOpenedByName) {
  write("members = [\"small\", {model = \"small\", weight = 0.5, temperature = 2}]");
  const auto pair = loadModel("pair");
  EXPECT_THAT(pair->vocabulary().layout().parts, ElementsAre(LabelPart{4, 2}, LabelPart{4, 0.5F}));
  EXPECT_EQ(pair->label(image).size(), 8U);
  EXPECT_EQ(pair->identity().substr(0, 5), "pair ");
}

TEST_F(EnsembleFile, IsNotNeededForEqualPartners) {
  const auto pair = loadModel("small+small");
  EXPECT_EQ(pair->vocabulary().size(), 8U);
  EXPECT_THAT([] { loadModel("small++small"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([] { loadModel("small+smal"); }, FailsWith(ErrorCode::unknownName));
}

TEST_F(EnsembleFile, IsRefusedWithAnyMistake) {
  for (const std::string toml :
       {"members = [\"pair\"]", "members = [{model = \"small\", weight = -1}]", "members = [{weight = 1}]",
        "members = [\"small\"]\nfusion = \"cold\"", "members = [\"small\"]\nfile = \"x\"", ""})
    EXPECT_THAT(refusal(toml), FailsWith(ErrorCode::malformedFile)) << toml;
}

TEST_F(EnsembleFile, ThatNameEachOtherAreRefusedAtOnce) {
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

}  // namespace
}  // namespace estancia
