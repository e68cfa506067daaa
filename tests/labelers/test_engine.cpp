// What the engines make of good and of bad networks.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "estancia/core/digest.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::modelToml;
using test::writeFile;

/// Every test runs with each engine.
class Engine : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    ESTANCIA_NEEDS(GetParam() != "onnxruntime" || test::findOnnxruntime(),
                   "ONNX Runtime is missing; run script/bootstrap and build again");
  }

  /// Writes a model folder and opens it.
  std::unique_ptr<Labeler> open(const std::string& network, const std::string& toml, std::size_t labels = 4,
                                const std::string& file = "small.onnx") {
    writeFile(scratch_ / file, network);
    writeFile(scratch_ / "labels.txt", test::labelLines(labels));
    writeFile(scratch_ / "model.toml", toml);
    return loadModel(scratch_.path().string(), {GetParam(), 1});
  }
  test::Caught refusal(const std::string& network, const std::string& toml, std::size_t labels = 4,
                       const std::string& file = "small.onnx") {
    return test::caught([&] { open(network, toml, labels, file); });
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

/// What OpenCV alone can read.
class OpencvEngine : public Engine {
 protected:
  static void expectSoftmaxOfColors(Labeler& labeler) {
    const auto words = labeler.label(cv::Mat(8, 8, CV_8UC3, cv::Scalar(10, 20, 30)));
    const double sum = std::exp(1.0) + std::exp(2.0) + std::exp(3.0);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(words[i], std::exp(1.0 + static_cast<double>(i)) / sum, 1e-5);
  }
};

INSTANTIATE_TEST_SUITE_P(All, Engine, testing::Values("onnxruntime", "opencv"),
                         [](const auto& param) { return param.param; });
INSTANTIATE_TEST_SUITE_P(Alone, OpencvEngine, testing::Values("opencv"),
                         [](const auto& param) { return param.param; });

TEST_P(Engine, LabelsAnImageAlsoByLogits) {
  const auto labeler = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8));
  // scores are 0.01 · weights · mean color, with the weights 0 1 2 | 3 4 0 | 1 2 3 | 4 0 1
  const auto words = labeler->label(cv::Mat(30, 40, CV_8UC3, cv::Scalar(10, 20, 30)));
  const std::vector<double> scores{0.8, 1.1, 1.4, 0.7};
  double sum = 0;
  for (const double s : scores) sum += std::exp(s);
  ASSERT_EQ(words.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(words[i], std::exp(scores[i]) / sum, 1e-5);
  EXPECT_EQ(labeler->vocabulary()[2], "word 2");
  const cv::Mat image(30, 40, CV_8UC3, cv::Scalar(10, 20, 30));
  const auto direct = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8))->label(image);
  const auto ours =
      open(test::smallOnnx(8, 4, endWithLogits), modelToml("small.onnx", 8, "softmax = true"))->label(image);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(ours[i], direct[i], 1e-6);
}

/// A model of a layer inside of the small network, of which labels.txt knows nothing.
std::string layerToml(const std::string& output, const std::string& more) {
  return "name = \"layer\"\nfile = \"small.onnx\"\ninput = 8\ncolor = \"BGR\"\noutput = \"" + output +
         "\"\n" + more + "\n";
}

TEST_P(Engine, IdentityChangesWithTheNetworkAndItsPreprocessing) {
  const auto first = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8))->identity();
  EXPECT_EQ(first.substr(0, 6), "small ");
  EXPECT_EQ(open(test::smallOnnx(8, 4), modelToml("small.onnx", 8, "license = \"MIT\""))->identity(), first);
  EXPECT_NE(open(test::smallOnnx(8, 4), modelToml("small.onnx", 8, "crop = 0.5"))->identity(), first);
  EXPECT_NE(
      open(test::smallOnnx(8, 4, [](auto& g) { setWeights(g, 1); }), modelToml("small.onnx", 8))->identity(),
      first);
}

void putElsewhere(onnx::TensorProto* weights) {
  weights->set_name("weights");
  weights->clear_float_data();
  weights->set_data_location(onnx::TensorProto::EXTERNAL);
  auto* location = weights->add_external_data();
  location->set_key("location");
  location->set_value("labels.txt");
}

