// SPDX-License-Identifier: Apache-2.0
#include "convert/activation_ranges.hpp"
#include "convert/tfjs_reader.hpp"
#include "convert/tflite_reader.hpp"
#include "convert/tflite_to_onnx.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(convert, tflite) {
  const std::vector<std::uint8_t> file(bytes.begin(), bytes.end());
  tflite::toOnnx(tflite::readGraph(file, "input.tflite"), "input.tflite");
}

/// model.json and one shard of weights.
FUZZ_TARGET(convert, tfjs) {
  const auto files = parts(bytes, 2);
  inputFile("group1-shard1of1.bin", files[1]);
  const tfjs::Network network =
      tfjs::readGraph(inputFile("model.json", files[0]), {.input = "", .output = ""});
  tflite::toOnnx(network.graph, "model.json");
}

FUZZ_TARGET(convert, activation_ranges) {
  convert::readRanges(inputFile("input.ranges", bytes));
}

}  // namespace estancia::fuzz
