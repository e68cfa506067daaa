// Networks and their words: models that are fetched, what runs them, labels that are paid for once.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/json_of.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/label/catalog.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ModelsGet : public testing::Test {
 protected:
  ModelsGet() {
    withoutProxy();
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  /// Writes a catalog of the model `small`, whose network and labels are at these addresses.
  void list(const std::string& networkUrl, const std::string& labelsUrl) const {
    writeFile(scratch_ / "home/catalog.toml",
              "[labels.four]\ncount = 4\nurls = [\"" + labelsUrl + "\"]\nsha256 = \"" +
                  sha256(labelLines(4)) +
                  "\"\n[models.small]\nabout = \"a test\"\nlicense = \"MIT\"\nsource = \"here\"\n"
                  "labels = \"four\"\n[[models.small.files]]\nname = \"small.onnx\"\nurls = [\"" +
                  networkUrl + "\"]\nsha256 = \"" + sha256(network_) +
                  "\"\n[models.small.model]\nfile = \"small.onnx\"\ninput = 8\ncolor = \"BGR\"\n");
  }

  ScratchFolder scratch_;
  const std::string network_ = smallOnnx(8, 4);
};

TEST_F(ModelsGet, ListsWhatCanBeHad) {
  const auto printed = run({"models", "catalog", "--json"});
  const json first = json::parse(printed.out.substr(0, printed.out.find('\n')));
  EXPECT_EQ(first["name"], "clip-vit-b32");
  EXPECT_EQ(first["by_hand"], true);
  EXPECT_EQ(first["installed"], false);
  EXPECT_THAT(run({"models", "get", "resnet"}), FailsWith(ErrorCode::unknownName));
}

TEST_F(ModelsGet, SaysWhatToDoWithoutANetwork) {
  list("http://host.invalid/small.onnx", "http://host.invalid/labels");
  EXPECT_THAT(run({"models", "get", "small"}), FailsWith(ErrorCode::network));
  writeFile(downloadFolder("small") / "small.onnx", network_);
  writeFile(downloadFolder("small") / "four.list", labelLines(4));
  EXPECT_EQ(jsonOf(run({"models", "get", "small", "--json"}))["labels"], 4);
  EXPECT_EQ(json::parse(run({"models", "list", "--json"}).out)["name"], "small");
}

TEST_F(ModelsGet, FetchesAGroupGoesOnBehindWhatCannotBeHadAndSkipsWhatIsThere) {
  int asked = 0;
  LoopbackServer server([&](const HttpRequest& request) {
    ++asked;
    return request.path == "/small.onnx" ? HttpAnswer{rangeAnswer(request, network_)}
           : request.path == "/labels"   ? HttpAnswer{rangeAnswer(request, labelLines(4))}
                                         : HttpAnswer{httpAnswer("404 Not Found", "")};
  });
  list(server.url("/none.onnx") + "\", \"" + server.url("/small.onnx"), server.url("/labels"));
  const std::string file = scratch_ / "home/catalog.toml";
  std::string text = readFile(file), missing = text.substr(text.find("[models.small]"));
  for (std::size_t at = 0; (at = missing.find("small", at)) != std::string::npos;)
    missing.replace(at, 5, "early");
  missing.replace(missing.find("/early.onnx"), 11, "/lost.onnx");
  text += missing;
  for (const std::string about : {"[models.small]\n", "[models.early]\n"})
    text.insert(text.find(about) + about.size(), "group = \"pair\"\n");
  writeFile(file, text);
  const auto fetched = run({"models", "get", "pair"});
  EXPECT_THAT(fetched, FailsWith(ErrorCode::network));
  EXPECT_TRUE(fetched.out.starts_with("small: works; 4 labels")) << fetched.out << fetched.err;
  asked = 0;
  EXPECT_THAT(run({"models", "get", "pair"}), FailsWith(ErrorCode::network));
  EXPECT_EQ(asked, 2) << "the two addresses of the one that is missing, not the other again";
}

