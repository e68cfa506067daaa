// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_stages.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::ScratchFolder;
using test::writeFile;
using testing::HasSubstr;

/// A surface with three bumps, seen from the origin, moved by `dx`; flat where `height` is 0.
std::string relief(double dx, double height) {
  std::string rows;
  std::size_t count = 0;
  for (double x = -0.1; x <= 0.1; x += 0.005)
    for (double y = -0.08; y <= 0.08; y += 0.005, ++count) {
      const auto bump = [&](double cx, double cy, double width) {
        return height * std::exp(-(std::pow(x - cx, 2) + std::pow(y - cy, 2)) / (2 * width * width));
      };
      rows += fmt::format(
          "{:.5f} {:.5f} {:.5f}\n", x + dx, y,
          1 - bump(-0.04, 0.03, 0.02) - 0.7 * bump(0.05, -0.02, 0.03) - 0.5 * bump(0.02, 0.05, 0.015));
    }
  return fmt::format(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nPOINTS {0}\n"
      "DATA ascii\n{1}",
      count, rows);
}

class RecognitionStagesTest : public testing::Test {
 protected:
  RecognitionStagesTest() {
    writeFile(scratch / "model.pcd", relief(0, 0.05));
    writeFile(scratch / "scene.pcd", relief(0.1, 0.05));
    pairs.scenes = {{"scene", scratch / "scene.pcd"}};
    pairs.models = {{"model", "relief", scratch / "model.pcd"}};
    pairs.pairs = {{0, 0, {cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.1, 0, 0))}}};
    options.modelFilters = {"none", "voxel"};
    options.modelPoints = 800;
  }
  static RecognitionUnit unit() { return {"default", "uniform", "shot", "none", 0, 0, 1, 0}; }
  RecognitionFound recognize(const RecognitionUnit& how = unit()) {
    RecognitionStages stages(options, pairs, scratch / "out");
    return stages.recognize({how, {0}});
  }
  ScratchFolder scratch;
  ModelPairs pairs;
  RecognitionExperimentOptions options;
};

TEST_F(RecognitionStagesTest, FindsTheModelWhereItIsByAllItsFilters) {
  for (const char* preset : {"default", "thesis", "wide"}) {
    RecognitionUnit how = unit();
    how.preset = preset;
    how.sceneFilter = "voxel";
    how.size = 1200;
    how.noise = 0.0005;
    const auto found = recognize(how);
    ASSERT_EQ(found.searches.size(), 2U);
    for (const auto& search : found.searches) {
      EXPECT_TRUE(search.verified) << preset << search.modelFilter;
      EXPECT_TRUE(search.correct) << preset << search.modelFilter;
      EXPECT_EQ(search.problem, "");
    }
  }
  EXPECT_TRUE(std::filesystem::exists(scratch / "out/filtered"));
}

TEST_F(RecognitionStagesTest, WhatLiesElsewhereIsNotCorrect) {
  pairs.pairs[0].poses = {cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.15, 0, 0))};
  EXPECT_TRUE(recognize().searches[0].verified);
  EXPECT_FALSE(recognize().searches[0].correct);
  pairs.pairs[0].poses.push_back(cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.11, 0, 0)));
  EXPECT_TRUE(recognize().searches[0].correct) << "one of two instances";
  pairs.pairs[0].poses = {cv::Affine3d(cv::Vec3d(0, 0, 3.14159), cv::Vec3d(0.1, 0, 0))};
  EXPECT_FALSE(recognize().searches[0].correct) << "turned";
  options.symmetries = {{"model", {0, 0, 1}, cv::Vec3d(0, 0, 1), 2}};
  EXPECT_TRUE(recognize().searches[0].correct) << "but the same";
}

TEST_F(RecognitionStagesTest, WhatHasNothingToDescribeIsNotFound) {
  writeFile(scratch / "scene.pcd",
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n"
            "DATA ascii\n0 0 1\n1 0 1\n");
  const auto found = recognize();
  ASSERT_EQ(found.searches.size(), 2U);
  for (const auto& search : found.searches) {
    EXPECT_THAT(search.problem, HasSubstr("scene: 2 of its 2 points are finite"));
    EXPECT_FALSE(search.verified);
  }
}

TEST_F(RecognitionStagesTest, WhySearchesFailedIsTold) {
  writeFile(scratch / "model.pcd", relief(0, 0));
  for (const auto& search : recognize().searches)
    EXPECT_THAT(search.problem, HasSubstr("model is planar")) << search.modelFilter;
}

TEST_F(RecognitionStagesTest, WhatCannotBeReadIsAnError) {
  writeFile(scratch / "scene.pcd", "no cloud");
  EXPECT_THAT([&] { recognize(); }, FailsWith(ErrorCode::malformedFile, "scene.pcd"));
  options.symmetries = {{"cup", {0, 0, 1}, std::nullopt, 2}};
  EXPECT_THAT([&] { recognize(); }, FailsWith(ErrorCode::unknownName, "cup"));
  writeFile(scratch / "model.pcd",
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\n"
            "DATA ascii\nnan nan nan\n");
  EXPECT_THAT([&] { recognize(); }, FailsWith(ErrorCode::invalidInput, "model.pcd"));
}

TEST_F(RecognitionStagesTest, InputsTellWhatResultsDependOn) {
  const auto inputs = [&](const RecognitionUnit& how) {
    return RecognitionStages(options, pairs, scratch / "out").inputs(how);
  };
  const std::string first = inputs(unit());
  EXPECT_EQ(inputs(unit()), first);
  RecognitionUnit other = unit();
  other.preset = "wide";
  EXPECT_NE(inputs(other), first);
  options.rotation = 10;
  EXPECT_NE(inputs(unit()), first);
  options.rotation = 15;
  pairs.pairs[0].poses[0] = cv::Affine3d::Identity();
  EXPECT_NE(inputs(unit()), first);
  pairs.pairs[0].poses[0] = cv::Affine3d(cv::Vec3d(), cv::Vec3d(0.1, 0, 0));
  EXPECT_EQ(inputs(unit()), first);
  writeFile(scratch / "scene.pcd", relief(0.1, 0.04));
  EXPECT_NE(inputs(unit()), first) << "another scene under the same name";
}

}  // namespace
}  // namespace estancia::experiments
