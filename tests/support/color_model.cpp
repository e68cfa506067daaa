// SPDX-License-Identifier: Apache-2.0
#include "support/color_model.hpp"

#include <onnx/onnx_pb.h>

#include "support/model_support.hpp"

namespace estancia::test {

void writeColorModel(const std::filesystem::path& folder) {
  const std::string network = smallOnnx(8, 4, [](onnx::GraphProto& graph) {
    // weights of blue, green, red
    const float weights[4][3] = {{-1, 0, 1}, {1, 0, -1}, {0, -1, 0}, {0, -1, 0}};
    for (int i = 0; i < 12; ++i) graph.mutable_initializer(0)->set_float_data(i, weights[i / 3][i % 3]);
  });
  writeFile(folder / "small.onnx", network);
  writeFile(folder / "labels.txt", labelLines(4));
  writeFile(folder / "model.toml", modelToml("small.onnx", 8, "scale = [0.02, 0.02, 0.02]"));
}

}  // namespace estancia::test
