// What the OpenCV engine makes of good and of bad networks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "estancia/core/digest.hpp"
#include "estancia/label/model.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::errorOf;
using test::modelToml;
using test::writeFile;
using testing::AllOf;
using testing::HasSubstr;

class Engine : public testing::Test {
 protected:
  /// Writes a model folder and opens it.
  std::unique_ptr<Labeler> open(const std::string& network, const std::string& toml, std::size_t labels = 4,
                                const std::string& file = "small.onnx") {
    writeFile(scratch_ / file, network);
    writeFile(scratch_ / "labels.txt", test::labelLines(labels));
    writeFile(scratch_ / "model.toml", toml);
    return loadModel(scratch_.path().string());
  }
  std::string refusal(const std::string& network, const std::string& toml, std::size_t labels = 4,
                      const std::string& file = "small.onnx") {
    return errorOf([&] { open(network, toml, labels, file); });
  }
  static void setWeights(onnx::GraphProto& graph, float value) {
    for (auto& weight : *graph.mutable_initializer(0)->mutable_float_data()) weight = value;
  }
  /// Lets the network end before its softmax.
  static void endWithLogits(onnx::GraphProto& graph) {
    graph.mutable_node()->RemoveLast();
    graph.mutable_output(0)->set_name("row");
  }

  test::ScratchFolder scratch_;
};

TEST_F(Engine, LabelsAnImage) {
  const auto labeler = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8));
  // scores are 0.01 · weights · mean colour, with the weights 0 1 2 | 3 4 0 | 1 2 3 | 4 0 1
  const auto words = labeler->label(cv::Mat(30, 40, CV_8UC3, cv::Scalar(10, 20, 30)));
  const std::vector<double> scores{0.8, 1.1, 1.4, 0.7};
  double sum = 0;
  for (const double s : scores) sum += std::exp(s);
  ASSERT_EQ(words.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(words[i], std::exp(scores[i]) / sum, 1e-5);
  EXPECT_EQ(labeler->vocabulary()[2], "word 2");
}

TEST_F(Engine, TurnsLogitsIntoTheSameProbabilities) {
  const cv::Mat image(30, 40, CV_8UC3, cv::Scalar(10, 20, 30));
  const auto direct = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8))->label(image);
  const auto ours =
      open(test::smallOnnx(8, 4, endWithLogits), modelToml("small.onnx", 8, "softmax = true"))->label(image);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(ours[i], direct[i], 1e-6);
}

TEST_F(Engine, IdentityChangesWithTheNetworkAndItsPreprocessing) {
  const auto first = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8))->identity();
  EXPECT_THAT(first, HasSubstr("small"));
  EXPECT_EQ(open(test::smallOnnx(8, 4), modelToml("small.onnx", 8, "licence = \"MIT\""))->identity(), first);
  EXPECT_NE(open(test::smallOnnx(8, 4), modelToml("small.onnx", 8, "crop = 0.5"))->identity(), first);
  EXPECT_NE(
      open(test::smallOnnx(8, 4, [](auto& g) { setWeights(g, 1); }), modelToml("small.onnx", 8))->identity(),
      first);
}

TEST_F(Engine, SaysWhenLabelsAndOutputsAreNotAsMany) {
  EXPECT_THAT(refusal(test::smallOnnx(8, 4), modelToml("small.onnx", 8), 5),
              AllOf(HasSubstr("4"), HasSubstr("5 labels")));
  EXPECT_THAT(refusal(test::smallOnnx(8, 4), modelToml("small.onnx", 8), 3),
              AllOf(HasSubstr("4"), HasSubstr("3 labels")));
}

TEST_F(Engine, SaysWhenOutputsAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::string more : {"", "softmax = true"})
    EXPECT_THAT(refusal(test::smallOnnx(8, 4,
                                        [&](auto& g) {
                                          endWithLogits(g);
                                          setWeights(g, nan);
                                        }),
                        modelToml("small.onnx", 8, more)),
                HasSubstr("nan"));
}

