// Real networks on real photographs.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "estancia/label/engines.hpp"
#include "estancia/label/model.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

struct ConvertedNetwork {
  const char* name;
  int side;
};
void PrintTo(const ConvertedNetwork& network, std::ostream* out) {
  *out << network.name;
}

class TfliteNetwork : public testing::TestWithParam<ConvertedNetwork> {};

INSTANTIATE_TEST_SUITE_P(All, TfliteNetwork,
                         testing::Values(ConvertedNetwork{"mobilenet_v1_0.25_128_quant", 128},
                                         ConvertedNetwork{"tf2_mobilenet_v2_1.0_224_ptq", 224}),
                         [](const auto& param) {
                           std::string name = param.param.name;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST_P(TfliteNetwork, LabelsLikeItsOnnxTwin) {
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");
  const auto& network = GetParam();
  const std::string name = network.name;
  const test::ScratchFolder scratch;
  const auto input = test::mobilenetInput(network.side);
  const auto ours =
      openWithOpencv(test::testModel(*models, name + ".tflite", "imagenet_1001.txt", input, scratch));
  ASSERT_EQ(ours->vocabulary().size(), 1001U);
  const auto twin =
      openWithOpencv(test::testModel(*models, name + ".onnx", "imagenet_1001.txt", input, scratch));
  for (const auto& image : test::photographs(*photos, 6)) {
    const auto a = ours->label(image), b = twin->label(image);
    float difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) difference = std::max(difference, std::abs(a[i] - b[i]));
    EXPECT_EQ(test::best(a, 1), test::best(b, 1));
    EXPECT_LT(difference, 2e-4);
  }
}

TEST(DefaultNetwork, AgreesWithAnotherNetworkOnRooms) {
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const auto photos = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(photos, "the data set nyuv2_half is missing (ESTANCIA_DATA)");

  const test::ScratchFolder scratch;
  const auto inception = loadModel(folder->string());
  const auto mobilenet = openWithOpencv(test::testModel(
      *models, "mobilenet_v2_1.0_224_quant.tflite", "imagenet_1001.txt", test::mobilenetInput(224), scratch));
  ASSERT_EQ(inception->vocabulary().size(), 1001U);
  // Both lists count background and the 1,000 classes of ImageNet in the same order.
  std::size_t agreed = 0;
  const auto images = test::photographs(*photos, 8);
  for (const auto& image : images) {
    const auto first = test::best(inception->label(image), 1)[0];
    const auto others = test::best(mobilenet->label(image), 5);
    agreed += static_cast<std::size_t>(std::count(others.begin(), others.end(), first));
  }
  EXPECT_GE(agreed, images.size() / 2) << "by chance it would be 0 of " << images.size();
}

}  // namespace
}  // namespace estancia
