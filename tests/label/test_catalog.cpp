// The catalog itself, and models fetched by it from a server on this machine.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <sstream>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/label/catalog.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {
namespace fs = std::filesystem;

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;

Catalog builtin() {
  Catalog catalog;
  catalog.add("catalog.toml", builtinCatalog);
  return catalog;
}

TEST(BuiltinCatalog, SaysHowToUseEveryModel) {
  const test::ScratchFolder scratch;
  const Catalog catalog = builtin();
  for (const auto& [name, model] : catalog.models()) {
    SCOPED_TRACE(name);
    writeFile(scratch / name / "model.toml", model.modelToml);
    const ModelSpec spec = readModelSpec(scratch / name);
    EXPECT_EQ(spec.name, name);
    EXPECT_FALSE(spec.license.empty());
    EXPECT_EQ(spec.source.substr(0, 4), "http");
    EXPECT_FALSE(model.about.empty());
    EXPECT_GE(spec.preprocessing.width, 224);
    const auto& mean = spec.preprocessing.mean;
    EXPECT_THAT(mean, testing::Each(testing::AllOf(testing::Gt(90), testing::Lt(130))));
    const bool bgr = spec.preprocessing.color == Preprocessing::Color::bgr;
    EXPECT_EQ(mean[0] < mean[2], bgr) << "images have more red than blue: the mean's order is that of color";
  }
}

TEST(BuiltinCatalog, HasTheSevenNetworksOfTheThesis) {
  EXPECT_THAT(builtin().namesOf("thesis"),
              ElementsAre("hybrid-alexnet", "imagenet-alexnet", "imagenet-caffenet", "imagenet-googlenet",
                          "imagenet-vgg-cnn-s", "places205-alexnet", "places205-googlenet"));
  EXPECT_THAT(builtin().namesOf("resnet50"), ElementsAre("resnet50"));
}

TEST(CatalogFiles, AreRefusedWithAnyMistake) {
  const std::string good =
      "[labels.l]\ncount = 2\nurls = [\"https://h/l\"]\n"
      "[models.m]\nabout = \"a\"\nlicense = \"MIT\"\nsource = \"s\"\nlabels = \"l\"\n"
      "[[models.m.files]]\nname = \"n.onnx\"\nurls = [\"https://h/n\"]\n"
      "[models.m.model]\nfile = \"n.onnx\"\ninput = 8\ncolor = \"RGB\"\n";
  const auto refusal = [](const std::string& text) {
    return test::caught([&] { Catalog().add("own.toml", text); });
  };
  EXPECT_FALSE(refusal(good).code);
  const auto with = [&](const std::string& before, const std::string& after) {
    std::string text = good;
    const auto at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    return refusal(text.replace(at, before.size(), after));
  };
  std::istringstream mistakes(
      R"(count = 2 → count = 0|https://h/l → ftp://h/l|https://h/n → https:///n|https://h/n → https://h/n o|)"
      R"(https://h/n → file:///etc/passwd|"n.onnx" → "../n.onnx"|"n.onnx" → "model.toml"|"n.onnx" → "n.part"|)"
      R"(name = "n.onnx" → name = "o.onnx"|urls = ["https://h/n"] → sha1 = "12"|urls = ["https://h/l"] → |)"
      R"(urls = ["https://h/n"] → sha256 = "12"|urls = ["https://h/n"] → size = 5|license = "MIT" → |)"
      R"(labels = "l" → labels = "k"|labels = "l" → |[models.m.model] → x = 1;[models.m.model]|)"
      R"([models.m] → [models."../m"]|about = "a" → about = "a";group = "../g"|count = 2 → count = 2;words = "l"|count = 2 → count = 2;words = "none")");
  for (std::string line; std::getline(mistakes, line, '|');) {
    std::ranges::replace(line, ';', '\n');
    const std::string arrow = " → ", before = line.substr(0, line.find(arrow));
    const auto refused = with(before, line.substr(before.size() + arrow.size()));
    EXPECT_THAT(refused, FailsWith(ErrorCode::malformedFile)) << line;
  }
  EXPECT_THAT(refusal("models = 3"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("[models"), FailsWith(ErrorCode::malformedFile));
}

TEST(CatalogFiles, TellHowFarTheirDigestsArePublished) {
  for (std::size_t count = 1; count <= 9; ++count)
    for (std::size_t odd = 0; odd < count; ++odd)
      for (int of = 0; of < 4; ++of) {
        CatalogEntry model;
        model.files.resize(count);
        int least = 1, most = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const int digest = i == odd ? of / 2 : of % 2;
          model.files[i].remote.sha256 = digest > 0 ? "1" : "";
          least = std::min(least, digest);
          most = std::max(most, digest);
        }
        const char* expected = least == 1 ? "sha256" : most > 0 ? "partly" : "none";
        EXPECT_EQ(Catalog().checksums(model), expected) << odd << " of " << count << " is odd: " << of;
      }
}

