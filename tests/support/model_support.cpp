// SPDX-License-Identifier: Apache-2.0
#include "support/model_support.hpp"

#include <fmt/format.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "estancia/labelers/engines.hpp"

namespace estancia::test {
namespace fs = std::filesystem;
namespace {

void setShape(onnx::ValueInfoProto* value, const std::string& name, const std::vector<int>& shape) {
  value->set_name(name);
  auto* type = value->mutable_type()->mutable_tensor_type();
  type->set_elem_type(onnx::TensorProto::FLOAT);
  for (const int size : shape) type->mutable_shape()->add_dim()->set_dim_value(size);
}

onnx::NodeProto* addNode(onnx::GraphProto& graph, const char* type, const std::vector<std::string>& inputs,
                         const std::string& output) {
  auto* node = graph.add_node();
  node->set_op_type(type);
  node->set_name(output);
  for (const auto& input : inputs) node->add_input(input);
  node->add_output(output);
  return node;
}

}  // namespace

bool findOnnxruntime() {
  if (!onnxruntime::library().problem.empty() && std::getenv("CI") != nullptr)
    ADD_FAILURE() << onnxruntime::library().problem;
  return onnxruntime::library().api != nullptr;
}

std::string labelLines(std::size_t count) {
  std::string lines;
  for (std::size_t i = 0; i < count; ++i) lines += fmt::format("word {}\n", i);
  return lines;
}

std::string modelToml(const std::string& file, int input, const std::string& more) {
  return fmt::format(
      "name = \"small\"\nfile = \"{}\"\nlabels = \"labels.txt\"\ninput = {}\ncolor = \"BGR\"\n{}\n", file,
      input, more);
}

std::string smallOnnx(int side, int outputs, const std::function<void(onnx::GraphProto&)>& change) {
  onnx::ModelProto model;
  model.set_ir_version(5);
  model.add_opset_import()->set_version(10);
  auto& graph = *model.mutable_graph();
  graph.set_name("small");
  setShape(graph.add_input(), "input", {1, 3, side, side});
  addNode(graph, "GlobalAveragePool", {"input"}, "mean");
  auto* weights = graph.add_initializer();
  weights->set_name("weights");
  weights->set_data_type(onnx::TensorProto::FLOAT);
  for (const int size : {outputs, 3, 1, 1}) weights->add_dims(size);
  for (int i = 0; i < outputs * 3; ++i) weights->add_float_data(0.01F * static_cast<float>(i % 5));
  auto* conv = addNode(graph, "Conv", {"mean", "weights"}, "scores");
  auto* kernel = conv->add_attribute();
  kernel->set_name("kernel_shape");
  kernel->set_type(onnx::AttributeProto::INTS);
  kernel->add_ints(1);
  kernel->add_ints(1);
  addNode(graph, "Flatten", {"scores"}, "row");
  addNode(graph, "Softmax", {"row"}, "probabilities");
  setShape(graph.add_output(), "probabilities", {1, outputs});
  if (change) change(graph);
  return model.SerializeAsString();
}

void writeSmallModel(const fs::path& folder, const std::string& more) {
  writeFile(folder / "small.onnx", smallOnnx(8, 4));
  writeFile(folder / "labels.txt", labelLines(4));
  writeFile(folder / "model.toml", modelToml("small.onnx", 8, more));
}

Preprocessing mobilenetInput(int side) {
  Preprocessing how;
  how.width = how.height = side;
  how.mean = {127.5, 127.5, 127.5};
  how.scale = {1 / 127.5, 1 / 127.5, 1 / 127.5};
  return how;
}

std::vector<cv::Mat> photographs(const fs::path& nyuv2, std::size_t count) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(nyuv2 / "rgb")) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<cv::Mat> images;
  for (std::size_t i = 0; i < count; ++i)
    images.push_back(cv::imread(files[i * files.size() / count].string(), cv::IMREAD_COLOR));
  return images;
}

std::vector<std::size_t> best(const std::vector<float>& values, std::size_t count) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) { return values[a] > values[b]; });
  order.resize(count);
  return order;
}

}  // namespace estancia::test
