// What goes into a network and what comes out of it: images → input, outputs → probabilities of words.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "estancia/files/npy.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/network_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using Values = std::vector<float>;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;

/// Input of `side` pixels, everything else as plain as can be: colors as they are, values as they are.
Preprocessing plain(int side, double crop = 1) {
  Preprocessing how;
  how.width = how.height = side;
  how.crop = crop;
  how.color = Preprocessing::Color::bgr;
  return how;
}

float at(const cv::Mat& blob, int channel, int y, int x) {
  return *(blob.ptr<float>(0, channel, y) + x);
}

/// A black image with a white rectangle.
cv::Mat withRectangle(cv::Size size, const cv::Rect& white) {
  cv::Mat image(size, CV_8UC3, cv::Scalar::all(0));
  image(white).setTo(cv::Scalar::all(255));
  return image;
}

TEST(Preprocess, GivesOnePlaneAChannelInTheOrderColorsAndScaleOfTheNetwork) {
  Preprocessing how = plain(7);
  how.height = 5;
  const cv::Mat blob = preprocess(cv::Mat(20, 30, CV_8UC3, cv::Scalar(10, 20, 30)), how);
  ASSERT_EQ(blob.dims, 4);
  EXPECT_EQ(std::vector<int>(blob.size.p, blob.size.p + 4), (std::vector<int>{1, 3, 5, 7}));
  EXPECT_EQ(blob.type(), CV_32F);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(at(blob, c, 4, 6), 10 * (c + 1));
  Preprocessing scaled = plain(2);
  scaled.color = Preprocessing::Color::rgb;
  scaled.mean = {30, 20, 0};
  scaled.scale = {1, 2, 0.5};
  const cv::Mat ordered = preprocess(cv::Mat(2, 2, CV_8UC3, cv::Scalar(10, 21, 34)), scaled);
  EXPECT_EQ(at(ordered, 0, 0, 0), 4) << "red first: (34 − 30) · 1";
  EXPECT_EQ(at(ordered, 1, 0, 0), 2) << "(21 − 20) · 2";
  EXPECT_EQ(at(ordered, 2, 0, 0), 5) << "(10 − 0) · 0.5";
}

TEST(Preprocess, CutsTheExactSquareOutOfTheMiddleOrStretchesTheWholeImage) {
  // 87.5 % of 160 is 140: the square [50, 190) × [10, 150) of 240 × 160, here copied pixel by pixel
  const cv::Mat inside = withRectangle({240, 160}, {50, 10, 140, 140});
  EXPECT_EQ(cv::countNonZero(preprocess(inside, plain(140, 0.875)).reshape(1, 1) != 255), 0);
  cv::Mat corner(160, 240, CV_8UC3, cv::Scalar::all(0));
  corner.at<cv::Vec3b>(10, 50) = {1, 2, 3};
  corner.at<cv::Vec3b>(149, 189) = {4, 5, 6};
  const cv::Mat blob = preprocess(corner, plain(140, 0.875));
  EXPECT_EQ(at(blob, 1, 0, 0), 2);
  EXPECT_EQ(at(blob, 1, 139, 139), 5);
  Preprocessing how = plain(100);
  how.region = Preprocessing::Region::stretch;
  // the right quarter of a wide image is the right quarter of the input, too
  const cv::Mat stretched = preprocess(withRectangle({400, 100}, {300, 0, 100, 100}), how);
  EXPECT_EQ(at(stretched, 0, 50, 74), 0);
  EXPECT_EQ(at(stretched, 0, 50, 75), 255);
  EXPECT_EQ(at(stretched, 0, 50, 99), 255);
}

TEST(Preprocess, AveragesAllPixelsWhenItShrinks) {
  cv::Mat checkered(64, 64, CV_8UC3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      checkered.at<cv::Vec3b>(y, x) = (x + y) % 2 == 0 ? cv::Vec3b(0, 0, 0) : cv::Vec3b(200, 200, 200);
  EXPECT_EQ(at(preprocess(checkered, plain(8)), 0, 3, 3), 100);
}

TEST(Preprocess, TakesGraySixteenBitsAndAlpha) {
  const cv::Mat expected = preprocess(cv::Mat(9, 9, CV_8UC3, cv::Scalar::all(200)), plain(4));
  const auto same = [&](const cv::Mat& image) {
    return cv::norm(preprocess(image, plain(4)), expected, cv::NORM_INF) == 0;
  };
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_8UC1, cv::Scalar(200))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_8UC4, cv::Scalar(200, 200, 200, 3))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_16UC1, cv::Scalar(200 * 257))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_16UC3, cv::Scalar::all(200 * 257))));
  Preprocessing rgb = plain(4);
  rgb.color = Preprocessing::Color::rgb;
  EXPECT_EQ(at(preprocess(cv::Mat(9, 9, CV_8UC4, cv::Scalar(1, 2, 3, 4)), rgb), 0, 0, 0), 3) << "BGRA";
}

