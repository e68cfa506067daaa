// Image features as labelers, and the study that compares them with words, on made-up drives.
// SPDX-License-Identifier: Apache-2.0
#include "features/feature_study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "color_drive.hpp"
#include "estancia/describe/gist.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::HasSubstr;
namespace fs = std::filesystem;

/// Boxes on the wall of one of four rooms, seen from a little way on.
cv::Mat roomImage(int room, int step) {
  cv::RNG random(static_cast<std::uint64_t>(room) + 1);
  cv::Mat image(120, 160, CV_8UC3, cv::Scalar::all(60 + 30 * room));
  for (int i = 0; i < 25; ++i) {
    const cv::Point at(random.uniform(-20, 150) + step, random.uniform(0, 110));
    cv::rectangle(image, at, at + cv::Point(random.uniform(4, 30), random.uniform(4, 30)),
                  cv::Scalar::all(random.uniform(0, 255)), cv::FILLED);
  }
  return image;
}

class FeatureStudy : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    for (int drive = 0; drive < 3; ++drive) {
      const fs::path folder = scratch_ / ("drive" + std::to_string(drive));
      test::writeColorDrive(folder, 1);
      for (int i = 0; i < 40; ++i)
        cv::imwrite((folder / ((i < 10 ? "000" : "00") + std::to_string(i) + ".png")).string(),
                    roomImage(i / 10, i % 10 + drive));
    }
  }

  test::ScratchFolder scratch_;
  const std::string vocabulary_ =
      "[vocabulary]\nname = \"others\"\npath = \"drive2\"\nwords = 30\nvlad_words = 3\n";
  const std::string layer_ = "[[layer]]\nname = \"color\"\nmodel = \"" + (scratch_ / "sharp").string() +
                             "\"\noutput = \"mean\"\nfeatures = 3\n";
  const std::string drive_ =
      "[[drive]]\nname = \"four\"\npath = \"drive0\"\n[drive.again]\npath = \"drive1\"\n";
  const std::string rooms_ =
      "[[rooms]]\nname = \"boxes\"\npath = \"drive0\"\n[rooms.test]\npath = \"drive1\"\n";

  Findings run(const std::string& text, int threads = 1) {
    writeFile(scratch_ / "study.toml", "type = \"features\"\n" + text);
    return runExperiment({scratch_ / "study.toml"},
                         {scratch_ / "out", {scratch_ / "sharp"}, {"", threads}, nullptr}, progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  Progress progress_;
};

double valueOf(const ResultTable& table, const std::string& row, const std::string& column) {
  for (const auto& one : table.rows)
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      if (one.name == row && table.columns[c].name == column) return one.values[c].value_or(-1);
  ADD_FAILURE() << "no " << column << " of " << row << " in " << table.title;
  return -1;
}

TEST_F(FeatureStudy, PutsAllDescriptorsIntoTheSameTables) {
  const Findings found =
      run("distances = [\"l2\", \"hellinger\"]\n" + vocabulary_ + layer_ + drive_ + rooms_);
  ASSERT_EQ(found.sections.size(), 4U) << "the map, the rooms, and two tables by distance";
  const auto& maps = std::get<ResultTable>(found.sections[0]);
  const auto& rooms = std::get<ResultTable>(found.sections[1]);
  const auto& byDistance = std::get<ResultTable>(found.sections[2]);
  EXPECT_EQ(maps.rows.size(), featureTypes().size() + 2);
  for (const auto& [type, explanation] : featureTypes()) {
    EXPECT_GT(valueOf(rooms, type, "boxes"), 0.9) << type;
    EXPECT_GE(std::max(valueOf(byDistance, type, "l2"), valueOf(byDistance, type, "hellinger")), 0.4) << type;
  }
  for (const auto& row : maps.rows)
    EXPECT_THAT(row.name, testing::AnyOf(HasSubstr("(l2)"), HasSubstr("(hellinger)")));
  for (const char* column : {"nodes", "V-measure", "ARI", "purity", "edge recall", "original score",
                             "one image", "filtered", "smoothed"})
    EXPECT_TRUE(std::ranges::any_of(maps.columns, [&](const auto& c) { return c.name == column; })) << column;
}

TEST_F(FeatureStudy, MapsStaysInRoomsInRandomOrders) {
  const auto mapsOf = [&](const std::string& orders) {
    const Findings found = run("features = [\"gist\"]\ndistances = [\"l2\"]\n" + orders + drive_);
    return std::get<ResultTable>(found.sections[0]);
  };
  const double one = valueOf(mapsOf("orders = 1\n"), "gist", "V-measure, mean of orders");
  const double four = valueOf(mapsOf("orders = 4\n"), "gist", "V-measure, mean of orders");
  EXPECT_GT(one, 0);
  EXPECT_LE(one, 1);
  EXPECT_GE(four, one / 4) << "a mean that has the first order in it";
  EXPECT_LE(four, (one + 3) / 4);
  for (const auto& column : mapsOf("").columns) EXPECT_NE(column.name, "V-measure, mean of orders");
}

TEST_F(FeatureStudy, IsTheSameAgainWithMoreThreadsAndComputedOnce) {
  const std::string all = "features = [\"orb-words\", \"sift-vlad\"]\n" + vocabulary_ + drive_ + rooms_;
  run(all);
  const std::string before = readFile(scratch_ / "out/results.csv");
  fs::remove_all(scratch_ / "out");
  run(all, 3);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
  const auto written = fs::last_write_time(fs::directory_iterator(scratch_ / "out/cells")->path());
  run(all);
  EXPECT_EQ(fs::last_write_time(fs::directory_iterator(scratch_ / "out/cells")->path()), written);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
}

TEST_F(FeatureStudy, FindsDrivesByFabMapBesideDescriptors) {
  const Findings found =
      run("features = [\"gist\"]\nfab_map = [\"orb\", \"sift\"]\n" + vocabulary_ + drive_ + rooms_);
  ASSERT_EQ(found.sections.size(), 2U);
  const auto& maps = std::get<ResultTable>(found.sections[0]);
  EXPECT_EQ(std::get<ResultTable>(found.sections[1]).rows.size(), 2U) << "it tells no rooms";
  for (const std::string row : {"fab-map, orb", "fab-map, sift"}) {
    EXPECT_GT(valueOf(maps, row, "one image"), 0.9) << row;
    EXPECT_GT(valueOf(maps, row, "filtered"), 0.9) << row;
    EXPECT_LE(valueOf(maps, row, "taken for new"), 1) << row;
    EXPECT_EQ(valueOf(maps, row, "nodes"), -1) << "it makes no map";
  }
  const std::string before = readFile(scratch_ / "out/results.csv");
  fs::remove_all(scratch_ / "out");
  run("features = [\"gist\"]\nfab_map = [\"orb\", \"sift\"]\n" + vocabulary_ + drive_ + rooms_, 3);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
}

TEST_F(FeatureStudy, DrawsLayersOfTheFirstImage) {
  const std::string model = (scratch_ / "sharp").string();
  const auto shown = [&](const std::string& output, const std::string& channels) {
    return "features = [\"gist\"]\ndistances = [\"l2\"]\n[[shown_layer]]\nmodel = \"" + model +
           "\"\noutput = \"" + output + "\"\nchannels = " + channels + "\n" + drive_;
  };
  const Findings found = run(shown("mean", "3"));
  const auto& figures = std::get<Images>(found.sections.back());
  ASSERT_EQ(figures.images.size(), 1U);
  EXPECT_EQ(cv::imdecode(figures.images[0].file, cv::IMREAD_UNCHANGED).size(), cv::Size(480, 480));
  EXPECT_EQ(problem(shown("nowhere", "3")).code, ErrorCode::invalidInput);
  EXPECT_EQ(problem(shown("mean", "2")).code, ErrorCode::invalidInput) << "three numbers";
}

TEST(DrawChannels, ShowsEachByItsOwnRangeTheStrongestOnly) {
  std::vector<float> values(70 * 4, 0.0F);
  for (std::size_t c = 0; c < 70; ++c) values[c * 4 + c % 4] = static_cast<float>(c);
  const cv::Mat mosaic = drawChannels(values, 70);
  ASSERT_EQ(mosaic.size(), cv::Size(480, 480));
  const auto firstTile = mosaic({0, 0, 58, 58});  // channel 6: the six before are weaker
  EXPECT_EQ(firstTile.at<unsigned char>(50, 10), 255) << "6 % 4: below on the left";
  EXPECT_EQ(firstTile.at<unsigned char>(10, 10), 0);
  EXPECT_TRUE(drawChannels(values, 3).empty()) << "no whole channels";
  EXPECT_TRUE(drawChannels(std::span(values).first(70 * 3), 70).empty()) << "no squares";
  EXPECT_TRUE(drawChannels({}, 1).empty());
}

TEST_F(FeatureStudy, OnlyTheNamedRoomsAreMappedAndAsked) {
  run("features = [\"gist\"]\n[[drive]]\nname = \"two\"\npath = \"drive0\"\n"
      "only = [\"room1\", \"room2\"]\n[drive.again]\npath = \"drive1\"\n");
  EXPECT_THAT(readFile(scratch_ / "out/results.csv"), HasSubstr("gist,two,standardized-clr,20,"));
  EXPECT_THAT(problem("features = [\"gist\"]\n[[drive]]\nname = \"x\"\npath = \"drive0\"\nonly = []\n"
                      "[drive.again]\npath = \"drive1\"\n"),
              FailsWith(ErrorCode::malformedFile));
}

TEST_F(FeatureStudy, LeavesOutWhatIsNotThere) {
  const std::string absent = "[vocabulary]\nname = \"v\"\npath = \"nowhere\"\noptional = true\n";
  const Findings found =
      run("features = [\"gist\", \"orb-words\"]\nfab_map = [\"sift\"]\n" + absent + drive_);
  EXPECT_EQ(std::get<ResultTable>(found.sections[0]).rows.size(), 2U);
  EXPECT_THAT(found.notes, testing::Contains(HasSubstr("orb-words was left out")));
  EXPECT_THAT(found.notes, testing::Contains(HasSubstr("fab-map, sift was left out")));
}

TEST_F(FeatureStudy, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(problem(vocabulary_), FailsWith(ErrorCode::malformedFile, "`drive`"));
  EXPECT_THAT(problem(drive_), FailsWith(ErrorCode::invalidInput, "orb-words", "[vocabulary]"));
  EXPECT_THAT(problem("features = [\"gist\"]\nfab_map = [\"orb\"]\n" + drive_),
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(problem("features = [\"surf\"]\n" + drive_),
              FailsWith(ErrorCode::malformedFile, "study.toml:2", "surf", "sift-vlad"));
  EXPECT_THAT(problem("distances = [\"far\"]\n" + drive_), FailsWith(ErrorCode::malformedFile, "far", "l2"));
  EXPECT_THAT(problem("features = [\"gist\"]\n[[layer]]\nname = \"gist\"\nmodel = \"" +
                      (scratch_ / "sharp").string() + "\"\noutput = \"mean\"\nfeatures = 3\n" + drive_),
              FailsWith(ErrorCode::invalidInput, "two descriptors", "gist"));
  EXPECT_THAT(problem("features = [\"gist\"]\n[[layer]]\nname = \"color\"\nmodel = \"" +
                      (scratch_ / "sharp").string() + "\"\noutput = \"roots\"\nfeatures = 3\n" + drive_),
              FailsWith(ErrorCode::mismatch, "probabilities", "`output`"));
  EXPECT_THAT(problem("features = [\"gist\"]\n[[drive]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n"
                      "[drive.again]\npath = \"drive1\"\n"),
              FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(problem("features = [\"orb-words\"]\n[vocabulary]\nname = \"v\"\npath = \"drive2\"\nwords = "
                      "100000\n" +
                      drive_),
              FailsWith(ErrorCode::labelerFailure, "100000 visual words"));
}

TEST(FeatureLabeler, MakesGistSharesOfItsSum) {
  const auto labeler = makeFeatureLabeler("gist", {});
  const cv::Mat image = roomImage(2, 3);
  const auto shares = labeler->label(image);
  const auto numbers = gist(image);
  const double sum = std::accumulate(numbers.begin(), numbers.end(), 0.0);
  ASSERT_EQ(shares.size(), 512U);
  for (std::size_t i = 0; i < shares.size(); ++i) EXPECT_NEAR(shares[i], numbers[i] / sum, 1e-7);
  EXPECT_EQ(labeler->vocabulary()[1], "gist 1");
  const auto flat = labeler->label(cv::Mat(50, 50, CV_8UC3, cv::Scalar::all(9)));
  for (const float share : flat) EXPECT_FLOAT_EQ(share, 1.0F / 512);
}

TEST(FeatureLabeler, LearnsItsVocabularyOnceAndLate) {
  int learned = 0;
  const VocabularyImages images{"digest", [&](LocalFeature feature) {
                                  ++learned;
                                  std::vector<cv::Mat> all;
                                  for (int room = 0; room < 4; ++room)
                                    all.push_back(localFeatures(feature, roomImage(room, 0)));
                                  return all;
                                }};
  const auto words = makeFeatureLabeler("orb-words", images, {20, 3, 1});
  EXPECT_EQ(learned, 0);
  const auto bag = words->label(roomImage(0, 1));
  words->label(roomImage(1, 1));
  EXPECT_EQ(learned, 1);
  EXPECT_NEAR(std::accumulate(bag.begin(), bag.end(), 0.0), 1, 1e-5);
  EXPECT_EQ(bag.size(), 20U);
  const auto vlad = makeFeatureLabeler("sift-vlad", images, {20, 3, 1});
  const auto values = vlad->label(roomImage(0, 1));
  double squares = 0;
  for (const float value : values) squares += (2 * value - 1) * (2 * value - 1);
  EXPECT_EQ(values.size(), std::size_t{3} * 128);
  EXPECT_NEAR(squares, 1, 1e-4) << "v is (1 + v) / 2";
  EXPECT_NE(makeFeatureLabeler("orb-words", images, {20, 3, 2})->cacheKey(), words->cacheKey());
  EXPECT_NE(makeFeatureLabeler("orb-words", {"other", {}}, {20, 3, 1})->cacheKey(), words->cacheKey());
}

TEST(FeatureLabeler, RefusesUnknownTypesAndForeignImages) {
  EXPECT_THAT([] { makeFeatureLabeler("surf", {}); }, FailsWith(ErrorCode::unknownName, "surf", "orb-vlad"));
  const auto labeler = makeFeatureLabeler("phog", {});
  EXPECT_THAT(
      [&] {
        labeler->infer({cv::Mat(3, 3, CV_8U), "", {}});
      },
      FailsWith(ErrorCode::mismatch, "another labeler"));
  EXPECT_THAT(
      [&] {
        labeler->infer({cv::Mat(1, 3, CV_32F, cv::Scalar(0)), "", {}});
      },
      FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia::experiments
