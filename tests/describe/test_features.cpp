// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <thread>

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/describe/phog.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/label/label_stream.hpp"
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
  EXPECT_EQ(describe(a + "+phog+" + b, 5).values.values(), features.values.values()) << "with any threads";

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
  EXPECT_THAT([&] { describe("phgo"); }, FailsWith(ErrorCode::unknownName));
  const std::string a = model("a");
  for (const std::string& names :
       {std::string("phog+phog"), std::string("phog+"), std::string(), a + "+" + a + "/"})
    EXPECT_THAT([&] { describe(names); }, FailsWith(ErrorCode::invalidOption)) << names;
  MadeUpSequence unreadable;
  unreadable.add({});
  EXPECT_THAT([&] { describeSequence(unreadable, "phog"); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { describeSequence(MadeUpSequence(), "phog"); }, FailsWith(ErrorCode::insufficientData));
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
  EXPECT_THAT([&] { withParts(all, {"gist"}); }, FailsWith(ErrorCode::unknownName));

  const Features rows = withRows(all, {5, 0});
  ASSERT_EQ(rows.frames.size(), 2U);
  EXPECT_EQ(rows.frames[0].name, "0005.png");
  EXPECT_EQ(rows.values.row(1)[7], all.values.row(0)[7]);
  EXPECT_THAT([&] { withRows(all, {6}); }, FailsWith(ErrorCode::invalidInput));
}

Features featuresOfText(const std::string& text) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "f.csv", text);
  return featuresOf(readFeatureTable(folder / "f.csv"));
}

PartKind kindOf(const std::string& first, const std::string& second) {
  return featuresOfText("room,h0,h1,h2\nhall," + first + "\noffice," + second + "\n").parts.at(0).kind;
}

TEST(TableFeatures, ConstantSumsAreHistograms) {
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0,1"), PartKind::histogram);
  EXPECT_EQ(kindOf("50,25,25", "0,99.99,0"), PartKind::histogram) << "rounding is no difference";
  EXPECT_EQ(kindOf("0,0,0", "0,0,1"), PartKind::histogram) << "nothing was counted";
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0.5,0"), PartKind::energies);
  EXPECT_EQ(kindOf("-0.5,1.25,0.25", "0,0,1"), PartKind::energies);
  EXPECT_EQ(kindOf("0,0,0", "0,0,0"), PartKind::energies);
  EXPECT_EQ(kindOf("1,2,3", "1,2,3"), PartKind::energies) << "constants may be below 0 elsewhere";
}

TEST(TableFeatures, ASingleColumnIsNoHistogram) {
  const Features features = featuresOfText("room,height,h0,h1\nhall,1,0.5,0.5\noffice,1,0,1\n");
  ASSERT_EQ(features.parts.size(), 2U);
  EXPECT_EQ(features.parts[0].kind, PartKind::energies);
  EXPECT_EQ(features.parts[1].kind, PartKind::histogram);
  EXPECT_THAT(features.parts[1].columns, ElementsAre("h0", "h1"));
  EXPECT_EQ(features.frames[1].room, "office");
  EXPECT_THAT(features.values.row(1), ElementsAre(1, 0, 1));
}

TEST(TableFeatures, TablesOfTheSameColumnsFitEachOther) {
  const auto parts = featuresOfText("room,h0,h1\nhall,1,0\n").parts;
  EXPECT_EQ(featuresOfText("image,h0,h1,room\na,0.5,0.5,office\n").parts, parts);
  EXPECT_NE(featuresOfText("room,h0,h1,h2\nhall,1,0,0\n").parts[0].identity, parts[0].identity);
}

TEST(TableFeatures, ColumnsOfZeroAndOneAreBinary) {
  const Features features = featuresOfText("room,Chair,g0,g1,Desk,size\nhall,1,1,0,0,1\nlab,0,0,1,0,2\n");
  EXPECT_THAT(binaryParts(features), ElementsAre("Chair", "Desk")) << "g has two columns, size a 2";
}

TEST(TableFeatures, AreSelectedByRoomAndCountedByRoom) {
  const Features features = featuresOfText("room,g0,g1\nhall,1,0\nlab,0,1\nhall,3,0\n");
  EXPECT_EQ(framesPerRoom(features), (std::map<std::string, std::size_t>{{"hall", 2}, {"lab", 1}}));
  const Features hall = withRooms(features, {"hall"});
  ASSERT_EQ(hall.frames.size(), 2U);
  EXPECT_THAT(hall.values.row(1), ElementsAre(3, 0));
  EXPECT_EQ(withRooms(features, {}).frames.size(), 3U);
  EXPECT_THAT([&] { withRooms(features, {"lab", "garage"}); }, test::FailsWith(ErrorCode::unknownName));
}

}  // namespace
}  // namespace estancia