TEST(Preprocess, TakesAnySizeAndRefusesWhatIsNoImage) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 500), cv::Size(3000, 2)}) {
    const cv::Mat blob = preprocess(cv::Mat(size, CV_8UC3, cv::Scalar(5, 6, 7)), plain(16, 0.875));
    EXPECT_EQ(at(blob, 2, 15, 15), 7) << size;
  }
  EXPECT_THAT([] { preprocess(cv::Mat(), plain(4)); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { preprocess(cv::Mat(4, 4, CV_32FC3), plain(4)); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { preprocess(cv::Mat(4, 4, CV_8UC2), plain(4)); }, FailsWith(ErrorCode::invalidInput));
}

ModelSpec detector() {
  ModelSpec spec;
  spec.name = "detector";
  spec.reduce = ModelSpec::Reduce::max;
  spec.sigmoid = true;
  spec.unused = {0, 2};
  return spec;
}

float sigmoid(float x) {
  return 1 / (1 + std::exp(-x));
}

TEST(Scores, OfADetectorAreThoseOfTheSurestPlaceAndNeverOverflow) {
  const Values output{9, 1,  9, -3,  //
                      9, -2, 9, 2,   //
                      9, 0,  9, -90};
  EXPECT_THAT(toProbabilities(output, detector(), 2),
              ElementsAre(testing::FloatNear(sigmoid(1), 1e-6F), testing::FloatNear(sigmoid(2), 1e-6F)));
  EXPECT_THAT(toProbabilities(Values{0, 1000, 0, -1000}, detector(), 2), ElementsAre(1, 0));
}

TEST(Scores, OfASoftmaxAreTakenWithUnusedOutputsInEachRow) {
  ModelSpec spec = detector();
  spec.sigmoid = false;
  spec.softmax = true;
  spec.unused = {0};
  const float strong = std::exp(2.0F) / (1 + std::exp(2.0F)), half = 0.5F;
  EXPECT_THAT(toProbabilities(Values{0, 2, 5, 5}, spec, 1), ElementsAre(testing::FloatNear(strong, 1e-6F)));
  EXPECT_THAT(toProbabilities(Values{5, 5}, spec, 1), ElementsAre(testing::FloatNear(half, 1e-6F)));
}

TEST(Scores, AreRefusedWhenAnyRowIsNotANumber) {
  for (std::size_t row = 0; row < 3; ++row) {
    Values output(12);
    output[row * 4 + 1] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT([&] { toProbabilities(output, detector(), 2); }, FailsWith(ErrorCode::labelerFailure)) << row;
  }
}

cv::Mat noise(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(width * height)).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// The largest difference to OpenCV's, and that hardly any value has it.
void expectAsOpencv(const cv::Mat& image, cv::Size size) {
  cv::Mat expected, difference;
  cv::resize(image, expected, size, 0, 0, cv::INTER_AREA);
  const cv::Mat resized = resizeByArea(image, size);
  ASSERT_EQ(resized.size(), size);
  cv::absdiff(resized, expected, difference);
  EXPECT_LE(cv::norm(difference, cv::NORM_INF), 1) << image.size() << " → " << size;
  EXPECT_LE(cv::norm(difference, cv::NORM_L1), 1 + 1e-3 * static_cast<double>(expected.total() * 3))
      << image.size() << " → " << size;
}

TEST(AreaResize, IsWhatOpencvComputesAlsoOfPartsOfImages) {
  expectAsOpencv(noise(210, 210), {128, 128});
  expectAsOpencv(noise(420, 420), {299, 299});
  expectAsOpencv(noise(640, 480), {224, 224});
  expectAsOpencv(noise(1000, 31), {7, 30});
  expectAsOpencv(noise(33, 57), {32, 5});
  expectAsOpencv(noise(40, 30), {3, 29});
  expectAsOpencv(noise(3, 2), {2, 1});
  for (int from = 11; from < 60; ++from) expectAsOpencv(noise(from, 71 - from), {11, 11});
  expectAsOpencv(noise(100, 90)(cv::Rect(13, 7, 61, 53)), {40, 40});
}

TEST(AreaResize, KeepsWhatIsNotShrunkAndRefusesOtherTypesAndEnlarging) {
  const cv::Mat image = noise(17, 13);
  EXPECT_EQ(cv::norm(resizeByArea(image, image.size()), image, cv::NORM_INF), 0);
  const cv::Mat white(50, 70, CV_8UC3, cv::Scalar::all(255));
  EXPECT_EQ(cv::norm(resizeByArea(white, {33, 29}), cv::Mat(29, 33, CV_8UC3, cv::Scalar::all(255))), 0);
  EXPECT_THROW(resizeByArea(cv::Mat(9, 9, CV_8U), {4, 4}), cv::Exception);
  EXPECT_THROW(resizeByArea(noise(9, 9), {10, 4}), cv::Exception);
  EXPECT_THROW(resizeByArea(noise(9, 9), {0, 4}), cv::Exception);
}

std::string npy(const std::vector<std::vector<float>>& rows) {
  DescriptorMatrix matrix(rows.at(0).size());
  for (const auto& row : rows) matrix.append(row);
  return io::npyBytes(matrix);
}

/// An encoder whose embedding of an image is its mean blue, green and red.
std::string colorEncoder() {
  return test::smallOnnx(8, 3, [](onnx::GraphProto& g) {
    g.mutable_node()->RemoveLast();
    g.mutable_output(0)->set_name("row");
    for (int i = 0; i < 9; ++i) g.mutable_initializer(0)->set_float_data(i, i % 4 == 0 ? 1.0F : 0.0F);
  });
}

class Clip : public testing::Test {
 protected:
  Clip() {
    writeFile(scratch_ / "small.onnx", colorEncoder());
    writeFile(scratch_ / "labels.txt", "blue\ngreen\n");
    writeFile(scratch_ / "words.npy", npy({{7, 0, 0}, {0, 0.5F, 0}}));  // lengths do not matter
    settings("logit_scale = 10");
  }
  void settings(const std::string& more) {
    writeFile(scratch_ / "model.toml",
              test::modelToml("small.onnx", 8, "embeddings = \"words.npy\"\n" + more));
  }
  std::unique_ptr<Labeler> open() const { return loadModel(scratch_.path().string()); }
  test::Caught refusal() const {
    return test::caught([this] { open(); });
  }

  test::ScratchFolder scratch_;
};

TEST_F(Clip, GivesTheSoftmaxOfTheScaledCosinesInEveryEngine) {
  for (const std::string& engine : engines()) {
    SCOPED_TRACE(engine);
    LabelerOptions options;
    options.engine = engine;
    const auto labeler = loadModel(scratch_.path().string(), options);
    const auto words = labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(30, 40, 0)));
    ASSERT_EQ(words.size(), 2U);
    const double blue = std::exp(10 * 0.6), green = std::exp(10 * 0.8);  // cosines 30/50 and 40/50
    EXPECT_NEAR(words[0], blue / (blue + green), 1e-5);
    EXPECT_NEAR(words[1], green / (blue + green), 1e-5);
    EXPECT_EQ(labeler->vocabulary()[1], "green");
  }
}

