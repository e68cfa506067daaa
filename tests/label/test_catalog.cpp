// The catalog itself, and models fetched by it from a server on this machine.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <cstdlib>

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
using test::httpAnswer;
using test::HttpAnswer;
using test::HttpRequest;
using test::LoopbackServer;
using test::readFile;
using test::writeFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Catalog builtin() {
  Catalog catalog;
  catalog.add("catalog.toml", builtinCatalog);
  return catalog;
}

TEST(BuiltinCatalog, HasTheSevenNetworksOfTheThesis) {
  const Catalog catalog = builtin();
  for (const char* name :
       {"imagenet-alexnet", "imagenet-caffenet", "imagenet-googlenet", "imagenet-vgg-cnn-s",
        "places205-alexnet", "places205-googlenet", "hybrid-alexnet"})
    EXPECT_NE(catalog.get(name).about.find("thesis"), std::string::npos) << name;
  EXPECT_EQ(catalog.labelSets().at("hybrid-1183").count, 1183U);
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

/// So that whoever adds an entry knows which files nobody vouches for.
TEST(BuiltinCatalog, ListsWhatHasNoChecksum) {
  std::vector<std::string> without;
  const Catalog catalog = builtin();
  const auto look = [&](const std::string& owner, const CatalogFile& file) {
    if (file.byHand.empty() && file.remote.sha256.empty() && file.remote.sha1.empty())
      without.push_back(owner + "/" + file.name);
  };
  for (const auto& [name, model] : catalog.models())
    for (const auto& file : model.files) look(name, file);
  for (const auto& [name, set] : catalog.labelSets()) look(name, set.file);
  EXPECT_THAT(without,
              testing::UnorderedElementsAre(
                  "imagenet-alexnet/deploy.prototxt", "imagenet-caffenet/deploy.prototxt",
                  "imagenet-googlenet/deploy.prototxt", "imagenet-vgg-cnn-s/VGG_CNN_S.caffemodel",
                  "imagenet-vgg-cnn-s/deploy.prototxt", "places205-alexnet/places205.caffemodel",
                  "places205-alexnet/deploy.prototxt", "places205-googlenet/places205.caffemodel",
                  "places205-googlenet/deploy.prototxt", "hybrid-alexnet/hybrid.caffemodel",
                  "hybrid-alexnet/deploy.prototxt", "places365-alexnet/alexnet_places365.caffemodel",
                  "places365-alexnet/deploy.prototxt", "places365-googlenet/googlenet_places365.caffemodel",
                  "places365-googlenet/deploy.prototxt", "places365-vgg16/vgg16_places365.caffemodel",
                  "places365-vgg16/deploy.prototxt", "hybrid1365-vgg16/vgg16_hybrid1365.caffemodel",
                  "hybrid1365-vgg16/deploy.prototxt", "places-205/", "hybrid-1183/", "hybrid-1365/"));
}

TEST(CatalogFiles, AreCheckedLineByLine) {
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
  EXPECT_THAT(with("count = 2", "count = 0"), FailsWith(ErrorCode::malformedFile, "own.toml:2: ", "`count`"));
  EXPECT_THAT(with("https://h/l", "ftp://h/l"),
              FailsWith(ErrorCode::malformedFile, "own.toml:3: ", "`urls`", "https://"));
  EXPECT_THAT(with("https://h/n", "https:///n"), FailsWith(ErrorCode::malformedFile, "own.toml:11: "));
  EXPECT_THAT(with("https://h/n", "https://h/n o"), FailsWith(ErrorCode::malformedFile, "own.toml:11: "));
  EXPECT_THAT(with("https://h/n", "file:///etc/passwd"),
              FailsWith(ErrorCode::malformedFile, "own.toml:11: "));
  EXPECT_THAT(with("\"n.onnx\"", "\"../n.onnx\""),
              FailsWith(ErrorCode::malformedFile, "own.toml:10: ", "../n.onnx"));
  EXPECT_THAT(with("\"n.onnx\"", "\"model.toml\""), FailsWith(ErrorCode::malformedFile, "model.toml"));
  EXPECT_THAT(with("name = \"n.onnx\"", "name = \"o.onnx\""),
              FailsWith(ErrorCode::malformedFile, "\"n.onnx\"", "`files`"));
  EXPECT_THAT(with("urls = [\"https://h/n\"]", "sha1 = \"12\""),
              FailsWith(ErrorCode::malformedFile, "`sha1`", "40"));
  EXPECT_THAT(with("urls = [\"https://h/n\"]", "sha256 = \"12\""),
              FailsWith(ErrorCode::malformedFile, "`sha256`", "64"));
  EXPECT_THAT(with("urls = [\"https://h/n\"]", "size = 5"),
              FailsWith(ErrorCode::malformedFile, "`urls`", "`by_hand`"));
  EXPECT_THAT(with("license = \"MIT\"\n", ""), FailsWith(ErrorCode::malformedFile, "`license`"));
  EXPECT_THAT(with("labels = \"l\"", "labels = \"k\""),
              FailsWith(ErrorCode::malformedFile, "m", "[labels.k]"));
  EXPECT_THAT(with("labels = \"l\"\n", ""), FailsWith(ErrorCode::malformedFile, "labels.txt"));
  EXPECT_THAT(with("[models.m.model]\n", "x = 1\n[models.m.model]\n"),
              FailsWith(ErrorCode::malformedFile, "`x`"));
  EXPECT_THAT(with("[models.m]\n", "[models.\"../m\"]\n"), FailsWith(ErrorCode::malformedFile, "../m"));
  EXPECT_THAT(with("count = 2\n", "count = 2\nwords = \"l\"\n"),
              FailsWith(ErrorCode::malformedFile, "own.toml", "[labels.l]"));
  EXPECT_THAT(refusal("models = 3"), FailsWith(ErrorCode::malformedFile, "own.toml:1: "));
  EXPECT_THAT(refusal("[models"), FailsWith(ErrorCode::malformedFile, "own.toml:1: "));
}

class LabelLists : public testing::Test {
 protected:
  static LabelSet set(std::size_t count, bool numbered, const std::string& words = "") {
    LabelSet set;
    set.count = count;
    set.numbered = numbered;
    set.words = words;
    set.file.name = "list";
    return set;
  }
};

TEST_F(LabelLists, AreReadAsPublished) {
  EXPECT_THAT(labelsOf(set(2, false), {"tench, Tinca tinca", "/a/kept 7"}, {}),
              ElementsAre("tench, Tinca tinca", "/a/kept 7"));
  EXPECT_THAT(
      labelsOf(set(3, true), {"/a/airfield 0", "/a/apartment_building/outdoor 1", "plain word 2"}, {}),
      ElementsAre("airfield", "apartment_building/outdoor", "plain word"));
  const std::vector<std::string> words{"n01440764 tench, Tinca tinca 0", "n01443537 goldfish 1", "/b/bar 2"};
  EXPECT_THAT(labelsOf(set(3, true), words, {}), ElementsAre("tench, Tinca tinca", "goldfish", "bar"));
  EXPECT_THAT(labelsOf(set(2, true, "w"), {"n01443537 0", "/a/abbey 1"}, words),
              ElementsAre("goldfish", "abbey"));
}

TEST_F(LabelLists, AreRefusedWhenTheyAreNotAsPublished) {
  EXPECT_THAT([] { labelsOf(set(2, false), {"one"}, {}); }, FailsWith(ErrorCode::malformedFile, "1", "2"));
  EXPECT_THAT(
      [] {
        labelsOf(set(2, true), {"a 0", "b 2"}, {});
      },
      FailsWith(ErrorCode::malformedFile, "list:2: "));
  EXPECT_THAT([] { labelsOf(set(1, true), {"<html>"}, {}); },
              FailsWith(ErrorCode::malformedFile, "list:1: "));
  EXPECT_THAT([] { labelsOf(set(1, true, "w"), {"n01443537 0"}, {}); },
              FailsWith(ErrorCode::malformedFile, "list:1: ", "n01443537"));
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

  HttpAnswer answer(const HttpRequest& request) {
    const auto found = files_.find(request.path);
    if (found == files_.end()) return {httpAnswer("404 Not Found", "")};
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
  LoopbackServer server_{[this](const HttpRequest& request) { return answer(request); }};
};

TEST_F(FetchModel, InstallsAModelThatWorks) {
  const auto model = fetch(entry("sha256 = \"" + sha256(files_["/small.onnx"]) + "\"\n"));
  EXPECT_EQ(model.check.labels, 4U);
  EXPECT_EQ(model.check.digests, 2U);
  EXPECT_EQ(loadModel("small")->vocabulary()[3], "word 3");
  const ModelSpec spec = readModelSpec(modelHome() / "small");
  EXPECT_EQ(spec.license, "MIT");
  EXPECT_EQ(spec.source, "here");
  EXPECT_FALSE(fs::exists(downloadFolder("small")));
  EXPECT_THAT(model.notes, ElementsAre(AllOf(HasSubstr("four.list"), HasSubstr(sha256(files_["/labels"])))));
}

TEST_F(FetchModel, TellsOfFilesThatNobodyVouchesFor) {
  const auto model = fetch(entry());
  EXPECT_THAT(model.notes,
              ElementsAre(AllOf(HasSubstr("small.onnx"), HasSubstr(sha256(files_["/small.onnx"]))),
                          HasSubstr("four.list")));
  writeFile(modelHome() / "small/small.onnx",
            test::smallOnnx(8, 4, [](onnx::GraphProto& graph) { graph.set_name("another"); }));
  EXPECT_THAT([] { loadModel("small"); }, FailsWith(ErrorCode::corruptFile, "small.onnx"))
      << "what came is what it must stay";
}

TEST_F(FetchModel, DoesNotInstallWhatHasTheWrongDigest) {
  EXPECT_THAT(refusal(entry("sha256 = \"" + std::string(64, '0') + "\"\n")),
              FailsWith(ErrorCode::network, "small.onnx", std::string(64, '0')));
  EXPECT_TRUE(installedModels().empty());
}

TEST_F(FetchModel, KeepsTheOldModelUnlessToldToReplaceIt) {
  fetch(entry());
  const auto asked = server_.requests().size();
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::fileExists, "--overwrite"));
  EXPECT_EQ(server_.requests().size(), asked) << "nothing is fetched in vain";
  options_.replace = true;
  fetch(entry());
  EXPECT_EQ(installedModels().size(), 1U);
}