TEST_P(Engine, RefusesWeightsInOtherFiles) {
  using Model = onnx::ModelProto;
  const auto attribute = [](Model& m) { return m.mutable_graph()->mutable_node(0)->add_attribute(); };
  const std::pair<std::string, std::function<void(Model&)>> places[] = {
      {"initializer", [](Model& m) { putElsewhere(m.mutable_graph()->mutable_initializer(0)); }},
      {"sparse values",
       [](Model& m) { putElsewhere(m.mutable_graph()->add_sparse_initializer()->mutable_values()); }},
      {"tensors", [&](Model& m) { putElsewhere(attribute(m)->add_tensors()); }},
      {"graphs", [&](Model& m) { putElsewhere(attribute(m)->add_graphs()->add_initializer()); }},
      {"Loop in If",
       [&](Model& m) {
         auto* loop = attribute(m)->mutable_g()->add_node()->add_attribute()->mutable_g();
         putElsewhere(loop->add_node()->add_attribute()->mutable_t());
       }},
      {"function",
       [](Model& m) { putElsewhere(m.add_functions()->add_node()->add_attribute()->mutable_t()); }},
      {"algorithm",
       [](Model& m) { putElsewhere(m.add_training_info()->mutable_algorithm()->add_initializer()); }}};
  for (const auto& [place, change] : places) {
    Model model;
    ASSERT_TRUE(model.ParseFromString(test::smallOnnx(8, 4)));
    change(model);
    EXPECT_THAT(refusal(model.SerializeAsString(), modelToml("small.onnx", 8)),
                FailsWith(ErrorCode::unsafePath))
        << place;
  }
}

TEST_P(Engine, LabelsBatchesLikeImages) {
  const auto labeler = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8));
  std::vector<Prepared> batch;
  for (int i = 0; i < 37; ++i)
    batch.push_back(labeler->prepare(cv::Mat(30, 40, CV_8UC3, cv::Scalar(i, 2 * i, 255 - i))));
  for (const int threads : {1, 2}) {
    const auto several = loadModel(scratch_.path().string(), {GetParam(), threads});
    EXPECT_GE(several->batchSize(), 1U);
    const auto results = several->inferBatch(batch);
    ASSERT_EQ(results.size(), batch.size());
    for (std::size_t i = 0; i < batch.size(); ++i) {
      EXPECT_EQ(results[i].problem, "");
      EXPECT_EQ(results[i].descriptor, labeler->infer(batch[i]));
    }
    EXPECT_TRUE(several->inferBatch({}).empty());
    std::vector<Prepared> bad(3, batch[0]);
    bad[1].input = batch[0].input.clone();
    bad[1].input.setTo(std::numeric_limits<float>::quiet_NaN());
    EXPECT_THAT([&] { several->inferBatch(bad); }, FailsWith(ErrorCode::labelerFailure));
  }
}

