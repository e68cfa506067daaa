// Choosing what runs the networks, as a user does.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;

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
    const auto wanted = run({"models", "check", model_, "--engine", "onnxruntime"});
    EXPECT_THAT(wanted, FailsWith(ErrorCode::missingDependency));
  }
  EXPECT_THAT(run({"models", "check", model_, "--engine", "onnxruntime"}),
              FailsWith(ErrorCode::missingDependency));
}

TEST_F(EngineCommand, ConvertsNetworks) {
  const std::string output = scratch_ / "out.onnx";
  const auto converted = run({"models", "convert", model_, "-o", output, "--json"});
  ASSERT_EQ(converted.exitCode, 0) << converted.err;
  const auto summary = json::parse(converted.out);
  EXPECT_EQ(summary["inputs"]["input"], (std::vector<int>{1, 3, 8, 8}));
  EXPECT_EQ(summary["outputs"]["probabilities"], (std::vector<int>{1, 4}));
  EXPECT_EQ(summary["operator_set"], 10);
  EXPECT_EQ(readFile(output), smallOnnx(8, 4));
  EXPECT_THAT(run({"models", "convert", output, "-o", output}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(run({"models", "convert", output, "-o", output, "--overwrite"}).exitCode, 0);
}

}  // namespace
}  // namespace estancia::test
