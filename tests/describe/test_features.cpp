// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <thread>

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/describe/load_descriptor.hpp"
#include "estancia/describe/phog.hpp"
#include "estancia/label/record.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::busyImage;
using test::FailsWith;
using test::MadeUpSequence;
using testing::ElementsAre;

class DescribeSequence : public testing::Test {
 protected:
  DescribeSequence() {
    for (unsigned i = 0; i < 6; ++i) sequence_.add(busyImage({64, 48}, i));
  }

  std::string model(const std::string& name) {
    test::writeSmallModel(scratch_ / name);
    const auto toml = scratch_ / name / "model.toml";
    std::string text = test::readFile(toml);
    const auto at = text.find("name = \"") + 8;
    text.replace(at, text.find('"', at) - at, name);
    test::writeFile(toml, text);
    return (scratch_ / name).string();
  }
  Features describe(const std::string& descriptors, int threads = 1) {
    DescribeOptions options;
    options.labeler.threads = threads;
    problems_.clear();
    return describeSequence(sequence_, descriptors, options, Progress::none(), &problems_);
  }

  test::ScratchFolder scratch_;
  MadeUpSequence sequence_;
  std::vector<std::string> problems_;
};

TEST_F(DescribeSequence, GivesEveryNameItsOwnPart) {
  const std::string a = model("a"), b = model("b");
  const Features features = describe(a + "+phog+" + b);
  EXPECT_EQ(features.name(), "a+phog+b");
  ASSERT_EQ(features.frames.size(), 6U);
  EXPECT_EQ(features.frames[1].name, "0001.png");
  EXPECT_EQ(features.frames[1].room, "office");
  EXPECT_EQ(features.values.size(), 6U);
  EXPECT_EQ(features.values.labels(), 4U + 630U + 4U);
  EXPECT_EQ(features.parts[0].kind, PartKind::probabilities);
  EXPECT_EQ(features.parts[0].identity, loadModel(a)->identity());
  EXPECT_EQ(features.parts[0].columns, loadModel(a)->vocabulary().labels());
  EXPECT_EQ(features.parts[1], Phog().parts().front());
  EXPECT_THAT(problems_, testing::IsEmpty());

  const auto labeler = loadModel(b);
  for (std::size_t i = 0; i < 6; ++i) {
    const DescriptorView row = features.values.row(i);
    const std::vector<float> edges = phog(sequence_.image(i)), words = labeler->label(sequence_.image(i));
    EXPECT_TRUE(std::equal(edges.begin(), edges.end(), row.begin() + 4));
    EXPECT_TRUE(std::equal(words.begin(), words.end(), row.begin() + 634));
  }
}

TEST_F(DescribeSequence, OneViewHasTheSameNumbersWhoeverAsks) {
  const std::string names = model("a") + "+phog";
  const Features all = describe(names);
  const auto descriptor = loadDescriptor(names);
  EXPECT_EQ(descriptor->parts(), all.parts);
  EXPECT_TRUE(descriptor->needsImage());
  EXPECT_FALSE(descriptor->needsDepth());
  EXPECT_TRUE(loadDescriptor("phog+esf")->needsDepth());
  std::vector<std::vector<float>> rows(all.frames.size());
  std::vector<std::thread> robots;
  for (std::size_t i = 0; i < rows.size(); ++i)
    robots.emplace_back([&, i] {
      const Features one = featuresOf(*descriptor, {.image = sequence_.image(i), .frame = "now"});
      EXPECT_EQ(one.frames.at(0).name, "now");
      rows[i] = one.values.values();
    });
  for (std::thread& robot : robots) robot.join();
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_TRUE(std::ranges::equal(rows[i], all.values.row(i))) << "view " << i;
  EXPECT_THAT([&] { featuresOf(*descriptor, View{}); }, FailsWith(ErrorCode::invalidInput));
}

TEST_F(DescribeSequence, DoesNotDependOnThreads) {
  EXPECT_EQ(describe("phog", 1).values.values(), describe("phog", 5).values.values());
}

TEST_F(DescribeSequence, LeavesOutFramesThatCannotBeDescribedAndTellsWhy) {
  sequence_.add({});
  sequence_.add(busyImage({64, 48}, 9));
  const Features features = describe("phog+" + model("a"));
  ASSERT_EQ(features.frames.size(), 7U);
  EXPECT_EQ(features.frames[6].name, "0007.png");
  EXPECT_THAT(problems_, ElementsAre("0006.png: cannot be read"));
  sequence_.add(cv::Mat(20, 20, CV_8UC2));  // OpenCV's own exception
  EXPECT_EQ(describe("phog").frames.size(), 7U);
  EXPECT_THAT(problems_, ElementsAre(testing::_, testing::StartsWith("0008.png")));
}

