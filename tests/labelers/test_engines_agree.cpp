// Real networks: the engines agree with each other and with those that others have written.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <ostream>

#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/model.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

struct Network {
  const char* file;
  const char* labels;
  int side;
  enum class Input { mobilenet, squeezenet, places } input = Input::mobilenet;
};
void PrintTo(const Network& network, std::ostream* out) {
  *out << network.file;
}

using Input = Network::Input;
const Network networks[] = {{"mobilenet_v1_0.25_128_quant.tflite", "imagenet_1001.txt", 128},
                            {"tf2_mobilenet_v2_1.0_224_ptq.onnx", "imagenet_1001.txt", 224},
                            {"squeezenet_v1.1.onnx", "imagenet_1000.txt", 227, Input::squeezenet},
                            {"squeezenet_places365.onnx", "places_365.txt", 224, Input::places}};

Preprocessing inputOf(const Network& network) {
  Preprocessing how = test::mobilenetInput(network.side);
  if (network.input == Input::mobilenet) return how;
  how.color = Preprocessing::Color::bgr;
  how.mean = {104, 117, 123};
  how.scale = {1, 1, 1};
  if (network.input == Input::places) {
    how.mean = {104.05, 112.51, 116.68};
    how.scale = {1 / 255.0, 1 / 255.0, 1 / 255.0};
  }
  return how;
}

/// Both engines, several numbers of threads, and batches on the same photographs.
void expectAgreement(const ModelSpec& spec, const std::vector<cv::Mat>& photographs) {
  const auto reference = loadModel(spec, {"opencv", 1});
  const auto labeler = loadModel(spec, {"onnxruntime", 1});
  std::vector<Prepared> prepared;
  std::vector<LexicalDescriptor> words;
  for (const auto& image : photographs) {
    prepared.push_back(labeler->prepare(image));
    words.push_back(labeler->infer(prepared.back()));
    const auto expected = reference->infer(prepared.back());
    ASSERT_EQ(words.back().size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_NEAR(words.back()[i], expected[i], 1e-4);
  }
  const auto several = loadModel(spec, {"onnxruntime", 2});
  EXPECT_EQ(several->infer(prepared[0]), words[0]);
  const auto results = several->inferBatch(prepared);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].problem, "");
    EXPECT_EQ(results[i].descriptor, words[i]) << "in a batch";
  }
}

class EnginesAgree : public testing::TestWithParam<Network> {};
INSTANTIATE_TEST_SUITE_P(All, EnginesAgree, testing::ValuesIn(networks), [](const auto& param) {
  std::string name = param.param.file;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST_P(EnginesAgree, OnPhotographs) {
  ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");
  const Network& network = GetParam();
  const test::ScratchFolder scratch;
  expectAgreement(test::testModel(*models, network.file, network.labels, inputOf(network), scratch),
                  test::photographs(*photos, 2));
}

TEST(TfliteNetwork, LabelsLikeItsOnnxTwin) {
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");
  const auto images = test::photographs(*photos, 6);
  for (const auto& [name, side] : {std::pair<std::string, int>{"mobilenet_v1_0.25_128_quant", 128},
                                   {"tf2_mobilenet_v2_1.0_224_ptq", 224}}) {
    const test::ScratchFolder scratch;
    const auto open = [&, network = name, input = test::mobilenetInput(side)](const std::string& type) {
      return openWithOpencv(test::testModel(*models, network + type, "imagenet_1001.txt", input, scratch));
    };
    const auto ours = open(".tflite"), twin = open(".onnx");
    ASSERT_EQ(ours->vocabulary().size(), 1001U);
    for (const cv::Mat& image : images) {
      const auto a = ours->label(image), b = twin->label(image);
      EXPECT_EQ(test::best(a, 1), test::best(b, 1)) << name;
      for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 2e-4) << name;
    }
  }
}

TEST(DefaultNetwork, GivesTheSameWordsWithEitherEngine) {
  ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");
  expectAgreement(readModelSpec(*folder), test::photographs(*photos, 1));
}

struct Answer {
  const char* word;
  double score;
};

class CocoSsd : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto folder = test::findFetched("models/coco-ssd");
    ESTANCIA_NEEDS(folder, "the detector is missing; run script/bootstrap");
    detector_ = loadModel(folder->string(), {GetParam(), 0});
  }

  /// The best labels of `image` must be these, in this order.
  void expectBest(const cv::Mat& image, const std::vector<Answer>& expected, double tolerance) {
    const auto words = detector_->label(image);
    const auto best = test::best(words, expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(detector_->vocabulary()[best[i]], expected[i].word);
      EXPECT_NEAR(words[best[i]], expected[i].score, tolerance) << expected[i].word;
    }
  }

  std::unique_ptr<Labeler> detector_;
};

INSTANTIATE_TEST_SUITE_P(Engines, CocoSsd, testing::ValuesIn(engines()));

TEST_P(CocoSsd, GivesTheScoresOfAnotherEngine) {
  cv::Mat pattern(300, 300, CV_8UC3);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 3; ++c)  // red, green, blue
        pattern.at<cv::Vec3b>(y, x)[2 - c] =
            static_cast<unsigned char>((x * (3 + c) + y * (7 - 2 * c) + x * y / 50) % 256);
  ASSERT_EQ(detector_->vocabulary().size(), 80U);
  expectBest(pattern,
             {{"scissors", 0.132692},
              {"book", 0.052545},
              {"bench", 0.050390},
              {"dining table", 0.046319},
              {"knife", 0.043932},
              {"person", 0.026756},
              {"surfboard", 0.022281}},
             1e-4);
}

TEST_P(CocoSsd, TellsWhatIsWhereInAnImage) {
  const auto home = test::findData("home_a");
  ESTANCIA_NEEDS(home, "the data set home_a is missing (ESTANCIA_DATA)");
  const cv::Mat image = cv::imread((*home / "day/rgb/000200.jpg").string());
  ASSERT_EQ(image.size(), cv::Size(320, 240));
  const auto part = [](double x, double y, double right, double bottom) {
    return cv::Rect2d(cv::Point2d(x / 320, y / 240), cv::Point2d(right / 320, bottom / 240));
  };
  // Boxes of the office chair and of the plant in the truth's mask, and of the wall above.
  const auto words =
      detector_->labelRegions(image, std::array{part(43, 77, 156, 240), part(271, 125, 320, 199),
                                                part(200, 10, 300, 70), cv::Rect2d(0, 0, 1, 1)});
  ASSERT_EQ(words.size(), 4U);
  const Vocabulary& labels = detector_->vocabulary();
  EXPECT_EQ(labels[test::best(words[0], 1)[0]], "chair");
  EXPECT_EQ(labels[test::best(words[1], 1)[0]], "potted plant");
  const auto chair = test::best(words[0], 1)[0];
  EXPECT_GT(words[0][chair], 0.5F);
  EXPECT_LT(words[2][chair], 0.1F);
  const auto all = detector_->label(image);
  for (const LexicalDescriptor& region : words)
    for (std::size_t l = 0; l < all.size(); ++l)
      EXPECT_LE(region[l], all[l] + 1e-6F) << "the image's score is the highest of all boxes";
  EXPECT_EQ(detector_->regionLabels().size(), 80U);
  EXPECT_TRUE(detector_->labelRegions(image, {}).empty());
}

}  // namespace
}  // namespace estancia
