// `estancia models get` as a user runs it: what there is, and without a network.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "estancia/core/digest.hpp"
#include "estancia/label/catalog.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/model_support.hpp"

namespace estancia::test {
namespace {

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
  const auto offline = run({"models", "get", "small", "--json"});
  EXPECT_EQ(offline.exitCode, 0) << offline.err;
  EXPECT_EQ(json::parse(offline.out)["labels"], 4);
  EXPECT_EQ(json::parse(run({"models", "list", "--json"}).out)["name"], "small");
}

}  // namespace
}  // namespace estancia::test
