// Real networks give the same words with either engine, whatever the threads and batches.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

}  // namespace
}  // namespace estancia
