// Files that are no networks, or not those that can be read: always an Error, never a crash.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "convert/tflite_builder.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "estancia/core/error.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
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

TEST(TfliteReader, RefusesWhatItCannotRead) {
  using Write = std::function<int(test::TfliteBuilder&, int in)>;  // returns the output
  const auto image = [](test::TfliteBuilder& n) { return n.tensor({1, 8, 8, 3}); };
  const auto convolving = [](const std::vector<int>& shape, std::size_t count) -> Write {
    return [=](test::TfliteBuilder& n, int in) {
      const int weights = n.constant(shape, std::vector<float>(count));
      const int bias = n.constant({4}, std::vector<float>(4)), out = n.tensor({1, 8, 8, 4});
      n.conv(in, weights, bias, out, Padding::SAME, 1, 1);
      return out;
    };
  };
  const auto pooling = [](const std::vector<int>& shape, Padding padding, int strideX, int strideY) -> Write {
    return [=](test::TfliteBuilder& n, int in) {
      const int out = n.tensor(shape);
      n.pool(true, in, out, padding, strideX, strideY, 2, 2);
      return out;
    };
  };
  const auto adding = [&](int other) -> Write {
    return [=](test::TfliteBuilder& n, int in) {
      const int out = image(n);
      n.add(in, other, out);
      return out;
    };
  };
  struct Case {
    const char* what;
    Write write;
    ErrorCode code = ErrorCode::malformedFile;
  };
  const std::vector<Case> cases{
      {"an operator",
       [&](auto& n, int in) {
         const int out = image(n);
         n.plain(117, {in}, out);
         return out;
       },
       ErrorCode::unsupportedFile},
      {"weights of another size than their shape", convolving({4, 3, 3, 3}, 107)},
      {"weights for other channels", convolving({4, 3, 3, 2}, 72)},
      {"a shape that the operator does not compute", pooling({1, 5, 4, 3}, Padding::VALID, 2, 2)},
      {"a stride of zero", pooling({1, 4, 4, 3}, Padding::SAME, 0, 2)},
      {"a negative stride", pooling({1, 4, 4, 3}, Padding::SAME, -1, 2)},
      {"a huge stride", pooling({1, 4, 4, 3}, Padding::SAME, 1 << 20, 2)},
      {"a tensor that is left out", adding(-1)},
      {"a tensor behind the last", adding(1 << 30)},
      {"a loop",
       [&](auto& n, int in) {
         const int a = image(n), b = image(n);
         n.add(in, b, a);
         n.add(a, a, b);
         return b;
       }},
      {"an output that nobody writes", [&](auto& n, int in) {
         const int a = image(n), b = image(n);
         n.add(in, in, a);
         return b;
       }}};
  for (const Case& c : cases) {
    test::TfliteBuilder network;
    const int in = image(network), out = c.write(network, in);
    EXPECT_THAT([&] { convert(network.file(in, out)); }, FailsWith(c.code)) << c.what;
  }
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