TEST_F(Engine, SuggestsSoftmaxWhenOutputsAreNoProbabilities) {
  for (const float weight : {-1.0F, 1.0F})
    EXPECT_THAT(refusal(test::smallOnnx(8, 4,
                                        [&](auto& g) {
                                          endWithLogits(g);
                                          setWeights(g, weight);
                                        }),
                        modelToml("small.onnx", 8)),
                HasSubstr("softmax"));
}

TEST_F(Engine, NamesTheOperatorThatItCannotRun) {
  const auto unknown = [](onnx::GraphProto& g) { g.mutable_node(0)->set_op_type("FancyPool"); };
  EXPECT_THAT(refusal(test::smallOnnx(8, 4, unknown), modelToml("small.onnx", 8)), HasSubstr("FancyPool"));
}

TEST_F(Engine, SaysWhenTheInputHasAnotherSize) {
  EXPECT_THAT(refusal(test::smallOnnx(8, 4), modelToml("small.onnx", 9)),
              AllOf(HasSubstr("1×3×8×8"), HasSubstr("1×3×9×9"), HasSubstr("`input`")));
}

TEST_F(Engine, RunsANetworkForAnySize) {
  const auto anySize = [](onnx::GraphProto& g) {
    auto* shape = g.mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
    shape->mutable_dim(2)->set_dim_param("height");
    shape->mutable_dim(3)->set_dim_param("width");
  };
  EXPECT_NO_THROW(open(test::smallOnnx(8, 4, anySize), modelToml("small.onnx", 9)));
}

TEST_F(Engine, ListsTheOutputsWhenThereAreSeveral) {
  const auto twoOutputs = [](onnx::GraphProto& g) {
    auto* copy = g.add_node();
    copy->set_op_type("Softmax");
    copy->set_name("second");
    copy->add_input("row");
    copy->add_output("second");
    *g.add_output() = g.output(0);
    g.mutable_output(1)->set_name("second");
  };
  EXPECT_THAT(refusal(test::smallOnnx(8, 4, twoOutputs), modelToml("small.onnx", 8)),
              AllOf(HasSubstr("probabilities"), HasSubstr("second"), HasSubstr("`output`")));
}

TEST_F(Engine, SaysWhenAFileIsMissingBrokenOrUnknown) {
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_THAT(refusal(good, modelToml("other.onnx", 8)), HasSubstr("other.onnx is missing"));
  EXPECT_THAT(refusal("this is no network", modelToml("small.onnx", 8)), HasSubstr("small.onnx"));
  EXPECT_THAT(refusal("", modelToml("small.onnx", 8)), HasSubstr("small.onnx"));
  EXPECT_THAT(refusal(good, modelToml("small.h5", 8), 4, "small.h5"),
              AllOf(HasSubstr("small.h5"), HasSubstr(".tflite")));
  EXPECT_THAT(refusal(good.substr(0, good.size() / 2), modelToml("small.onnx", 8)), HasSubstr("small.onnx"));
  EXPECT_THAT(refusal(good, modelToml("small.tflite", 8), 4, "small.tflite"), HasSubstr("TFL3"));
}

TEST_F(Engine, ComparesDigests) {
  const std::string good = test::smallOnnx(8, 4);
  const auto toml = [](const std::string& digest) {
    return modelToml("small.onnx", 8, "[sha256]\n\"small.onnx\" = \"" + digest + "\"");
  };
  EXPECT_NO_THROW(open(good, toml(sha256(good))));
  EXPECT_THAT(refusal(good, toml(sha256("other"))),
              AllOf(HasSubstr("small.onnx has SHA-256"), HasSubstr(sha256("other"))));
}