class EngineCommand : public testing::Test {
 protected:
  void SetUp() override {
    ESTANCIA_NEEDS(findOnnxruntime(), "ONNX Runtime is missing; run script/bootstrap and build again");
    writeSmallModel(model_);
  }
  void TearDown() override { unsetenv("ESTANCIA_ONNXRUNTIME"); }

  static void useLibrary(const std::string& path) { setenv("ESTANCIA_ONNXRUNTIME", path.c_str(), 1); }

  ScratchFolder scratch_;
  const std::string model_ = scratch_ / "model";
};

TEST_F(EngineCommand, TakesEitherEngineAndAnyThreads) {
  EXPECT_NE(run({"models", "list"}).out.find("onnxruntime, opencv"), std::string::npos);
  for (const std::string engine : {"onnxruntime", "opencv"}) {
    const auto checked = run({"models", "check", model_, "--engine", engine, "--threads", "1"});
    EXPECT_EQ(checked.exitCode, 0) << checked.err;
    EXPECT_EQ(checked.err, "");
  }
  EXPECT_THAT(run({"models", "check", model_, "--engine", "abacus"}), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(run({"models", "check", model_, "--threads", "-1"}), FailsWith(ErrorCode::invalidOption));
}

TEST_F(EngineCommand, OpencvStepsInWhereOnnxruntimeCannotBeUsed) {
  writeFile(scratch_ / "broken.so", "this is no library");
  for (const std::string& library :
       {std::string(scratch_ / "nowhere.so"), std::string(scratch_ / "broken.so"), scratch_.path().string(),
        std::string(ESTANCIA_OLD_ONNXRUNTIME)}) {
    useLibrary(library);
    EXPECT_EQ(run({"models", "list"}).out.find("onnxruntime, opencv"), std::string::npos) << library;
    EXPECT_EQ(run({"models", "check", model_}).exitCode, 0) << library;
    EXPECT_THAT(run({"models", "check", model_, "--engine", "onnxruntime"}),
                FailsWith(ErrorCode::missingDependency));
  }
}

TEST_F(EngineCommand, ConvertsNetworks) {
  const std::string output = scratch_ / "out.onnx";
  const auto summary = jsonOf(run({"models", "convert", model_, "-o", output, "--json"}));
  EXPECT_EQ(summary["inputs"]["input"], (std::vector<int>{1, 3, 8, 8}));
  EXPECT_EQ(summary["outputs"]["probabilities"], (std::vector<int>{1, 4}));
  EXPECT_EQ(summary["operator_set"], 10);
  EXPECT_EQ(readFile(output), smallOnnx(8, 4));
  EXPECT_THAT(run({"models", "convert", output, "-o", output}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(run({"models", "convert", output, "-o", output, "--overwrite"}).exitCode, 0);
}

class Labeling : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ESTANCIA_CACHE", (scratch_ / "cache").c_str(), 1);
    writeSmallModel(model_);
    fs::create_directories(images_);
    cv::RNG random(3);
    for (int i = 0; i < 24; ++i) {
      cv::Mat image(48, 64, CV_8UC3, cv::Scalar(i / 6 * 60, 230 - i / 6 * 60, 20 + i / 6 * 50));
      cv::Mat noise(image.size(), CV_8UC3);
      random.fill(noise, cv::RNG::UNIFORM, 0, 8);
      cv::imwrite(fs::path(images_) / ("frame" + std::to_string(10 + i) + ".png"), image + noise);
    }
  }
  void TearDown() override { unsetenv("ESTANCIA_CACHE"); }

  json label(const std::string& sequence, const std::string& file, std::vector<std::string> more = {}) {
    if (fs::is_directory(sequence)) more.insert(more.end(), {"--model", model_});
    return jsonOf(run({"label", sequence, "-o", file, "--json"}, more));
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string model_ = scratch_ / "model";
  const std::string images_ = scratch_ / "images";
};

TEST_F(Labeling, PrintsTheBestWordsOfAnImage) {
  const std::string image = fs::path(images_) / "frame10.png";
  const auto text = run({"label", image, "--model", model_, "--words", "2"});
  EXPECT_EQ(text.exitCode, 0) << text.err;
  EXPECT_EQ(std::ranges::count(text.out, '\n'), 3) << text.out;
  EXPECT_TRUE(text.out.starts_with("frame10.png:\n  0.")) << text.out;
  const auto shown = json::parse(run({"label", image, "--model", model_, "--json"}).out);
  EXPECT_EQ(shown["image"], "frame10.png");
  EXPECT_GE(shown["labels"][0]["probability"], shown["labels"][1]["probability"]);
  const auto all = run({"label", images_, "--model", model_, "--words", "1"});
  EXPECT_EQ(std::ranges::count(all.out, '\n'), 24) << "a line an image";
  EXPECT_THAT(run({"label", image, "--words", "2", "-o", scratch_ / "a.labels"}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(Labeling, ASecondRunLabelsNothing) {
  EXPECT_EQ(label(images_, scratch_ / "a.labels")["remembered"], 0);
  EXPECT_EQ(label(images_, scratch_ / "b.labels")["remembered"], 24);
  EXPECT_EQ(readFile(scratch_ / "a.labels"), readFile(scratch_ / "b.labels")) << "to the last bit";
  EXPECT_EQ(label(images_, scratch_ / "c.labels", {"--no-cache"})["remembered"], 0);

  const auto shown = json::parse(run({"cache", "show", "--json"}).out);
  EXPECT_EQ(shown["models"][0]["frames"], 24);
  EXPECT_GT(json::parse(run({"cache", "clear", "--json"}).out)["freed"], 24 * 4 * 4);
  EXPECT_EQ(label(images_, scratch_ / "d.labels")["remembered"], 0);
}

TEST_F(Labeling, ALabelFileStandsForItsImagesInEveryCommand) {
  const std::string words = scratch_ / "words.labels", fromWords = scratch_ / "w.estancia",
                    fromImages = scratch_ / "i.estancia";
  label(images_, words);
  ASSERT_EQ(run({"map", words, "-o", fromWords, "--distance", "l2"}).exitCode, 0);
  ASSERT_EQ(run({"map", images_, "-o", fromImages, "--model", model_, "--distance", "l2"}).exitCode, 0);
  EXPECT_EQ(run({"export", fromWords, "--format", "json"}).out,
            run({"export", fromImages, "--format", "json"}).out);
  const auto byWords = run({"localize", fromImages, words});
  const auto byImages = run({"localize", fromImages, images_, "--model", model_});
  EXPECT_EQ(byWords.exitCode, 0) << byWords.err;
  EXPECT_EQ(byWords.out, byImages.out);
  EXPECT_EQ(run({"evaluate", fromWords, words}).exitCode, 0);
  EXPECT_EQ(run({"report", fromWords, "-o", scratch_ / "w.html"}).exitCode, 0) << "without images";
  EXPECT_THAT(run({"map", words, "-o", scratch_ / "x.estancia", "--model", model_}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(Labeling, CsvAndNpyGoOutAndComeBack) {
  label(images_, scratch_ / "words.labels");
  for (const std::string kind : {"csv", "npy"}) {
    const std::string out = scratch_ / ("words." + kind);
    const json written = label(scratch_ / "words.labels", out);
    EXPECT_EQ(written["frames"], 24);
    EXPECT_EQ(written["remembered"], 0) << "a recording is no memory of ours";
    ASSERT_EQ(run({"map", out, "-o", scratch_ / (kind + ".estancia"), "--distance", "l2"}).exitCode, 0);
    EXPECT_EQ(label(out, scratch_ / (kind + ".labels"))["words"], 4);
    // A second recording of the same words is found in the map of the first.
    EXPECT_EQ(run({"localize", scratch_ / (kind + ".estancia"), out}).exitCode, 0);
  }
  EXPECT_THAT(run({"label", images_, "-o", scratch_ / "words.txt", "--model", model_}),
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(run({"label", images_, "-o", scratch_ / "words.labels", "--model", model_}),
              FailsWith(ErrorCode::fileExists));
}

}  // namespace
}  // namespace estancia::test