TEST_F(DescribeSequence, RefusesWhatItCannotDo) {
  EXPECT_THAT([&] { describe("phgo"); }, FailsWith(ErrorCode::unknownName, "phgo", "phog, gist, esf"));
  EXPECT_THAT([&] { describe("phog+phog"); }, FailsWith(ErrorCode::invalidOption, "phog+phog"));
  EXPECT_THAT([&] { describe("phog+"); }, FailsWith(ErrorCode::invalidOption, "\"phog+\""));
  EXPECT_THAT([&] { describe(""); }, FailsWith(ErrorCode::invalidOption, "\"\""));
  const std::string a = model("a");
  EXPECT_THAT([&] { describe(a + "+" + a + "/"); }, FailsWith(ErrorCode::invalidOption, a));
  MadeUpSequence unreadable;
  unreadable.add({});
  EXPECT_THAT([&] { describeSequence(unreadable, "phog"); },
              FailsWith(ErrorCode::insufficientData, unreadable.name(), "0000.png"));
  EXPECT_THAT([&] { describeSequence(MadeUpSequence(), "phog"); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(DescribeSequence, TakesWordsOutOfTheCache) {
  LabelCache cache(scratch_ / "cache");
  DescribeOptions options;
  options.cache = &cache;
  const std::string a = model("a");
  const Features first = describeSequence(sequence_, a, options);
  ASSERT_EQ(cache.usage().size(), 1U);
  EXPECT_EQ(cache.usage()[0].images, 6U);
  const Features second = describeSequence(sequence_, a, options);
  EXPECT_EQ(first.values.values(), second.values.values());
  EXPECT_EQ(first.parts, second.parts);
}

TEST_F(DescribeSequence, GivesAllFramesTheWordsThatAreDiscovered) {
  test::writeFile(scratch_ / "discover/model.toml", R"(name = "discover"
type = "process"
command = ["sh", "-c", 'n=0; while read -r image; do n=$((n+1)); echo "{\"image\": \"$image\", \"labels\": {\"word $n\": 0.5}}"; done']
)");
  const Features features = describe((scratch_ / "discover").string());
  ASSERT_EQ(features.parts.size(), 1U);
  EXPECT_EQ(features.parts[0].size(), 6U);
  EXPECT_EQ(features.values.labels(), 6U);
  EXPECT_FLOAT_EQ(features.values.row(0)[0], 0.5F);
  EXPECT_FLOAT_EQ(features.values.row(0)[5], 0);
  EXPECT_FLOAT_EQ(features.values.row(5)[5], 0.5F);
}

TEST_F(DescribeSequence, WordsOfARecordingAreOnePartAModel) {
  const std::string a = model("a"), b = model("b");
  const auto both = loadModel(a + "+" + b);
  const Features recorded = featuresOf(record(sequence_, *both));
  const Features described = describe(a + "+" + b);
  EXPECT_EQ(recorded.name(), "a+b");
  EXPECT_EQ(recorded.values.values(), described.values.values());
  EXPECT_EQ(recorded.parts[1].columns, described.parts[1].columns);

  const auto single = loadModel(a);
  EXPECT_EQ(featuresOf(record(sequence_, *single)).parts, describe(a).parts);
}

TEST_F(DescribeSequence, PartsAndRowsAreTakenInTheOrderGiven) {
  const Features all = describe(model("a") + "+phog");
  const Features turned = withParts(all, {"phog", "a"});
  EXPECT_EQ(turned.name(), "phog+a");
  EXPECT_EQ(turned.values.labels(), 634U);
  EXPECT_EQ(turned.values.row(3)[630], all.values.row(3)[0]);
  EXPECT_EQ(turned.values.row(3)[0], all.values.row(3)[4]);
  EXPECT_THAT([&] { withParts(all, {"gist"}); }, FailsWith(ErrorCode::unknownName, "gist", "a, phog"));

  const Features rows = withRows(all, {5, 0});
  ASSERT_EQ(rows.frames.size(), 2U);
  EXPECT_EQ(rows.frames[0].name, "0005.png");
  EXPECT_EQ(rows.values.row(1)[7], all.values.row(0)[7]);
  EXPECT_THAT([&] { withRows(all, {6}); }, FailsWith(ErrorCode::invalidInput, "6"));
}

}  // namespace
}  // namespace estancia
