// Files that are no networks, or not those that can be read: always an Error, never a crash.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "convert/tflite_builder.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::format::ElementType;
using test::format::Padding;

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

TEST(TfliteReader, NamesAnOperatorThatItCannotRead) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 8, 8, 3});
  network.plain(117, {in}, out);
  EXPECT_THAT([&] { convert(network.file(in, out)); },
              FailsWith(ErrorCode::unsupportedFile, "net.tflite", "HARD_SWISH"));
}

TEST(TfliteReader, NamesACustomOperator) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 8, 8, 3});
  network.custom("TFLite_Detection_PostProcess", in, out);
  EXPECT_THAT([&] { convert(network.file(in, out)); },
              FailsWith(ErrorCode::unsupportedFile, "TFLite_Detection_PostProcess"));
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

TEST(TfliteReader, ReadsZeroPointsAtAnyAddress) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}, ElementType::UINT8, 0.5F, 3);
  const int out = network.tensor({1, 8, 8, 3}, ElementType::UINT8, 0.5F, 3);
  network.pool(true, in, out, Padding::VALID, 1, 1, 1, 1);
  const std::string file = network.file(in, out);
  std::vector<std::uint64_t> aligned(file.size() / 8 + 2);
  auto* shifted = reinterpret_cast<std::uint8_t*>(aligned.data()) + 4;
  std::memcpy(shifted, file.data(), file.size());
  const tflite::Graph graph = tflite::readGraph({shifted, file.size()}, "net.tflite");
  EXPECT_THAT(graph.tensors.front().zeroPoint, testing::ElementsAre(3)) << "a sanitizer watches";
}

TEST(TfliteReader, SurvivesAnyByteThatChanges) {
  const std::string good = goodFile();
  std::mt19937 random(5);
  for (std::size_t i = 0; i < good.size(); ++i)
    for (const int bit : {0, 7, static_cast<int>(random() % 8)}) {
      std::string file = good;
      file[i] = static_cast<char>(file[i] ^ (1 << bit));
      try {
        convert(file);  // a change of a weight or a name does no harm
      } catch (const Error&) {
      }
    }
}

TEST(TfliteReader, SurvivesChangesOfARealNetwork) {
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const std::string good = test::readFile(*models / "mobilenet_v1_0.25_128_quant.tflite");
  // Only the bytes around the weights matter: those outside of all constants. Behind the last constant comes
  // a list of labels in a format of its own, without which the network is still whole.
  std::vector<bool> isWeight(good.size());
  std::ptrdiff_t end = 0;
  for (const auto& tensor : tflite::readGraph(bytesOf(good), "net").tensors)
    if (tensor.constant) {
      const auto start = reinterpret_cast<const char*>(tensor.bytes.data()) - good.data();
      end = std::max(end, start + static_cast<std::ptrdiff_t>(tensor.bytes.size()));
      if (tensor.bytes.size() > 64) std::fill_n(isWeight.begin() + start, tensor.bytes.size(), true);
    }
  for (std::size_t size = 0; size < static_cast<std::size_t>(end); size += 9973) {
    SCOPED_TRACE(size);
    test::caught([&] { convert(good.substr(0, size)); });
  }
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < good.size(); ++i)
    if (!isWeight[i]) positions.push_back(i);
  std::mt19937 random(11);
  std::size_t refused = 0;
  for (int round = 0; round < 400; ++round) {
    std::string file = good;
    for (int k = 0; k < 1 + round % 3; ++k)
      file[positions[random() % positions.size()]] = static_cast<char>(random());
    try {
      convert(file);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100U);
}

