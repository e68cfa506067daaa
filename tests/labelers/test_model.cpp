// model.toml, the model home, choice by name, and ONNX files as they are handed to the engines.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "estancia/core/digest.hpp"
#include "estancia/core/home.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;

class ModelToml : public testing::Test {
 protected:
  ModelSpec read(const std::string& toml) {
    writeFile(scratch_ / "model.toml", toml);
    return readModelSpec(scratch_.path());
  }
  test::Caught refusal(const std::string& toml) {
    return test::caught([&] { read(toml); });
  }
  /// A complete file in which `line` replaces the key's line, or is line 6.
  static std::string with(const std::string& line) {
    const std::string key = line.substr(0, line.find(' '));
    std::string toml;
    bool replaced = false;
    for (const std::string own :
         {"name = \"n\"", "file = \"n.onnx\"", "labels = \"l.txt\"", "input = 224", "color = \"RGB\""}) {
      const bool same = own.starts_with(key + " ");
      replaced |= same;
      toml += (same ? line : own) + "\n";
    }
    return toml + (replaced ? "" : line) + "\n";
  }
  test::ScratchFolder scratch_;
};

TEST_F(ModelToml, ReadsAllKeys) {
  const auto spec = read(R"(
name = "n-1.0"
type = "opencv"
file = "net.caffemodel"
config = "net.prototxt"
labels = "words/labels.txt"
output = "prob"
input = [320, 240]
region = "stretch"
crop = 0.5
resize = "cubic"
color = "BGR"
mean = [1, 2.5, 3]
scale = 2
sigmoid = true
reduce = "max"
anchors = [3, 1]
unused = [7, 0]
license = "MIT"
source = "somewhere"
[sha256]
"net.caffemodel" = "E3B0C44298FC1C149AFBF4C8996FB92427AE41E4649B934CA495991B7852B855"
)");
  EXPECT_THAT((std::vector<std::string>{spec.name, spec.type, spec.file, spec.config, spec.labels,
                                        spec.output, spec.license, spec.source}),
              ElementsAre("n-1.0", "opencv", "net.caffemodel", "net.prototxt", "words/labels.txt", "prob",
                          "MIT", "somewhere"));
  const auto& pre = spec.preprocessing;
  EXPECT_EQ(pre.width, 320);
  EXPECT_EQ(pre.height, 240);
  EXPECT_EQ(pre.region, Preprocessing::Region::stretch);
  EXPECT_EQ(pre.crop, 0.5);
  EXPECT_EQ(pre.resize, Preprocessing::Resize::cubic);
  EXPECT_EQ(pre.color, Preprocessing::Color::bgr);
  EXPECT_THAT(pre.mean, ElementsAre(1, 2.5, 3));
  EXPECT_THAT(pre.scale, ElementsAre(2, 2, 2));
  EXPECT_FALSE(spec.softmax);
  EXPECT_TRUE(spec.sigmoid);
  EXPECT_EQ(spec.reduce, ModelSpec::Reduce::max);
  EXPECT_THAT(spec.anchors, ElementsAre(3, 1));
  EXPECT_THAT(spec.unused, ElementsAre(0, 7));
  EXPECT_EQ(spec.sha256.at("net.caffemodel").substr(0, 8), "e3b0c442") << "in lower case";
}

TEST_F(ModelToml, ChecksEveryValue) {
  std::istringstream lines(
      R"(name = "../n"|name = ".hidden"|input = 0|input = 5000|input = "224"|input = [1, 2, 3]|crop = 0|crop = 1.1|)"
      R"(scale = 0|scale = [1, 2]|mean = [1, 2, inf]|softmax = 1|sigmoid = true;softmax = true|reduce = "mean"|)"
      R"(anchors = [0]|anchors = []|unused = [-1]|unused = [4, 2, 4]|input_node = 1|color = "rgb"|sofmax = true|)"
      R"(sha256 = {"n.onnx" = "12"}|sha256 = {"../n.onnx" = "12"}|sha256 = 3|int8 = "n.tflite"|int8 = "n.onnx"|)"
      R"(file = "/etc/passwd"|file = "../x.onnx"|file = "a/../../x.onnx"|file = ""|labels = ""|config = "..")");
  for (std::string line; std::getline(lines, line, '|');) {
    std::ranges::replace(line, ';', '\n');
    EXPECT_THAT(refusal(with(line)), FailsWith(ErrorCode::malformedFile)) << line;
  }
  for (const std::string toml :
       {"name = \"n\"\nfile = \"f.onnx\"\ninput = 2\ncolor = \"RGB\"", "name = \"n\"\nfile = \n"})
    EXPECT_THAT(refusal(toml), FailsWith(ErrorCode::malformedFile)) << toml;
}