LabelSet set(std::size_t count, bool numbered, const std::string& words = "") {
  LabelSet set;
  set.count = count;
  set.numbered = numbered;
  set.words = words;
  set.file.name = "list";
  return set;
}

TEST(LabelLists, AreReadAsPublishedOrRefused) {
  EXPECT_THAT(labelsOf(set(2, false), {"tench, Tinca tinca", "/a/kept 7"}, {}),
              ElementsAre("tench, Tinca tinca", "/a/kept 7"));
  EXPECT_THAT(
      labelsOf(set(3, true), {"/a/airfield 0", "/a/apartment_building/outdoor 1", "plain word 2"}, {}),
      ElementsAre("airfield", "apartment_building/outdoor", "plain word"));
  const std::vector<std::string> words{"n01440764 tench, Tinca tinca 0", "n01443537 goldfish 1", "/b/bar 2"};
  EXPECT_THAT(labelsOf(set(3, true), words, {}), ElementsAre("tench, Tinca tinca", "goldfish", "bar"));
  EXPECT_THAT(labelsOf(set(2, true, "w"), {"n01443537 0", "/a/abbey 1"}, words),
              ElementsAre("goldfish", "abbey"));
  const std::pair<LabelSet, std::vector<std::string>> cases[] = {{set(2, false), {"one"}},
                                                                 {set(2, true), {"a 0", "b 2"}},
                                                                 {set(1, true), {"<html>"}},
                                                                 {set(1, true, "w"), {"n01443537 0"}}};
  for (const auto& list : cases)
    EXPECT_THAT([&] { labelsOf(list.first, list.second, {}); }, FailsWith(ErrorCode::malformedFile));
}

/// A server with the small model, a catalog that lists it, and a home of the test's own.
class FetchModel : public testing::Test {
 protected:
  FetchModel() {
    test::withoutProxy();
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
    files_["/small.onnx"] = test::smallOnnx(8, 4);
    files_["/labels"] = test::labelLines(4);
    options_.download.pauseSeconds = 0;
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  test::HttpAnswer answer(const test::HttpRequest& request) {
    const auto found = files_.find(request.path);
    if (found == files_.end()) return {test::httpAnswer("404 Not Found", "")};
    return {test::rangeAnswer(request, found->second)};
  }
  std::string entry(const std::string& more = "") const {
    return "[labels.four]\ncount = 4\nurls = [\"" + server_.url("/labels") +
           "\"]\n[models.small]\nabout = \"a test\"\nlicense = \"MIT\"\nsource = \"here\"\nlabels = "
           "\"four\"\n"
           "[[models.small.files]]\nname = \"small.onnx\"\nurls = [\"" +
           server_.url("/small.onnx") + "\"]\n" + more +
           "[models.small.model]\nfile = \"small.onnx\"\ninput = 8\ncolor = \"BGR\"\n";
  }
  FetchedModel fetch(const std::string& catalog) {
    Catalog all;
    all.add("test.toml", catalog);
    return fetchModel(all, "small", options_);
  }
  test::Caught refusal(const std::string& catalog) {
    return test::caught([&] { fetch(catalog); });
  }

  test::ScratchFolder scratch_;
  std::map<std::string, std::string> files_;
  FetchOptions options_;
  test::LoopbackServer server_{[this](const test::HttpRequest& request) { return answer(request); }};
};

TEST_F(FetchModel, InstallsAModelThatWorksAndNoneOfTheWrongDigest) {
  EXPECT_THAT(refusal(entry("sha256 = \"" + std::string(64, '0') + "\"\n")), FailsWith(ErrorCode::network));
  EXPECT_TRUE(installedModels().empty());
  const auto model = fetch(entry("sha256 = \"" + sha256(files_["/small.onnx"]) + "\"\n"));
  EXPECT_EQ(model.check.labels, 4U);
  EXPECT_EQ(model.check.digests, 2U);
  EXPECT_EQ(loadModel("small")->vocabulary()[3], "word 3");
  const ModelSpec spec = readModelSpec(modelHome() / "small");
  EXPECT_EQ(spec.license, "MIT");
  EXPECT_EQ(spec.source, "here");
  EXPECT_FALSE(fs::exists(downloadFolder("small")));
  EXPECT_EQ(model.notes.size(), 1U) << "nobody vouches for the labels";
}

TEST_F(FetchModel, TellsOfFilesThatNobodyVouchesFor) {
  EXPECT_EQ(fetch(entry()).notes.size(), 2U) << "one for the network, one for its labels";
  writeFile(modelHome() / "small/small.onnx",
            test::smallOnnx(8, 4, [](onnx::GraphProto& graph) { graph.set_name("another"); }));
  EXPECT_THAT([] { loadModel("small"); }, FailsWith(ErrorCode::corruptFile))
      << "what came is what it must stay";
}

TEST_F(FetchModel, TakesTheWordsOfNumberedLabelsFromAnotherList) {
  files_["/labels"] = "n01440764 0\n/a/abbey 1\nn01443537 2\n/b/bar 3\n";
  files_["/words"] = "n01440764 tench, Tinca tinca 0\nn01443537 goldfish 1\n\n";
  std::string text = entry();
  text.replace(text.find("count = 4\n"), 10, "count = 4\nnumbered = true\nwords = \"w\"\n");
  fetch("[labels.w]\ncount = 2\nurls = [\"" + server_.url("/words") + "\"]\n" + text);
  EXPECT_THAT(loadModel("small")->vocabulary().labels(),
              ElementsAre("tench, Tinca tinca", "abbey", "goldfish", "bar"));
}

TEST_F(FetchModel, KeepsTheOldModelUnlessToldToReplaceIt) {
  fetch(entry());
  const auto asked = server_.requests().size();
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(server_.requests().size(), asked) << "nothing is fetched in vain";
  options_.replace = true;
  fetch(entry());
  EXPECT_EQ(installedModels().size(), 1U);
}

TEST_F(FetchModel, FetchesAnewWhatDoesNotWorkWhenAsked) {
  const std::string good = files_["/small.onnx"];
  files_["/small.onnx"] = "<html>log in to this network</html>";
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile));
  EXPECT_TRUE(installedModels().empty());
  files_["/small.onnx"] = good;
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile)) << "it is still the file of before";
  options_.refetch = true;
  EXPECT_FALSE(refusal(entry()).code);
}

