// TensorFlow Lite: each operator against its definition, and files that cannot be read.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <ostream>
#include <vector>

#include "convert/network_builders.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "estancia/core/error.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::randomValues;
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

Image randomImage(int height, int width, int channels) {
  return {height, width, channels, randomValues(height * width * channels, 7)};
}

/// What the network in `file` answers, in its own (N×C×H×W) order.
cv::Mat answer(const std::string& file, const Image& input) {
  const auto graph =
      tflite::readGraph({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, "test.tflite");
  return test::answerOf(tflite::toOnnx(graph, "test.tflite"), input.values, input.height, input.width,
                        input.channels);
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
  const Values weights = randomValues(filters * w.filterY * w.filterX * 3, 1);
  const Values bias = randomValues(filters, 2);

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
  const Values weights = randomValues(w.filterY * w.filterX * filters, 1);

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
  const Values weights = randomValues(24, 3);
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
    network.add(in, in, sum, test::format::Activation::RELU);
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

std::span<const std::uint8_t> bytesOf(const std::string& file) {
  return {reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
}

void convert(const std::string& file) {
  tflite::toOnnx(tflite::readGraph(bytesOf(file), "net.tflite"), "net.tflite");
}

/// A good network: convolution, pool, flattening, softmax.
std::string goodFile() {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3});
  const int weights = network.constant({4, 3, 3, 3}, std::vector<float>(108, 0.1F));
  const int bias = network.constant({4}, std::vector<float>(4, 0.0F));
  const int filtered = network.tensor({1, 4, 4, 4});
  const int pooled = network.tensor({1, 1, 1, 4});
  const int row = network.tensor({1, 4});
  const int out = network.tensor({1, 4});
  network.conv(in, weights, bias, filtered, Padding::SAME, 2, 2);
  network.pool(true, filtered, pooled, Padding::VALID, 1, 1, 4, 4);
  network.plain(22, {pooled}, row);
  network.softmax(row, out);
  return network.file(in, out);
}

TEST(TfliteReader, RefusesWhatItCannotRead) {
  const std::vector<int> image{1, 8, 8, 3};
  // `build` returns the output of what it adds behind the input.
  const auto refusal = [&](const std::function<int(test::TfliteBuilder&, int in)>& build) {
    test::TfliteBuilder network;
    const int in = network.tensor(image), out = build(network, in);
    return test::caught([&] { convert(network.file(in, out)); });
  };
  const auto unknown = refusal([&](auto& n, int in) {
    const int out = n.tensor(image);
    n.plain(117, {in}, out);
    return out;
  });
  EXPECT_THAT(unknown, FailsWith(ErrorCode::unsupportedFile)) << "an operator that is not known";
  const auto convolving = [&](const std::vector<int>& shape, std::size_t count) {
    return refusal([&](auto& n, int in) {
      const int weights = n.constant(shape, std::vector<float>(count));
      const int bias = n.constant({4}, std::vector<float>(4)), out = n.tensor({1, 8, 8, 4});
      n.conv(in, weights, bias, out, Padding::SAME, 1, 1);
      return out;
    });
  };
  EXPECT_FALSE(convolving({4, 3, 3, 3}, 108).code);
  EXPECT_THAT(convolving({4, 3, 3, 3}, 107), FailsWith(ErrorCode::malformedFile)) << "too few weights";
  EXPECT_THAT(convolving({4, 3, 3, 2}, 72), FailsWith(ErrorCode::malformedFile)) << "for other channels";
  const auto pooling = [&](const std::vector<int>& shape, Padding padding, int strideX) {
    return refusal([&](auto& n, int in) {
      const int out = n.tensor(shape);
      n.pool(true, in, out, padding, strideX, 2, 2, 2);
      return out;
    });
  };
  EXPECT_THAT(pooling({1, 5, 4, 3}, Padding::VALID, 2), FailsWith(ErrorCode::malformedFile))
      << "another shape";
  for (const int stride : {0, -1, 1 << 20})
    EXPECT_THAT(pooling({1, 4, 4, 3}, Padding::SAME, stride), FailsWith(ErrorCode::malformedFile)) << stride;
  // A tensor is left out, or behind the last; there is a loop; nothing writes the output.
  for (const auto& [a, b, out] : {std::array{0, -1, 1}, {0, 1 << 30, 1}, {0, 2, 1}, {0, 0, 2}})
    EXPECT_THAT(refusal([&, first = a, second = b, last = out](auto& n, int) {
                  const int sum = n.tensor(image), other = n.tensor(image);
                  n.add(first, second, sum);
                  if (second == other) n.add(sum, sum, other);
                  return last;
                }),
                FailsWith(ErrorCode::malformedFile))
        << b;
  for (const auto& shape :
       {std::vector<int>{1, -8, 8, 3}, {1, 0, 8, 3}, {1, 65536, 65536, 3}, {1 << 30, 1 << 30, 4, 4}}) {
    test::TfliteBuilder network;
    const int in = network.tensor(shape), out = network.tensor(shape);
    network.plain(114, {in}, out);
    EXPECT_THAT([&] { convert(network.file(in, out)); }, FailsWith(ErrorCode::malformedFile)) << shape[0];
  }
}

TEST(TfliteReader, RefusesOtherFiles) {
  for (const std::string file :
       {"", "TFL3", "a text that is long enough to be looked at", "\x20\0\0\0TFL3\0\0\0\0"})
    EXPECT_THROW(convert(file), Error);
}

TEST(TfliteReader, RefusesAFileThatIsCutAnywhere) {
  const std::string file = goodFile();
  EXPECT_NO_THROW(convert(file));
  for (std::size_t size = 0; size < file.size(); size += 1 + size / 64) {
    SCOPED_TRACE(size);
    test::caught([&] { convert(file.substr(0, size)); });
  }
}

}  // namespace
}  // namespace estancia