/// The texts of this room that users depend on: what is wrong, where, and what to do.
TEST_F(ModelToml, ErrorsNameTheLineTheValueAndTheWayOut) {
  setenv("ESTANCIA_HOME", scratch_.path().c_str(), 1);
  const auto missing = [] { loadModel("resnet"); };
  const std::pair<test::Caught, std::vector<std::string>> texts[] = {
      {refusal(with("sofmax = true")), {"model.toml:6: ", "`sofmax`", "scale, softmax"}},
      {refusal(with("color = \"rgb\"")), {"`color`", "\"RGB\", \"BGR\""}},
      {test::caught(missing), {"\"resnet\"", "estancia models add"}},
      {test::caught([&] { readModelSpec(scratch_ / "nothing"); }), {"nothing", "model.toml"}}};
  for (const auto& [caught, facts] : texts)
    for (const std::string& fact : facts) EXPECT_THAT(caught.message, testing::HasSubstr(fact));
  unsetenv("ESTANCIA_HOME");
}

/// A model home of the test's own.
class ModelHome : public testing::Test {
 protected:
  ModelHome() {
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
    test::writeSmallModel(scratch_ / "given");
  }
  ~ModelHome() override {
    before_.empty() ? unsetenv("ESTANCIA_HOME") : setenv("ESTANCIA_HOME", before_.c_str(), 1);
  }

  std::vector<std::string> entriesOfHome() const {
    std::vector<std::string> names;
    if (!fs::exists(modelHome())) return names;
    for (const auto& entry : fs::directory_iterator(modelHome())) names.push_back(entry.path().filename());
    return names;
  }

  const std::string before_ = environment("ESTANCIA_HOME");
  test::ScratchFolder scratch_;
};

TEST_F(ModelHome, AddedModelsAreFoundByName) {
  writeFile(scratch_ / "given/private.txt", "no");
  const auto check = addModel(scratch_ / "given");
  EXPECT_FALSE(fs::exists(modelHome() / "small/private.txt")) << "only the files of the model";
  EXPECT_EQ(check.spec.folder, modelHome() / "small");
  EXPECT_EQ(check.labels, 4U);
  EXPECT_GT(check.millisecondsPerImage, 0);
  EXPECT_GT(check.bestProbability, 0.25);
  EXPECT_THAT(entriesOfHome(), ElementsAre("small"));
  fs::remove_all(scratch_ / "given");
  EXPECT_EQ(loadModel("small")->identity(), check.identity);
  ASSERT_EQ(installedModels().size(), 1U);
  EXPECT_EQ(installedModels()[0].spec->name, "small");
  EXPECT_THAT([] { loadModel("smal"); }, FailsWith(ErrorCode::unknownName));
}

TEST_F(ModelHome, KeepsTheOldModelUnlessToldToReplaceIt) {
  addModel(scratch_ / "given");
  EXPECT_THAT([&] { addModel(scratch_ / "given"); }, FailsWith(ErrorCode::fileExists));
  test::writeSmallModel(scratch_ / "given", "crop = 0.5");
  addModel(scratch_ / "given", true);
  EXPECT_EQ(readModelSpec(modelHome() / "small").preprocessing.crop, 0.5);
  EXPECT_THAT(entriesOfHome(), ElementsAre("small"));
}

TEST_F(ModelHome, StaysAsItWasWhenAModelDoesNotWork) {
  writeFile(scratch_ / "given/labels.txt", "one\n");
  EXPECT_THAT([&] { addModel(scratch_ / "given"); }, FailsWith(ErrorCode::mismatch));
  EXPECT_TRUE(entriesOfHome().empty());
}

TEST_F(ModelHome, ListsABrokenModelWithItsProblem) {
  EXPECT_TRUE(installedModels().empty());
  writeFile(modelHome() / "broken/model.toml", "name = 3");
  const auto models = installedModels();
  ASSERT_EQ(models.size(), 1U);
  EXPECT_FALSE(models[0].spec);
  EXPECT_NE(models[0].problem, "");
}