TEST_F(FetchModel, RefusesALabelListThatIsNotWhatItWas) {
  files_["/labels"] = "<html>\n";
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile));
  files_["/labels"].resize(20'000'000, 'x');
  options_.refetch = true;
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::network));
}

TEST_F(FetchModel, AsksForWhatOnlyTheUserCanMakeBeforeItDownloads) {
  const std::string byHand =
      entry("[[models.small.files]]\nname = \"words.npy\"\nby_hand = \"make it so\"\n");
  const fs::path place = downloadFolder("small") / "words.npy";
  EXPECT_THAT(refusal(byHand), FailsWith(ErrorCode::fileNotFound));
  EXPECT_TRUE(server_.requests().empty());
  writeFile(place, "anything");
  options_.refetch = true;
  EXPECT_FALSE(refusal(byHand).code);
  EXPECT_FALSE(readModelSpec(modelHome() / "small").sha256.contains("words.npy")) << "free to change";
}

TEST_F(FetchModel, TakesFilesOutOfArchivesAndTriesTheNextWhenTheyAreNotInOne) {
  writeFile(scratch_ / "in/deep/net.onnx", files_["/small.onnx"]);
  writeFile(scratch_ / "other/readme", "no network here");
  for (const std::string folder : {"in", "other"}) {
    const std::string archive = scratch_ / (folder + ".tar.gz");
    ASSERT_EQ(test::runProgram("tar", {"-C", scratch_ / folder, "-czf", archive, "."}).exitCode, 0);
    files_["/" + folder + ".tar.gz"] = test::readFile(archive);
  }
  files_["/page.tar.gz"] = "<html>log in to this network</html>";
  const std::string text = entry("member = \"net.onnx\"\n"), old = "\"" + server_.url("/small.onnx") + "\"";
  const auto from = [&](const std::vector<std::string>& paths) {
    std::string list;
    for (const auto& path : paths) list += "\"" + server_.url(path) + "\",";
    return std::string(text).replace(text.find(old), old.size(), list);
  };
  EXPECT_THAT(refusal(from({"/other.tar.gz", "/none.tar.gz"})), FailsWith(ErrorCode::network));
  EXPECT_FALSE(refusal(from({"/page.tar.gz", "/other.tar.gz", "/in.tar.gz"})).code);
  EXPECT_EQ(installedModels().size(), 1U);
}

TEST_F(FetchModel, KnowsTheUsersOwnCatalog) {
  EXPECT_FALSE(Catalog::load().models().contains("small"));
  EXPECT_THAT([] { Catalog::load().get("small"); }, FailsWith(ErrorCode::unknownName));
  writeFile(scratch_ / "home/catalog.toml", entry());
  EXPECT_EQ(Catalog::load().get("small").about, "a test");
  writeFile(scratch_ / "home/catalog.toml", "[models.small]\n");
  EXPECT_THAT([] { Catalog::load(); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia
