// Each operator against a plain implementation of its definition in TensorFlow Lite.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <limits>
#include <opencv2/dnn.hpp>
#include <ostream>
#include <random>

#include "convert/tflite_builder.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"

namespace estancia {
namespace {

using test::format::Activation;
using test::format::ElementType;
using test::format::Padding;
using Values = std::vector<float>;

/// An image H×W×C in the order of the file.
struct Image {
  int height, width, channels;
  Values values;
  float at(int y, int x, int c) const {
    return values[static_cast<std::size_t>((y * width + x) * channels + c)];
  }
};

Values randomTensor(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Values values(count);
  for (float& v : values) v = uniform(random);
  return values;
}

Image randomImage(int height, int width, int channels) {
  return {height, width, channels, randomTensor(static_cast<std::size_t>(height * width * channels), 7)};
}

/// What the network in `file` answers, in its own (N×C×H×W) order.
cv::Mat answer(const std::string& file, const Image& input) {
  const auto graph =
      tflite::readGraph({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, "test.tflite");
  const std::string bytes = tflite::toOnnx(graph, "test.tflite");
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  EXPECT_NO_THROW(onnx::checker::check_model(model));

  cv::Mat blob({1, input.channels, input.height, input.width}, CV_32F);
  for (int c = 0; c < input.channels; ++c)
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; ++x) *(blob.ptr<float>(0, c, y) + x) = input.at(y, x, c);
  auto network = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  network.setInput(blob);
  return network.forward().clone();
}

/// Compares an image N×C×H×W with one in the order of the file.
void expectImage(const cv::Mat& actual, const Image& expected) {
  ASSERT_EQ(actual.dims, 4);
  ASSERT_EQ(actual.size[1], expected.channels);
  ASSERT_EQ(actual.size[2], expected.height);
  ASSERT_EQ(actual.size[3], expected.width);
  for (int c = 0; c < expected.channels; ++c)
    for (int y = 0; y < expected.height; ++y)
      for (int x = 0; x < expected.width; ++x)
        ASSERT_NEAR(*(actual.ptr<float>(0, c, y) + x), expected.at(y, x, c), 1e-4)
            << c << ' ' << y << ' ' << x;
}

void expectValues(const cv::Mat& actual, const Values& expected) {
  ASSERT_EQ(actual.total(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(actual.ptr<float>()[i], expected[i], 1e-5) << i;
}

struct Window {
  int height, width, filterY, filterX, strideY, strideX;
  Padding padding;
  int dilation = 1;

  int span(int filter) const { return (filter - 1) * dilation + 1; }
  int outputs(int size, int filter, int stride) const {
    return padding == Padding::SAME ? (size + stride - 1) / stride : (size - span(filter)) / stride + 1;
  }
  int outputsY() const { return outputs(height, filterY, strideY); }
  int outputsX() const { return outputs(width, filterX, strideX); }
  std::vector<int> shape(int channels) const { return {1, outputsY(), outputsX(), channels}; }
  /// The first row (or column) of the window at position 0: TFLite pads the smaller half in front.
  int start(int size, int filter, int stride) const {
    return -std::max((outputs(size, filter, stride) - 1) * stride + span(filter) - size, 0) / 2;
  }

  /// Calls use(ky, kx, y, x) for each pixel of the image under the window at (row, column).
  template <class Use>
  void forEachPixel(int row, int column, Use use) const {
    for (int ky = 0; ky < filterY; ++ky)
      for (int kx = 0; kx < filterX; ++kx) {
        const int y = row * strideY + start(height, filterY, strideY) + ky * dilation;
        const int x = column * strideX + start(width, filterX, strideX) + kx * dilation;
        if (y >= 0 && y < height && x >= 0 && x < width) use(ky, kx, y, x);
      }
  }

  /// An image of `channels` with value(row, column, channel).
  template <class Value>
  Image image(int channels, Value value) const {
    Image result{outputsY(), outputsX(), channels, {}};
    for (int row = 0; row < outputsY(); ++row)
      for (int column = 0; column < outputsX(); ++column)
        for (int c = 0; c < channels; ++c) result.values.push_back(value(row, column, c));
    return result;
  }
};

void PrintTo(const Window& w, std::ostream* out) {
  *out << w.filterX << 'x' << w.filterY << (w.padding == Padding::SAME ? " SAME" : " VALID") << " on "
       << w.width << 'x' << w.height << " by " << w.strideX << 'x' << w.strideY << " dilated " << w.dilation;
}

class Windows : public testing::TestWithParam<Window> {};

INSTANTIATE_TEST_SUITE_P(
    Cases, Windows,
    testing::Values(Window{6, 6, 3, 3, 2, 2, Padding::SAME},  // even size, stride 2: all padding behind
                    Window{7, 7, 3, 3, 2, 2, Padding::SAME},  // odd size: padding on both sides
                    Window{8, 6, 2, 2, 2, 2, Padding::SAME},  // none at all
                    Window{7, 5, 2, 2, 1, 1, Padding::SAME},  // an even filter: one pixel behind
                    Window{9, 8, 5, 3, 3, 2, Padding::SAME},  // other along each side
                    Window{6, 9, 1, 7, 1, 1, Padding::SAME},  // a flat filter, as in Inception
                    Window{6, 6, 1, 1, 2, 2, Padding::SAME},  // stride larger than the filter
                    Window{7, 8, 3, 3, 2, 2, Padding::VALID}, Window{5, 5, 5, 5, 1, 1, Padding::VALID},
                    Window{9, 9, 3, 3, 1, 1, Padding::SAME, 2}, Window{9, 8, 3, 2, 1, 1, Padding::VALID, 3}));

TEST_P(Windows, ConvolveLikeTheDefinition) {
  const Window w = GetParam();
  const Image input = randomImage(w.height, w.width, 3);
  constexpr int filters = 5;
  const Values weights = randomTensor(static_cast<std::size_t>(filters * w.filterY * w.filterX * 3), 1);
  const Values bias = randomTensor(filters, 2);

  test::TfliteBuilder network;
  const int in = network.tensor({1, w.height, w.width, 3});
  const int stored = network.constant({filters, w.filterY, w.filterX, 3}, weights);
  const int offset = network.constant({filters}, bias);
  const int out = network.tensor(w.shape(filters));
  network.conv(in, stored, offset, out, w.padding, w.strideX, w.strideY, w.dilation);

  expectImage(answer(network.file(in, out), input), w.image(filters, [&](int row, int column, int filter) {
    float sum = bias[static_cast<std::size_t>(filter)];
    w.forEachPixel(row, column, [&](int ky, int kx, int y, int x) {
      for (int c = 0; c < 3; ++c)
        sum += input.at(y, x, c) *
               weights[static_cast<std::size_t>(((filter * w.filterY + ky) * w.filterX + kx) * 3 + c)];
    });
    return sum;
  }));
}

TEST_P(Windows, ConvolveEachChannelAloneLikeTheDefinition) {
  const Window w = GetParam();
  const Image input = randomImage(w.height, w.width, 3);
  constexpr int filters = 6;  // two a channel
  const Values weights = randomTensor(static_cast<std::size_t>(w.filterY * w.filterX * filters), 1);

  test::TfliteBuilder network;
  const int in = network.tensor({1, w.height, w.width, 3});
  const int stored = network.constant({1, w.filterY, w.filterX, filters}, weights);
  const int out = network.tensor(w.shape(filters));
  network.depthwise(in, stored, out, w.padding, w.strideX, w.strideY, w.dilation);

  expectImage(answer(network.file(in, out), input), w.image(filters, [&](int row, int column, int filter) {
    float sum = 0;
    w.forEachPixel(row, column, [&](int ky, int kx, int y, int x) {
      sum += input.at(y, x, filter / 2) *
             weights[static_cast<std::size_t>((ky * w.filterX + kx) * filters + filter)];
    });
    return sum;
  }));
}

TEST_P(Windows, PoolWithoutCountingThePadding) {
  Window w = GetParam();
  w.dilation = 1;  // pools have none
  const Image input = randomImage(w.height, w.width, 4);
  for (const bool average : {true, false}) {
    test::TfliteBuilder network;
    const int in = network.tensor({1, w.height, w.width, 4});
    const int out = network.tensor(w.shape(4));
    network.pool(average, in, out, w.padding, w.strideX, w.strideY, w.filterX, w.filterY);

    expectImage(answer(network.file(in, out), input), w.image(4, [&](int row, int column, int c) {
      float sum = 0, largest = std::numeric_limits<float>::lowest();
      int count = 0;
      w.forEachPixel(row, column, [&](int, int, int y, int x) {
        sum += input.at(y, x, c);
        largest = std::max(largest, input.at(y, x, c));
        ++count;
      });
      return average ? sum / static_cast<float>(count) : largest;
    }));
  }
}

/// A 1×1 convolution that copies three channels, into an 8-bit output of this scale and zero point.
Values copiedThroughRange(const Values& pixels, ElementType type, float scale, std::int64_t zeroPoint) {
  test::TfliteBuilder network;
  const auto count = static_cast<int>(pixels.size()) / 3;
  const int in = network.tensor({1, 1, count, 3});
  const int identity = network.constant({3, 1, 1, 3}, Values{1, 0, 0, 0, 1, 0, 0, 0, 1});
  const int bias = network.constant({3}, Values{0, 0, 0});
  const int out = network.tensor({1, 1, count, 3}, type, scale, zeroPoint);
  const int row = network.tensor({1, 3 * count}, type, scale, zeroPoint);
  network.conv(in, identity, bias, out, Padding::VALID, 1, 1);
  network.plain(22, {out}, row);
  const cv::Mat result = answer(network.file(in, row), {1, count, 3, pixels});
  return {result.ptr<float>(), result.ptr<float>() + result.total()};
}

TEST(EightBitOutput, ImpliesTheActivationThatTheFileLeavesOut) {
  const Values pixels{-2, -0.5F, 0.25F, 3, 6.5F, 9};
  EXPECT_EQ(copiedThroughRange(pixels, ElementType::UINT8, 0.05F, 0), (Values{0, 0, 0.25F, 3, 6.5F, 9}))
      << "ReLU";
  EXPECT_EQ(copiedThroughRange(pixels, ElementType::INT8, 0.05F, -128), (Values{0, 0, 0.25F, 3, 6.5F, 9}))
      << "ReLU";
  EXPECT_EQ(copiedThroughRange(pixels, ElementType::UINT8, 6 / 255.F, 0), (Values{0, 0, 0.25F, 3, 6, 6}))
      << "ReLU6";
  EXPECT_EQ(copiedThroughRange(pixels, ElementType::UINT8, 0.1F, 100), pixels) << "none";
  EXPECT_EQ(copiedThroughRange(pixels, ElementType::FLOAT32, 0, 0), pixels) << "none";
}

TEST(Weights, AreDequantizedByChannel) {
  // one pixel, two filters with scales of their own; the bias counts in input scale × filter scale
  test::TfliteBuilder network;
  const int in = network.tensor({1, 1, 1, 3});
  const int weights = network.constant<std::int8_t>({2, 1, 1, 3}, ElementType::INT8, {1, 2, 3, 10, 20, -30},
                                                    {0.5F, 0.1F}, {0, 0}, 0);
  const int bias =
      network.constant<std::int32_t>({2}, ElementType::INT32, {100, 100}, {0.01F, 0.002F}, {0, 0}, 0);
  const int out = network.tensor({1, 1, 1, 2});
  network.conv(in, weights, bias, out, Padding::VALID, 1, 1);
  expectValues(answer(network.file(in, out), {1, 1, 3, {1, 1, 2}}),
               {0.5F * (1 + 2 + 6) + 1.0F, 0.1F * (10 + 20 - 60) + 0.2F});
}

TEST(FullyConnected, MultipliesTheFilesOrderOfElements) {
  const Image input = randomImage(2, 2, 3);
  const Values weights = randomTensor(24, 3);
  test::TfliteBuilder network;
  const int in = network.tensor({1, 2, 2, 3});
  const int stored = network.constant({2, 12}, weights);
  const int bias = network.constant({2}, Values{1, -1});
  const int out = network.tensor({1, 2});
  network.fullyConnected(in, stored, bias, out);
  Values expected{1, -1};
  for (std::size_t i = 0; i < 24; ++i) expected[i / 12] += weights[i] * input.values[i % 12];
  expectValues(answer(network.file(in, out), input), expected);
}

TEST(Branches, AreAddedAndJoinedAlongChannels) {
  const Image input = randomImage(2, 3, 3);
  for (const int axis : {3, -1}) {
    test::TfliteBuilder network;
    const int in = network.tensor({1, 2, 3, 3});
    const int sum = network.tensor({1, 2, 3, 3});
    const int joined = network.tensor({1, 2, 3, 6});
    network.add(in, in, sum, Activation::RELU);
    network.concatenation({sum, in}, joined, axis);
    Image expected{2, 3, 6, {}};
    for (int pixel = 0; pixel < 6; ++pixel)
      for (int c = 0; c < 6; ++c) {
        const float value = input.values[static_cast<std::size_t>(pixel * 3 + c % 3)];
        expected.values.push_back(c < 3 ? std::max(0.0F, 2 * value) : value);
      }
    expectImage(answer(network.file(in, joined), input), expected);
  }
}

}  // namespace
}  // namespace estancia
