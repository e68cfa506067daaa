// Networks of 8 bits beside an emulation in real numbers, their ranges, and models that get one.
// SPDX-License-Identifier: Apache-2.0
#include "convert/activation_ranges.hpp"
#include "convert/quantize.hpp"
#include "convert/quantize_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>

#include "convert/calibration.hpp"
#include "convert/quantization_plan.hpp"
#include "convert/to_onnx.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_spec.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia::convert {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::Contains;

TEST(ActivationRanges, AreReadAsTheyWereWritten) {
  const test::ScratchFolder scratch;
  const ActivationRanges ranges{{"a value", {-0.1F, 1.0F / 3}}, {"t1", {0, 6.02e23F}}, {"z", {0, 0}}};
  test::writeFile(scratch / "ranges.txt", rangesText(ranges, "of a test"));
  EXPECT_EQ(readRanges(scratch / "ranges.txt"), ranges);
}

TEST(ActivationRanges, RefuseWhatIsNoTable) {
  const test::ScratchFolder scratch;
  const auto read = [&](const std::string& text) {
    test::writeFile(scratch / "r.txt", text);
    return test::caught([&] { readRanges(scratch / "r.txt"); });
  };
  for (const char* line : {"0 1", "0 1 ", "x 1 t", "0 nan t", "0 inf t", "1"})
    EXPECT_THAT(read("# of a test\n" + std::string(line) + "\n"), FailsWith(ErrorCode::malformedFile))
        << line;
  EXPECT_THAT(read("0.5 1 t\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(read("0 1 t\n0 2 t\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { readRanges(scratch / "none.txt"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(ValueHistogram, CutsOffASingleOutlier) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float> numbers(200'000);
  for (float& number : numbers) number = std::abs(normal(random));
  numbers[7] = 12;
  ValueHistogram histogram;
  histogram.add(numbers);
  EXPECT_EQ(histogram.range().low, 0);
  EXPECT_LT(histogram.range().high, 10);
  EXPECT_GT(histogram.range().high, 3);
}

TEST(ValueHistogram, TakesWhatIsNotFiniteForZero) {
  const std::vector<float> odd{std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::infinity(), 0, 1};
  ValueHistogram histogram;
  EXPECT_EQ(histogram.range(), ActivationRange());
  histogram.add(odd);
  EXPECT_NEAR(histogram.range().high, 1, 1e-3);
}

constexpr int side = 6, filters = 4, outputs = 5;

// Parts of a graph in the text form of protocol buffers.
std::string tensorText(const char* name, const std::vector<int>& shape, const std::vector<float>& values) {
  return fmt::format("initializer {{ name: '{}' data_type: 1 dims: [{}] float_data: [{}] }} ", name,
                     fmt::join(shape, ", "), fmt::join(values, ", "));
}
std::string nodeText(const char* type, const std::vector<std::string>& inputs, const std::string& output,
                     const char* attribute = "") {
  return fmt::format("node {{ op_type: '{}' input: ['{}'] output: '{}' {} }} ", type,
                     fmt::join(inputs, "', '"), output, attribute);
}
std::string valueText(const char* kind, const char* name, const std::vector<int>& shape) {
  return fmt::format(
      "{} {{ name: '{}' type {{ tensor_type {{ elem_type: 1 shape {{ dim {{ dim_value: {} }} }} }} }} }} ",
      kind, name, fmt::join(shape, " } dim { dim_value: "));
}
/// So many convolutions that change nothing.
std::string identitiesText(std::string from, const std::string& to, int count) {
  std::string text = tensorText("identity", {3, 3, 1, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  for (int k = 1; k <= count; ++k) {
    const std::string next = k < count ? "kept" + std::to_string(k) : to;
    text += nodeText("Conv", {from, "identity"}, next);
    from = next;
  }
  return text;
}

/// input → as many convolutions as stay float, which change nothing → image → conv 1×1 → ReLU → concatenation
/// with itself → mean → conv 1×1 → scores.
struct SmallNetwork {
  std::vector<float> first, bias, last;

  explicit SmallNetwork(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    const auto fill = [&](std::vector<float>& values, int count) {
      for (int i = 0; i < count; ++i) values.push_back(normal(random));
    };
    fill(first, filters * 3);
    fill(bias, filters);
    fill(last, outputs * filters * 2);
  }

  std::string onnx() const {
    const std::string graph =
        valueText("input", "input", {1, 3, side, side}) + identitiesText("input", "image", floatLayers) +
        tensorText("w1", {filters, 3, 1, 1}, first) + tensorText("b1", {filters}, bias) +
        tensorText("w2", {outputs, filters * 2, 1, 1}, last) +
        nodeText("Conv", {"image", "w1", "b1"}, "sums") + nodeText("Relu", {"sums"}, "positive") +
        nodeText("Concat", {"positive", "positive"}, "both", "attribute { name: 'axis' type: INT i: 1 }") +
        nodeText("GlobalAveragePool", {"both"}, "mean") + nodeText("Conv", {"mean", "w2"}, "scores") +
        valueText("output", "scores", {1, outputs, 1, 1});
    onnx::ModelProto model;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
        "ir_version: 5 opset_import { version: 10 } graph { name: 'small' " + graph + "}", &model));
    return model.SerializeAsString();
  }
};

const ActivationRanges ranges{{"image", {-1, 1}}, {"positive", {0, 4}}, {"both", {0, 4}}, {"mean", {0, 3}}};

/// A number as quantized to 8 bits.
double stored(double number, ActivationRange range) {
  const double step = (range.high - range.low) / 255, zero = std::nearbyint(-range.low / step);
  return (std::clamp(std::nearbyint(number / step) + zero, 0.0, 255.0) - zero) * step;
}

/// The network in real numbers, each value rounded to its 8 bits.
std::vector<double> emulated(const SmallNetwork& network, const cv::Mat& image) {
  std::vector<double> mean(filters);
  for (int f = 0; f < filters; ++f) {
    const auto weights = std::vector<float>(network.first.begin() + f * 3, network.first.begin() + f * 3 + 3);
    const double scale = weightScale(weights, 0);
    for (int p = 0; p < side * side; ++p) {
      const double biasStep = scale * 2 / 255;
      double sum = std::nearbyint(network.bias[static_cast<std::size_t>(f)] / biasStep) * biasStep;
      for (int c = 0; c < 3; ++c)
        sum += std::clamp(std::nearbyint(weights[static_cast<std::size_t>(c)] / scale), -127.0, 127.0) *
               scale * stored(image.ptr<float>(0, c)[p], ranges.at("image"));
      mean[static_cast<std::size_t>(f)] += stored(std::max(sum, 0.0), ranges.at("both")) / (side * side);
    }
  }
  std::vector<double> scores(outputs);
  for (int o = 0; o < outputs; ++o)
    for (int f = 0; f < filters * 2; ++f)
      scores[static_cast<std::size_t>(o)] +=
          network.last[static_cast<std::size_t>(o * filters * 2 + f)] *
          stored(mean[static_cast<std::size_t>(f % filters)], ranges.at("mean"));
  return scores;
}

onnx::ModelProto parsed(const std::string& bytes) {
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  return model;
}

TEST(Quantize, ComputesWhatASlowEmulationComputes) {
  ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
  for (unsigned seed = 0; seed < 8; ++seed) {
    const SmallNetwork network(seed);
    const auto labeler = openNetworkValues(quantizedOnnx(network.onnx(), ranges, "small"), "small", 1);
    cv::Mat image({1, 3, side, side}, CV_32F);
    cv::RNG(seed).fill(image, cv::RNG::UNIFORM, -1.2, 1.2);  // some saturate
    const std::vector<double> expected = emulated(network, image);
    labeler->run(image, [&](std::size_t, std::span<const float> scores) {
      ASSERT_EQ(scores.size(), expected.size());
      // One number on the edge between two steps may fall to the other side.
      for (std::size_t i = 0; i < scores.size(); ++i) EXPECT_NEAR(scores[i], expected[i], 0.06) << seed;
    });
  }
}

TEST(Quantize, KeepsTheFirstLayersAndTheLastFloat) {
  const SmallNetwork network(1);
  EXPECT_THAT(valuesToQuantize(network.onnx(), "small"),
              testing::ElementsAre("image", "positive", "both", "mean"));
  const onnx::ModelProto model = parsed(quantizedOnnx(network.onnx(), ranges, "small"));
  std::set<std::string> constants;
  for (const auto& constant : model.graph().initializer()) constants.insert(constant.name());
  EXPECT_THAT(constants, Contains("identity"));
  EXPECT_THAT(constants, Contains("w2"));
  EXPECT_THAT(constants, testing::Not(Contains("w1")));
  EXPECT_EQ(model.opset_import(0).version(), 13);
  // A concatenation moves bytes: all that it reads and writes has one scale.
  std::map<std::string, std::string> scaleOf;
  for (const auto& node : model.graph().node())
    if (node.op_type() == "QuantizeLinear") scaleOf[node.input(0)] = node.input(1);
  EXPECT_EQ(scaleOf["positive"], scaleOf["both"]);
  EXPECT_NE(scaleOf["both"], scaleOf["mean"]);
}

TEST(Quantize, WeightsOnAGridKeepIt) {
  std::vector<float> weights;
  for (int i = -100; i <= 90; ++i) weights.push_back(0.013F * static_cast<float>(i));
  EXPECT_EQ(weightStep(weights), 0.013F);
  EXPECT_EQ(weightScale(weights, 0.013F), 0.013F);
  weights.push_back(0.0055F);
  EXPECT_EQ(weightStep(weights), 0);
  EXPECT_EQ(weightStep({}), 0);
  EXPECT_EQ(weightStep({0, 0}), 0);
}

TEST(Quantize, AFilterOfZerosHasAScale) {
  EXPECT_GT(weightScale({0, 0, 0}, 0), 0);
  SmallNetwork network(1);
  std::fill(network.first.begin(), network.first.begin() + 3, 0.0F);
  EXPECT_NO_THROW(quantizedOnnx(network.onnx(), ranges, "small"));
}

TEST(Quantize, RefusesWhatItCannotQuantize) {
  const std::string good = SmallNetwork(1).onnx();
  EXPECT_THAT([&] { quantizedOnnx("no network", ranges, "net.onnx"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { quantizedOnnx(good.substr(0, good.size() / 2), ranges, "net.onnx"); },
              FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { quantizedOnnx(quantizedOnnx(good, ranges, "x"), ranges, "net.onnx"); },
              FailsWith(ErrorCode::unsupportedFile));
  ActivationRanges lacking = ranges;
  lacking.erase("mean");
  EXPECT_THAT([&] { quantizedOnnx(good, lacking, "net.onnx"); }, FailsWith(ErrorCode::mismatch));
  SmallNetwork infinite(1);
  infinite.first[2] = INFINITY;
  EXPECT_THAT([&] { quantizedOnnx(infinite.onnx(), ranges, "net.onnx"); },
              FailsWith(ErrorCode::malformedFile));
  SmallNetwork cut(1);
  cut.bias.pop_back();
  EXPECT_THAT([&] { quantizedOnnx(cut.onnx(), ranges, "net.onnx"); }, FailsWith(ErrorCode::malformedFile));
}

TEST(Quantize, TheDefaultNetworkIsTheOneThatBootstrapMakes) {
  const auto folder = test::findFetched("models/inception-v3");
  ESTANCIA_NEEDS(folder, "the default network is missing; run script/bootstrap");
  const test::ScratchFolder scratch;
  const auto ranges = std::filesystem::path(ESTANCIA_SOURCE_DIR) / "models/inception-v3/int8-ranges.txt";
  writeQuantized(*folder / "inception-v3.onnx", ranges, scratch / "out.onnx");
  EXPECT_EQ(sha256OfFile(scratch / "out.onnx"), readModelSpec(*folder).sha256.at("inception-v3-int8.onnx"));
}

/// The small network behind convolutions that change nothing: those that stay float, and one of 8 bits.
void deepen(onnx::GraphProto& graph) {
  const google::protobuf::RepeatedPtrField<onnx::NodeProto> small = graph.node();
  graph.clear_node();
  EXPECT_TRUE(google::protobuf::TextFormat::MergeFromString(identitiesText("input", "same", floatLayers + 1),
                                                            &graph));
  graph.mutable_node()->MergeFrom(small);
  graph.mutable_node(floatLayers + 1)->set_input(0, "same");
}

class QuantizeModel : public testing::Test {
 protected:
  void SetUp() override {
    ESTANCIA_NEEDS(test::findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
    test::writeSmallModel(model());
    writeFile(model() / "small.onnx", test::smallOnnx(8, 4, deepen));
    for (int i = 0; i < 5; ++i) {
      cv::Mat image(20, 30, CV_8UC3);
      cv::RNG(static_cast<std::uint64_t>(i) + 1).fill(image, cv::RNG::UNIFORM, 0, 255);
      fs::create_directories(photos());
      cv::imwrite((photos() / (std::to_string(i) + ".png")).string(), image);
    }
  }
  fs::path model() const { return scratch_ / "model"; }
  fs::path photos() const { return scratch_ / "photos"; }
  QuantizedModel quantize(const QuantizeOptions& options = {}) {
    return quantizeModel(model(), *openSequence(photos()), options);
  }
  LexicalDescriptor label(Precision precision) {
    LabelerOptions options;
    options.precision = precision;
    return loadModel(model().string(), options)->label(openSequence(photos())->image(3));
  }

  test::ScratchFolder scratch_;
};

TEST_F(QuantizeModel, PutsANetworkOf8BitsBesideTheOther) {
  const LexicalDescriptor before = label(Precision::float32);
  const QuantizedModel made = quantize();
  EXPECT_EQ(made.file, model() / "small-int8.onnx");
  EXPECT_EQ(made.sha256, sha256OfFile(made.file));
  EXPECT_EQ(made.images, 5U);
  EXPECT_GT(made.values, 1U);
  EXPECT_TRUE(made.problems.empty());
  const ModelSpec spec = readModelSpec(model());
  EXPECT_EQ(spec.int8, "small-int8.onnx");
  EXPECT_EQ(spec.sha256.at("small-int8.onnx"), made.sha256);
  EXPECT_EQ(label(Precision::float32), before);
  const LexicalDescriptor bytes = label(Precision::int8);
  EXPECT_NE(bytes, before);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(bytes[i], before[i], 0.02);
}

TEST_F(QuantizeModel, RangesMakeTheSameNetworkAgain) {
  QuantizeOptions options;
  options.ranges = scratch_ / "ranges.txt";
  const QuantizedModel made = quantize(options);
  writeQuantized(model() / "small.onnx", options.ranges, scratch_ / "again.onnx");
  EXPECT_EQ(sha256OfFile(scratch_ / "again.onnx"), made.sha256);
  options.overwrite = true;
  options.threads = 2;
  EXPECT_EQ(quantize(options).sha256, made.sha256);
  options.calibration.light = 0;
  EXPECT_NE(quantize(options).sha256, made.sha256);
  EXPECT_EQ(readModelSpec(model()).sha256.size(), 1U);  // the old digest went
}

TEST_F(QuantizeModel, ChangesNothingWhenItFails) {
  const std::string toml = readFile(model() / "model.toml");
  for (int i = 0; i < 5; ++i) writeFile(photos() / (std::to_string(i) + ".png"), "no image");
  EXPECT_THROW(quantize(), Error);
  EXPECT_EQ(readFile(model() / "model.toml"), toml);
  writeFile(model() / "small.onnx", test::smallOnnx(8, 4));
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::unsupportedFile));  // not deep enough
  writeFile(model() / "small.onnx", "no network");
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_FALSE(fs::exists(model() / "small-int8.onnx"));
  EXPECT_FALSE(fs::exists(model() / "small-int8.new.onnx"));
}

TEST_F(QuantizeModel, ReplacesOnlyWhenTold) {
  QuantizeOptions kept;
  kept.ranges = scratch_ / "ranges.txt";
  writeFile(kept.ranges, "precious");
  EXPECT_THAT([&] { quantize(kept); }, FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(kept.ranges), "precious");
  quantize();
  EXPECT_THAT([&] { quantize(); }, FailsWith(ErrorCode::fileExists));
  QuantizeOptions options;
  options.overwrite = true;
  EXPECT_NO_THROW(quantize(options));
}

TEST(WithInt8, KeepsTheRestOfTheFile) {
  const std::string digest(64, 'a'), old(64, 'b');
  const std::string toml = "# mine\nname = \"n\"\nfile = \"n.onnx\"  # the network\nlabels = \"l.txt\"\n";
  EXPECT_EQ(withInt8(toml, "n-int8.onnx", digest, "model.toml"),
            "# mine\nname = \"n\"\nfile = \"n.onnx\"  # the network\nint8 = \"n-int8.onnx\"\nlabels = "
            "\"l.txt\"\n\n[sha256]\n\"n-int8.onnx\" = \"" +
                digest + "\"\n");
  const std::string twice =
      withInt8(withInt8(toml, "n-int8.onnx", old, "model.toml"), "n-int8.onnx", digest, "m");
  EXPECT_EQ(twice, withInt8(toml, "n-int8.onnx", digest, "model.toml"));
  EXPECT_THAT([&] { withInt8("name = \"n\"\n", "n-int8.onnx", digest, "model.toml"); },
              FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::convert
