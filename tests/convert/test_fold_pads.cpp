// SPDX-License-Identifier: Apache-2.0
#include "convert/fold_pads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace estancia::convert {
namespace {

using testing::ElementsAre;

onnx::NodeProto& addNode(onnx::GraphProto& graph, const std::string& type,
                         const std::vector<std::string>& inputs, const std::string& output) {
  onnx::NodeProto& node = *graph.add_node();
  node.set_op_type(type);
  for (const auto& input : inputs) node.add_input(input);
  node.add_output(output);
  return node;
}

void addWidths(onnx::GraphProto& graph, const std::vector<std::int64_t>& widths) {
  onnx::TensorProto& tensor = *graph.add_initializer();
  tensor.set_name("widths");
  tensor.set_data_type(onnx::TensorProto::INT64);
  tensor.add_dims(static_cast<std::int64_t>(widths.size()));
  for (const auto width : widths) tensor.add_int64_data(width);
}

void addValue(onnx::GraphProto& graph, float value) {
  onnx::TensorProto& tensor = *graph.add_initializer();
  tensor.set_name("value");
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  tensor.add_float_data(value);
}

onnx::AttributeProto& addPads(onnx::NodeProto& node, const std::vector<std::int64_t>& pads) {
  onnx::AttributeProto& attribute = *node.add_attribute();
  attribute.set_name("pads");
  attribute.set_type(onnx::AttributeProto::INTS);
  for (const auto pad : pads) attribute.add_ints(pad);
  return attribute;
}

/// image → Pad → two convolutions, of which the second pads by itself, too.
onnx::GraphProto padded(const std::vector<std::int64_t>& widths = {0, 0, 1, 2, 0, 0, 3, 4}, float value = 0) {
  onnx::GraphProto graph;
  addWidths(graph, widths);
  addValue(graph, value);
  addNode(graph, "Pad", {"image", "widths", "value"}, "wide");
  addNode(graph, "Conv", {"wide", "w1"}, "a");
  addPads(addNode(graph, "Conv", {"wide", "w2"}, "b"), {5, 6, 7, 8});
  graph.add_output()->set_name("a");
  graph.add_output()->set_name("b");
  return graph;
}

bool isFolded(onnx::GraphProto graph) {
  const int before = graph.node_size();
  foldPads(graph);
  return graph.node_size() < before;
}

TEST(FoldPads, AddsTheWidthsToTheConvolutions) {
  onnx::GraphProto graph = padded();
  foldPads(graph);
  ASSERT_EQ(graph.node_size(), 2);
  for (const auto& node : graph.node()) EXPECT_EQ(node.input(0), "image");
  EXPECT_THAT(graph.node(0).attribute(0).ints(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(graph.node(1).attribute(0).ints(), ElementsAre(6, 8, 10, 12));
}

TEST(FoldPads, LeavesWhatIsNoMarginOfZeros) {
  EXPECT_TRUE(isFolded(padded()));
  EXPECT_FALSE(isFolded(padded({0, 0, 1, 2, 0, 0, 3, 4}, 0.5F)));
  EXPECT_FALSE(isFolded(padded({0, 1, 1, 2, 0, 0, 3, 4})));   // channels
  EXPECT_FALSE(isFolded(padded({0, 0, -1, 2, 0, 0, 3, 4})));  // cuts
  EXPECT_FALSE(isFolded(padded({1, 2, 3, 4})));               // no images
  onnx::GraphProto reflecting = padded();
  onnx::AttributeProto& mode = *reflecting.mutable_node(0)->add_attribute();
  mode.set_name("mode");
  mode.set_type(onnx::AttributeProto::STRING);
  mode.set_s("reflect");
  EXPECT_FALSE(isFolded(reflecting));
  onnx::GraphProto computed = padded();
  computed.mutable_node(0)->set_input(1, "elsewhere");
  EXPECT_FALSE(isFolded(computed));
}

}  // namespace
}  // namespace estancia::convert
