// model.toml, the model home, choice by name.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "estancia/core/digest.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_files.hpp"
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
  EXPECT_EQ(spec.name, "n-1.0");
  EXPECT_EQ(spec.type, "opencv");
  EXPECT_EQ(spec.file, "net.caffemodel");
  EXPECT_EQ(spec.config, "net.prototxt");
  EXPECT_EQ(spec.labels, "words/labels.txt");
  EXPECT_EQ(spec.output, "prob");
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
  EXPECT_EQ(spec.license, "MIT");
  EXPECT_EQ(spec.source, "somewhere");
  EXPECT_EQ(spec.sha256.at("net.caffemodel").substr(0, 8), "e3b0c442") << "in lower case";
}

TEST_F(ModelToml, ChecksEveryValue) {
  for (const std::string line : {"name = \"../n\"",
                                 "name = \".hidden\"",
                                 "input = 0",
                                 "input = 5000",
                                 "input = \"224\"",
                                 "crop = 0",
                                 "crop = 1.1",
                                 "scale = 0",
                                 "scale = [1, 2]",
                                 "mean = [1, 2, inf]",
                                 "softmax = 1",
                                 "sigmoid = true\nsoftmax = true",
                                 "reduce = \"mean\"",
                                 "anchors = [0]",
                                 "unused = [-1]",
                                 "unused = [4, 2, 4]",
                                 "input_node = 1",
                                 "color = \"rgb\"",
                                 "sha256 = {\"n.onnx\" = \"12\"}",
                                 "sha256 = {\"../n.onnx\" = \"12\"}",
                                 "sofmax = true",
                                 "file = \"/etc/passwd\"",
                                 "file = \"../x.onnx\"",
                                 "file = \"a/../../x.onnx\"",
                                 "labels = \"\"",
                                 "config = \"..\""}) {
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
    if (const char* before = std::getenv("ESTANCIA_HOME")) before_ = before;
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

  test::ScratchFolder scratch_;
  std::string before_;
};

TEST_F(ModelHome, AddedModelsAreFoundByName) {
  const auto check = addModel(scratch_ / "given");
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

TEST_F(ModelHome, AddsOnlyTheFilesOfTheModel) {
  writeFile(scratch_ / "given/private.txt", "no");
  addModel(scratch_ / "given");
  EXPECT_FALSE(fs::exists(modelHome() / "small/private.txt"));
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
  EXPECT_EQ(loadModel((scratch_ / "given").string())->identity(), "fixed");
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

}  // namespace
}  // namespace estancia