TEST_F(Engine, DoesNotFollowLinksOutOfTheFolder) {
  const test::ScratchFolder elsewhere;
  writeFile(elsewhere / "small.onnx", test::smallOnnx(8, 4));
  writeFile(scratch_ / "labels.txt", test::labelLines(4));
  writeFile(scratch_ / "model.toml", modelToml("small.onnx", 8));
  std::filesystem::create_symlink(elsewhere / "small.onnx", scratch_ / "small.onnx");
  EXPECT_THAT(errorOf([&] { loadModel(scratch_.path().string()); }), HasSubstr("out of the model's folder"));
}

const char* const prototxt = R"(name: "small"
input: "data" input_dim: 1 input_dim: 3 input_dim: 8 input_dim: 8
layer { name: "mean" type: "Pooling" bottom: "data" top: "mean" pooling_param { pool: AVE global_pooling: true } }
layer { name: "prob" type: "Softmax" bottom: "mean" top: "prob" }
)";
const std::string emptyCaffemodel = "\x0a\x05small";  // a NetParameter with nothing but its name

TEST_F(Engine, OpensCaffe) {
  writeFile(scratch_ / "deploy.prototxt", prototxt);
  const auto labeler =
      open(emptyCaffemodel, modelToml("net.caffemodel", 8, "config = \"deploy.prototxt\"\nscale = 0.1"), 3,
           "net.caffemodel");
  const auto words = labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(10, 20, 30)));
  const double sum = std::exp(1.0) + std::exp(2.0) + std::exp(3.0);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(words[i], std::exp(1.0 + static_cast<double>(i)) / sum, 1e-5);
}

TEST_F(Engine, AsksForTheLayersOfACaffemodel) {
  EXPECT_THAT(refusal(emptyCaffemodel, modelToml("net.caffemodel", 8), 3, "net.caffemodel"),
              AllOf(HasSubstr("prototxt"), HasSubstr("`config`")));
  const std::string toml = modelToml("net.caffemodel", 8, "config = \"deploy.prototxt\"");
  std::string unknown = prototxt;
  unknown.replace(unknown.find("Softmax"), 7, "Wonder");
  writeFile(scratch_ / "deploy.prototxt", unknown);
  EXPECT_THAT(refusal(emptyCaffemodel, toml, 3, "net.caffemodel"), HasSubstr("operator Wonder"));
  writeFile(scratch_ / "deploy.prototxt", "this is {{{ no network");
  EXPECT_THAT(refusal(emptyCaffemodel, toml, 3, "net.caffemodel"), HasSubstr("net.caffemodel"));
}

/// One field of a protobuf message: length-delimited.
std::string field(int number, const std::string& bytes) {
  return std::string(1, static_cast<char>(number << 3 | 2)) + static_cast<char>(bytes.size()) + bytes;
}

/// A node of a TensorFlow GraphDef: name, operator, inputs, and the type float for attribute "T" or "dtype".
std::string tensorflowNode(const std::string& name, const std::string& op, const std::string& input) {
  const std::string typeFloat = "\x30\x01";  // AttrValue.type = DT_FLOAT
  std::string node = field(1, name) + field(2, op);
  if (!input.empty()) node += field(3, input);
  return field(1, node + field(5, field(1, input.empty() ? "dtype" : "T") + field(2, typeFloat)));
}

TEST_F(Engine, OpensTensorflow) {
  const auto labeler =
      open(tensorflowNode("input", "Placeholder", "") + tensorflowNode("prob", "Softmax", "input"),
           modelToml("net.pb", 1, "scale = 0.1"), 3, "net.pb");
  const auto words = labeler->label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(10, 20, 30)));
  const double sum = std::exp(1.0) + std::exp(2.0) + std::exp(3.0);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(words[i], std::exp(1.0 + static_cast<double>(i)) / sum, 1e-5);
}

TEST_F(Engine, NamesTheTensorflowOperatorThatItCannotRun) {
  EXPECT_THAT(refusal(tensorflowNode("input", "Placeholder", "") + tensorflowNode("x", "Wonder", "input"),
                      modelToml("net.pb", 1), 3, "net.pb"),
              HasSubstr("Wonder"));
}

}  // namespace
}  // namespace estancia