TEST(TfliteReader, RefusesImpossibleShapes) {
  for (const auto& shape :
       {std::vector<int>{1, -8, 8, 3}, {1, 0, 8, 3}, {1, 65536, 65536, 3}, {1 << 30, 1 << 30, 4, 4}}) {
    test::TfliteBuilder network;
    const int in = network.tensor(shape), out = network.tensor(shape);
    network.plain(114, {in}, out);
    EXPECT_THAT(
        [&] { convert(network.file(in, out)); },
        FailsWith(ErrorCode::malformedFile, "\"tensor 0\"", fmt::format("[{}]", fmt::join(shape, "×"))));
  }
}

TEST(TfliteReader, RefusesAShapeThatIsNotWhatTheOperatorComputes) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 5, 4, 3});
  network.pool(true, in, out, Padding::VALID, 2, 2, 2, 2);
  EXPECT_THAT([&] { convert(network.file(in, out)); },
              FailsWith(ErrorCode::malformedFile, "AVERAGE_POOL_2D (operator 0)", "1×3×4×4"));
}

TEST(TfliteReader, RefusesWeightsOfAnotherSizeThanTheirShape) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3});
  const int weights = network.constant({4, 3, 3, 3}, std::vector<float>(107));
  const int bias = network.constant({4}, std::vector<float>(4)), out = network.tensor({1, 8, 8, 4});
  network.conv(in, weights, bias, out, Padding::SAME, 1, 1);
  EXPECT_THAT([&] { convert(network.file(in, out)); }, FailsWith(ErrorCode::malformedFile, "428", "432"));
}

TEST(TfliteReader, RefusesWeightsForOtherChannels) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3});
  const int weights = network.constant({4, 3, 3, 2}, std::vector<float>(72));
  const int bias = network.constant({4}, std::vector<float>(4)), out = network.tensor({1, 8, 8, 4});
  network.conv(in, weights, bias, out, Padding::SAME, 1, 1);
  EXPECT_THAT([&] { convert(network.file(in, out)); },
              FailsWith(ErrorCode::malformedFile, "[4×3×3×2]", "3", "CONV_2D (operator 0)"));
}

TEST(TfliteReader, RefusesStridesAndIndicesOutOfRange) {
  for (const int stride : {0, -1, 1 << 20}) {
    test::TfliteBuilder network;
    const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 4, 4, 3});
    network.pool(false, in, out, Padding::SAME, stride, 2, 2, 2);
    EXPECT_THAT([&] { convert(network.file(in, out)); },
                FailsWith(ErrorCode::malformedFile, std::to_string(stride), "MAX_POOL_2D (operator 0)"));
  }
  for (const int wrong : {-2, 2, 1 << 30}) {
    test::TfliteBuilder network;
    const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 8, 8, 3});
    network.add(in, wrong, out);
    EXPECT_THAT([&] { convert(network.file(in, out)); },
                FailsWith(ErrorCode::malformedFile, std::to_string(wrong), "ADD (operator 0)"));
  }
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), out = network.tensor({1, 8, 8, 3});
  network.add(in, -1, out);
  EXPECT_THAT([&] { convert(network.file(in, out)); },
              FailsWith(ErrorCode::malformedFile, "ADD (operator 0)"));
}

TEST(TfliteReader, RefusesALoopInTheGraph) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), a = network.tensor({1, 8, 8, 3}),
            b = network.tensor({1, 8, 8, 3});
  network.add(in, b, a);
  network.add(a, a, b);
  EXPECT_THAT([&] { convert(network.file(in, b)); },
              FailsWith(ErrorCode::malformedFile, "ADD (operator 0)", "tensor 2"));
}

TEST(TfliteReader, RefusesAnOutputThatNobodyWrites) {
  test::TfliteBuilder network;
  const int in = network.tensor({1, 8, 8, 3}), a = network.tensor({1, 8, 8, 3}),
            b = network.tensor({1, 8, 8, 3});
  network.add(in, in, a);
  EXPECT_THAT([&] { convert(network.file(in, b)); },
              FailsWith(ErrorCode::malformedFile, "net.tflite", "tensor 2"));
}

}  // namespace
}  // namespace estancia