TEST_F(Clip, HasTheScaleOfClipUnlessToldOtherwise) {
  settings("");
  EXPECT_EQ(readModelSpec(scratch_.path()).logitScale, 100);
  const auto words = open()->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(30, 40, 0)));
  EXPECT_NEAR(words[0], 1 / (1 + std::exp(20.0)), 1e-8);
}

TEST_F(Clip, IsAnotherModelWithOtherWordsOrAnotherScale) {
  const std::string first = open()->identity();
  settings("logit_scale = 11");
  const std::string scaled = open()->identity();
  EXPECT_NE(scaled, first);
  writeFile(scratch_ / "words.npy", npy({{7, 0, 0}, {0, 0, 1}}));
  EXPECT_NE(open()->identity(), scaled);
}

TEST_F(Clip, IsAddedWithItsEmbeddings) {
  setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
  const auto check = addModel(scratch_.path());
  EXPECT_EQ(loadModel("small")->identity(), check.identity);
  unsetenv("ESTANCIA_HOME");
}

TEST_F(Clip, RefusesEmbeddingsThatItCannotUse) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::pair<std::string, ErrorCode> cases[] = {
      {npy({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), ErrorCode::mismatch},
      {npy({{1, 0, 0, 0}, {0, 1, 0, 0}}), ErrorCode::mismatch},
      {npy({{1, 0, 0}, {0, 0, 0}}), ErrorCode::malformedFile},
      {npy({{1, nan, 0}, {0, 1, 0}}), ErrorCode::malformedFile},
      {npy({{1, 0, 0}, {0, 1, 0}}).substr(0, 100), ErrorCode::truncatedFile}};
  for (const auto& [words, code] : cases) {
    writeFile(scratch_ / "words.npy", words);
    EXPECT_THAT(refusal(), FailsWith(code));
  }
  settings("logit_scale = 0");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
  for (const std::string more : {"reduce = \"max\"", "sigmoid = true", "unused = [0]"}) {
    settings(more);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::invalidInput)) << more;
  }
}

TEST_F(Clip, SaysWhenAnImageHasNoEmbedding) {
  const auto labeler = open();
  EXPECT_THAT([&] { labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(0))); },
              FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