TEST_F(FetchModel, UsesWhatTheUserHasFetchedByHand) {
  writeFile(downloadFolder("small") / "small.onnx", files_["/small.onnx"]);
  files_.erase("/small.onnx");
  fetch(entry());
  EXPECT_EQ(installedModels().size(), 1U);
}

TEST_F(FetchModel, FetchesAnewWhatDoesNotWorkWhenAsked) {
  const std::string good = files_["/small.onnx"];
  files_["/small.onnx"] = "<html>log in to this network</html>";
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile, "small.onnx", "--restart"));
  EXPECT_TRUE(installedModels().empty());
  files_["/small.onnx"] = good;
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile, "--restart"))
      << "it is still the file of before";
  options_.refetch = true;
  EXPECT_FALSE(refusal(entry()).code);
}

TEST_F(FetchModel, RefusesALabelListThatIsNotWhatItWas) {
  files_["/labels"] = "<html>\n";
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::malformedFile, "four", "1", "4"));
  files_["/labels"].resize(20'000'000, 'x');
  options_.refetch = true;
  EXPECT_THAT(refusal(entry()), FailsWith(ErrorCode::network, "16777216"));
}

TEST_F(FetchModel, AsksForWhatOnlyTheUserCanMakeBeforeItDownloads) {
  const std::string byHand =
      entry("[[models.small.files]]\nname = \"words.npy\"\nby_hand = \"make it so\"\n");
  const fs::path place = downloadFolder("small") / "words.npy";
  EXPECT_THAT(refusal(byHand), FailsWith(ErrorCode::fileNotFound, "make it so", place.string()));
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
    const std::string tar = "tar -C '" + (scratch_ / folder).string() + "' -czf '" +
                            scratch_.path().string() + "/" + folder + ".tar.gz' .";
    ASSERT_EQ(std::system(tar.c_str()), 0);
    files_["/" + folder + ".tar.gz"] = readFile(scratch_ / (folder + ".tar.gz"));
  }
  files_["/page.tar.gz"] = "<html>log in to this network</html>";
  std::string text = entry("member = \"net.onnx\"\n");
  const std::string old = "[\"" + server_.url("/small.onnx") + "\"]";
  const auto urls = [&](const std::vector<std::string>& paths) {
    std::string list;
    for (const auto& path : paths) list += "\"" + server_.url(path) + "\",";
    return std::string(text).replace(text.find(old), old.size(), "[" + list + "]");
  };
  EXPECT_THAT(refusal(urls({"/other.tar.gz", "/none.tar.gz"})),
              FailsWith(ErrorCode::network, "net.onnx", "404"));
  EXPECT_FALSE(refusal(urls({"/page.tar.gz", "/other.tar.gz", "/in.tar.gz"})).code);
  EXPECT_EQ(installedModels().size(), 1U);
}

TEST_F(FetchModel, FindsAMistakeInTheSettingsBeforeItDownloads) {
  std::string text = entry();
  text.replace(text.find("\"BGR\""), 5, "\"blue\"");
  EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile, "`color`"));
  EXPECT_TRUE(server_.requests().empty());
}

TEST_F(FetchModel, KnowsTheUsersOwnCatalog) {
  EXPECT_FALSE(Catalog::load().models().contains("small"));
  EXPECT_THAT([] { Catalog::load().get("small"); },
              FailsWith(ErrorCode::unknownName, "\"small\"", "clip-vit-b32, "));
  writeFile(scratch_ / "home/catalog.toml", entry());
  EXPECT_EQ(Catalog::load().get("small").about, "a test");
  writeFile(scratch_ / "home/catalog.toml", "[models.small]\n");
  EXPECT_THAT([] { Catalog::load(); }, FailsWith(ErrorCode::malformedFile, "home/catalog.toml"));
}

}  // namespace
}  // namespace estancia