TEST_P(Engine, RefusesNetworksThatItCannotRun) {
  using Graph = onnx::GraphProto;
  const auto logits = [](float weight) {
    return [weight](Graph& g) {
      endWithLogits(g);
      setWeights(g, weight);
    };
  };
  const auto unknown = [](Graph& g) { g.mutable_node(0)->set_op_type("FancyPool"); };
  const auto nested = [](Graph& g) {
    auto* inner = &g;
    for (int i = 0; i < 1000; ++i) inner = inner->add_node()->add_attribute()->mutable_g();
  };
  const auto twoInputs = [](Graph& g) {
    *g.add_input() = g.input(0);
    g.mutable_input(1)->set_name("mask");
    g.mutable_input(1)->mutable_type()->mutable_tensor_type()->mutable_shape()->mutable_dim(1)->set_dim_value(
        1);
  };
  const auto twoOutputs = [](Graph& g) {
    auto* copy = g.add_node();
    copy->set_op_type("Softmax");
    copy->set_name("second");
    copy->add_input("row");
    copy->add_output("second");
    *g.add_output() = g.output(0);
    g.mutable_output(1)->set_name("second");
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string good = test::smallOnnx(8, 4), toml = modelToml("small.onnx", 8);
  const std::tuple<const char*, std::string, std::string, ErrorCode> cases[] = {
      {"nan", test::smallOnnx(8, 4, logits(nan)), toml, ErrorCode::labelerFailure},
      {"below 0", test::smallOnnx(8, 4, logits(-1)), toml, ErrorCode::labelerFailure},
      {"above 1", test::smallOnnx(8, 4, logits(1)), toml, ErrorCode::labelerFailure},
      {"operator", test::smallOnnx(8, 4, unknown), toml, ErrorCode::unsupportedFile},
      {"size", good, modelToml("small.onnx", 9), ErrorCode::mismatch},
      {"nested without end", test::smallOnnx(8, 4, nested), toml, ErrorCode::malformedFile},
      {"two inputs", test::smallOnnx(8, 4, twoInputs), toml, ErrorCode::mismatch},
      {"two outputs", test::smallOnnx(8, 4, twoOutputs), toml, ErrorCode::mismatch},
      {"missing", good, modelToml("other.onnx", 8), ErrorCode::fileNotFound},
      {"no network", "this is no network", toml, ErrorCode::malformedFile},
      {"empty", "", toml, ErrorCode::malformedFile},
      {"half", good.substr(0, good.size() / 2), toml, ErrorCode::malformedFile}};
  for (const auto& [what, network, settings, code] : cases)
    EXPECT_THAT(refusal(network, settings), FailsWith(code)) << what;
  for (const std::size_t labels : {3, 5})
    EXPECT_THAT(refusal(good, toml, labels), FailsWith(ErrorCode::mismatch)) << labels;
  for (const std::string file : {"small.h5", "small.tflite"})
    EXPECT_THAT(refusal(good, modelToml(file, 8), 4, file), FailsWith(ErrorCode::unsupportedFile)) << file;
}

TEST_P(Engine, AnswersTheSameWhenItIsOpenedOnDemand) {
  const auto now = open(test::smallOnnx(8, 4), modelToml("small.onnx", 8));
  const std::string folder = scratch_.path().string();
  const auto later = loadModel(folder, {GetParam(), 1, true});
  EXPECT_EQ(later->identity(), now->identity());
  EXPECT_EQ(later->cacheKey(), now->cacheKey()) << "they share a cache";
  EXPECT_EQ(later->vocabulary(), now->vocabulary());
  EXPECT_EQ(later->batchSize(), now->batchSize());
  const cv::Mat image(20, 20, CV_8UC3, cv::Scalar(10, 90, 200));
  const std::vector<Prepared> two{later->prepare(image), later->prepare(cv::Mat(image / 2))};
  EXPECT_EQ(later->inferBatch(two).at(1).descriptor, now->label(cv::Mat(image / 2)));
  writeFile(scratch_ / "small.onnx", "no network");
  const auto bad = loadModel(folder, {GetParam(), 1, true});
  EXPECT_THAT([&] { bad->label(image); }, FailsWith(ErrorCode::malformedFile)) << "said at the first image";
}

TEST_P(Engine, DoesNotFollowLinksOutOfTheFolder) {
  const test::ScratchFolder elsewhere;
  writeFile(elsewhere / "small.onnx", test::smallOnnx(8, 4));
  writeFile(scratch_ / "labels.txt", test::labelLines(4));
  writeFile(scratch_ / "model.toml", modelToml("small.onnx", 8));
  std::filesystem::create_symlink(elsewhere / "small.onnx", scratch_ / "small.onnx");
  EXPECT_THAT([&] { loadModel(scratch_.path().string()); }, FailsWith(ErrorCode::unsafePath));
}

const char* const prototxt = R"(name: "small"
input: "data" input_dim: 1 input_dim: 3 input_dim: 8 input_dim: 8
layer { name: "mean" type: "Pooling" bottom: "data" top: "mean" pooling_param { pool: AVE global_pooling: true } }
layer { name: "prob" type: "Softmax" bottom: "mean" top: "prob" }
)";
const std::string emptyCaffemodel = "\x0a\x05small";  // a NetParameter with nothing but its name

TEST_P(OpencvEngine, OpensCaffe) {
  writeFile(scratch_ / "deploy.prototxt", prototxt);
  const auto labeler =
      open(emptyCaffemodel, modelToml("net.caffemodel", 8, "config = \"deploy.prototxt\"\nscale = 0.1"), 3,
           "net.caffemodel");
  expectSoftmaxOfColors(*labeler);
}

TEST_P(OpencvEngine, RefusesWhatItCannotRun) {
  EXPECT_THAT(refusal(emptyCaffemodel, modelToml("net.caffemodel", 8), 3, "net.caffemodel"),
              FailsWith(ErrorCode::invalidInput));
  const std::string toml = modelToml("net.caffemodel", 8, "config = \"deploy.prototxt\"");
  std::string unknown = prototxt;
  unknown.replace(unknown.find("Softmax"), 7, "Wonder");
  writeFile(scratch_ / "deploy.prototxt", unknown);
  EXPECT_THAT(refusal(emptyCaffemodel, toml, 3, "net.caffemodel"), FailsWith(ErrorCode::mismatch));
  writeFile(scratch_ / "deploy.prototxt", "this is {{{ no network");
  EXPECT_THAT(refusal(emptyCaffemodel, toml, 3, "net.caffemodel"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refusal(test::smallOnnx(8, 4), layerToml("mean", "features = 3")),
              FailsWith(ErrorCode::unsupportedFile));
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

TEST_P(OpencvEngine, OpensTensorflow) {
  const auto labeler =
      open(tensorflowNode("input", "Placeholder", "") + tensorflowNode("prob", "Softmax", "input"),
           modelToml("net.pb", 1, "scale = 0.1"), 3, "net.pb");
  expectSoftmaxOfColors(*labeler);
}

/// What only the choice between engines shows.
class Engines : public Engine {};
INSTANTIATE_TEST_SUITE_P(Both, Engines, testing::Values("onnxruntime"),
                         [](const auto& param) { return param.param; });

TEST_P(Engines, GiveTheFeaturesOfAnInnerLayerAsSharesAndRefuseWhatIsNone) {
  const cv::Mat image(30, 40, CV_8UC3, cv::Scalar(10, 20, 30));
  const auto colors = open(test::smallOnnx(8, 4), layerToml("mean", "features = 3"));
  EXPECT_EQ(colors->vocabulary()[2], "layer 2");
  const auto shares = colors->label(image);
  ASSERT_EQ(shares.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(shares[i], static_cast<double>(i + 1) / 6, 1e-6);
  // 0.8, 1.1, 1.4, 0.7 of LabelsAnImage above
  const auto scores = open(test::smallOnnx(8, 4), layerToml("row", "features = 4"))->label(image);
  EXPECT_NEAR(scores[2], 0.35, 1e-6);
  EXPECT_NE(open(test::smallOnnx(8, 4), layerToml("row", "features = 4"))->identity(),
            open(test::smallOnnx(8, 4), layerToml("scores", "features = 4"))->identity());
  const std::string network = test::smallOnnx(8, 4);
  EXPECT_THAT(refusal(network, layerToml("nothing", "features = 3")), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refusal(network, layerToml("mean", "features = 4")), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refusal(network, layerToml("mean", "")), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal(network, layerToml("mean", "features = 1")), FailsWith(ErrorCode::malformedFile));
  for (const std::string more :
       {"labels = \"labels.txt\"", "softmax = true", "sigmoid = true", "unused = [0]", "reduce = \"max\""})
    EXPECT_THAT(refusal(network, layerToml("mean", "features = 3\n" + more)),
                FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(
      refusal(test::smallOnnx(8, 4, [](auto& g) { setWeights(g, -1); }), layerToml("row", "features = 4")),
      FailsWith(ErrorCode::mismatch));
}

TEST_P(Engines, TheBestComesFirstAndATypePinsOne) {
  EXPECT_EQ(engines(), (std::vector<std::string>{"onnxruntime", "opencv"}));
  writeFile(scratch_ / "small.onnx", test::smallOnnx(8, 4));
  writeFile(scratch_ / "labels.txt", test::labelLines(4));
  const auto openAs = [this](const std::string& type, const std::string& engine) {
    writeFile(scratch_ / "model.toml", modelToml("small.onnx", 8, "type = \"" + type + "\""));
    return loadModel(scratch_.path().string(), {engine, 1})->cacheKey();
  };
  EXPECT_TRUE(openAs("network", "").ends_with(onnxruntimeVersion()));
  EXPECT_TRUE(openAs("network", "opencv").ends_with(opencvVersion()));
  EXPECT_TRUE(openAs("opencv", "").ends_with(opencvVersion()));
  EXPECT_TRUE(openAs("onnxruntime", "").ends_with(onnxruntimeVersion()));
  EXPECT_THAT([&] { openAs("opencv", "onnxruntime"); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { openAs("network", "abacus"); }, FailsWith(ErrorCode::unknownName));
}

TEST_P(Engines, AModelIn8BitsKeepsItsNameAndHasAnotherIdentity) {
  const std::string real = test::smallOnnx(8, 4),
                    bytes = test::smallOnnx(8, 4, [](auto&graph) { setWeights(graph, 1); });
  writeFile(scratch_ / "bytes.onnx", bytes);
  const std::string toml = modelToml("small.onnx", 8, "int8 = \"bytes.onnx\"") +
                           "[sha256]\n\"small.onnx\" = \"" + sha256(real) + "\"\n\"bytes.onnx\" = \"" +
                           sha256(bytes) + "\"\n";
  const std::string alone = open(real, modelToml("small.onnx", 8))->identity();
  EXPECT_EQ(open(real, toml)->identity(), alone);  // the other file does not count
  LabelerOptions options;
  options.precision = Precision::int8;
  const std::string model = scratch_.path().string();
  EXPECT_THAT(loadModel(model, options)->identity(), testing::StartsWith("small int8-"));
  EXPECT_NE(loadModel(model, options)->cacheKey(), loadModel(model)->cacheKey());
  LabelerOptions elsewhere = options;
  elsewhere.engine = "opencv";
  EXPECT_THAT([&] { loadModel(model, elsewhere); }, FailsWith(ErrorCode::invalidOption));
  options.onDemand = true;  // knows it at once
  EXPECT_EQ(loadModel(model, options)->identity(), checkModel(model, options).identity);
  EXPECT_EQ(checkModel(model, options).spec.name, "small");
  writeFile(scratch_ / "bytes.onnx", real);
  EXPECT_THAT([&] { loadModel(model, options); }, FailsWith(ErrorCode::corruptFile));
  EXPECT_NO_THROW(loadModel(model));
  options.onDemand = false;
  writeFile(scratch_ / "model.toml", modelToml("small.onnx", 8));
  EXPECT_THAT([&] { loadModel(model, options); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_P(Engines, SayWhenTheNetworkChangesBetweenImagesAndBatches) {
  const auto toml = modelToml("small.onnx", 8);
  open(test::smallOnnx(8, 4), toml);
  const auto labeler = loadModel(scratch_.path().string(), {"onnxruntime", 2});
  writeFile(scratch_ / "small.onnx", test::smallOnnx(8, 4, [](auto& g) { setWeights(g, 1); }));
  const std::vector<Prepared> batch(3, labeler->prepare(cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(9))));
  EXPECT_THAT([&] { labeler->inferBatch(batch); }, FailsWith(ErrorCode::corruptFile));
  for (const cv::Mat& other :
       {cv::Mat(8, 8, CV_8UC3), cv::Mat(), labeler->prepare(cv::Mat(9, 9, CV_8UC3)).input})
    EXPECT_EQ(test::caught([&] {
                labeler->infer({other, "", {}});
              }).code.has_value(),
              other.dims != 4)
        << "an image that another labeler prepared: " << other.size();
}

TEST_P(Engines, NameTheOperatorThatIsNotMadeForTheTypeOfItsNumbers) {
  const auto doubles = [](onnx::GraphProto& g) {
    for (auto* value : {g.mutable_input(0), g.mutable_output(0)})
      value->mutable_type()->mutable_tensor_type()->set_elem_type(onnx::TensorProto::DOUBLE);
    auto* weights = g.mutable_initializer(0);
    weights->set_data_type(onnx::TensorProto::DOUBLE);
    for (const float weight : weights->float_data()) weights->add_double_data(weight);
    weights->clear_float_data();
  };
  EXPECT_THAT(refusal(test::smallOnnx(8, 4, doubles), modelToml("small.onnx", 8)),
              FailsWith(ErrorCode::unsupportedFile));
}

}  // namespace
}  // namespace estancia