TEST_F(ModelHome, RefusesWhatIsNoModel) {
  EXPECT_THAT([] { loadModel("resnet"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { addModel(scratch_ / "given/small.onnx"); }, FailsWith(ErrorCode::invalidInput));
  writeFile(scratch_ / "home", "no folder");
  EXPECT_THAT([&] { addModel(scratch_ / "given"); }, FailsWith(ErrorCode::fileUnwritable));
  fs::remove(scratch_ / "home");
  fs::create_directory(scratch_ / "home");
  EXPECT_THAT([&] { loadModel((scratch_ / "home").string()); }, FailsWith(ErrorCode::fileNotFound));
  test::writeSmallModel(scratch_ / "given", "type = \"quantum\"");
  EXPECT_THAT([&] { loadModel((scratch_ / "given").string()); }, FailsWith(ErrorCode::unknownName));
}

TEST_F(ModelHome, OpensTypesThatAreRegistered) {
  class Fixed final : public Labeler {
   public:
    const Vocabulary& vocabulary() const override { return vocabulary_; }
    std::string identity() const override { return "fixed"; }
    Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
    LexicalDescriptor infer(const Prepared&) override { return {1}; }

   private:
    Vocabulary vocabulary_{{"thing"}};
  };
  registerLabelerType("fixed",
                      [](const ModelSpec&, const LabelerOptions&) { return std::make_unique<Fixed>(); });
  EXPECT_THAT(labelerTypes(), testing::Contains("fixed"));
  test::writeSmallModel(scratch_ / "given", "type = \"fixed\"");
  const auto fixed = loadModel((scratch_ / "given").string());
  EXPECT_EQ(fixed->identity(), "fixed");
  EXPECT_THAT([&] { fixed->adopt({}); }, FailsWith(ErrorCode::invalidState)) << "it discovers no words";
  EXPECT_THAT([&] { fixed->combine({}); }, FailsWith(ErrorCode::invalidState)) << "it has no members";
  writeFile(scratch_ / "given/words/own.txt", "kept with it");
  EXPECT_GT(addModel(scratch_ / "given").millisecondsPerImage, 0);
  EXPECT_TRUE(fs::exists(modelHome() / "small/words/own.txt")) << "what such a model needs is not known";
}

TEST(FetchedModels, AreThoseThatTheProjectDescribes) {
  for (const auto& [name, labels] :
       {std::pair<std::string, std::size_t>{defaultModel, 1001}, {"coco-ssd", 80}}) {
    const auto folder = test::findFetched("models/" + name);
    ESTANCIA_NEEDS(folder, "a network is missing; run script/bootstrap");
    const auto check = checkModel(folder->string());
    EXPECT_EQ(check.spec.name, name);
    EXPECT_EQ(check.labels, labels);
    EXPECT_EQ(check.digests, 2U);
    EXPECT_EQ(test::readFile(fs::path(ESTANCIA_SOURCE_DIR) / "models" / name / "model.toml"),
              test::readFile(*folder / "model.toml"));
  }
}

class OnnxFile : public testing::Test {
 protected:
  std::string read(const std::string& bytes, int side, const std::string& output = "") const {
    test::writeFile(scratch_ / "net.onnx", bytes);
    ModelSpec spec;
    spec.folder = scratch_.path();
    spec.file = "net.onnx";
    spec.output = output;
    spec.preprocessing.width = spec.preprocessing.height = side;
    return readOnnx(spec);
  }

  test::ScratchFolder scratch_;
};

TEST_F(OnnxFile, OfTheRightSizeIsLeftAsItIs) {
  const std::string good = test::smallOnnx(8, 4);
  EXPECT_EQ(read(good, 8), good);
  EXPECT_EQ(read(good, 0), good) << "0 asks for no size";
  EXPECT_THAT([&] { read(good, 9); }, test::FailsWith(ErrorCode::mismatch));
}

TEST_F(OnnxFile, OfAnySizeIsFixedAsProtobufWouldDoIt) {
  const auto any = [](onnx::GraphProto& graph) {
    graph.mutable_input(0)->set_doc_string("the image");
    auto* sizes = graph.mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
    sizes->mutable_dim(0)->clear_dim_value();
    sizes->mutable_dim(2)->set_dim_param("height");
    sizes->mutable_dim(2)->set_denotation("DATA_FEATURE");
    sizes->mutable_dim(3)->set_dim_value(-1);
    auto* old = graph.add_input();  // older files list weights among the inputs, too
    old->set_name("weights");
    old->mutable_type()->mutable_tensor_type()->mutable_shape()->add_dim()->set_dim_param("n");
  };
  const std::string bytes = test::smallOnnx(8, 4, any);
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(bytes));
  auto* sizes =
      model.mutable_graph()->mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
  const int fixed[] = {1, 3, 300, 300};
  for (int i = 0; i < 4; ++i) sizes->mutable_dim(i)->set_dim_value(fixed[i]);
  EXPECT_EQ(read(bytes, 300), model.SerializeAsString());
}

TEST_F(OnnxFile, GetsAnInnerValueAsAnotherOutput) {
  const std::string bytes = test::smallOnnx(8, 4);
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(bytes));
  auto* output = model.mutable_graph()->add_output();
  output->set_name("mean");
  output->mutable_type()->mutable_tensor_type()->set_elem_type(onnx::TensorProto::FLOAT);
  onnx::ModelProto ours;
  ASSERT_TRUE(ours.ParseFromString(read(bytes, 8, "mean")));
  EXPECT_EQ(ours.SerializeAsString(), model.SerializeAsString());
  EXPECT_EQ(read(bytes, 8, "probabilities"), bytes) << "is an output already";
  EXPECT_EQ(read(bytes, 8, "nothing"), bytes) << "the labeler will say what there is";
}

TEST_F(OnnxFile, OfAnyBytesIsReadOrRefused) {
  const std::string good = test::smallOnnx(8, 4);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ (1 << i % 8));
    refused += test::caught([&] { read(bad, 8); }).code ? 1 : 0;
    onnx::ModelProto model;
    const bool isModel = model.ParseFromString(good.substr(0, i)) && model.has_graph();
    EXPECT_EQ(test::caught([&] { read(good.substr(0, i), 8); }).code.has_value(), !isModel) << i;
  }
  EXPECT_GT(refused, good.size() / 10);
}

}  // namespace
}  // namespace estancia
