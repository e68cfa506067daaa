// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/color_cases.hpp"
#include "recognition/pose_error.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

/// Share of a model's points that lie on the scene, those that face away excepted.
double agreement(const ColorCases& cases, const ColorCases::Search& search, float reach) {
  const Neighbors scene(cases.scenes[search.scene].cloud.points);
  const PointCloud& model = cases.models[search.model].cloud;
  std::vector<Neighbor> buffer;
  double near = 0, all = 0;
  for (std::size_t i = 0; i < model.points.size(); i += 11) {
    const cv::Point3f p(search.truth[0] * cv::Point3d(model.points[i]));
    near += scene.nearest(p, 1, buffer, reach).empty() ? 0 : 1;
    ++all;
  }
  return near / all;
}

TEST(LookAlikes, StandWhereTheTruthSays) {
  const ColorCases cases = lookAlikeCases(2, 1), again = lookAlikeCases(2, 1);
  EXPECT_EQ(cases.models.size(), 12U);
  EXPECT_EQ(cases.scenes.size(), 6U);
  ASSERT_EQ(cases.searches.size(), 12U);
  std::size_t absent = 0;
  for (const ColorCases::Search& search : cases.searches) {
    EXPECT_EQ(search.lookAlikes.size(), search.truth.empty() ? 3U : 2U);
    absent += search.truth.empty() ? 1 : 0;
    if (!search.truth.empty()) {
      EXPECT_GT(agreement(cases, search, 0.01F), 0.4);
    }
  }
  EXPECT_EQ(absent, 6U);
  for (std::size_t s = 0; s < cases.scenes.size(); ++s)
    EXPECT_EQ(cases.scenes[s].cloud.colors, again.scenes[s].cloud.colors);
}

TEST(DriveCases, AreSeenWhereThePosesSay) {
  const auto data = test::findData("home_a");
  ESTANCIA_NEEDS(data, "needs home_a");
  DriveCasesOptions options;
  options.path = *data / "day";
  options.instances = true;
  options.every = 60;
  options.models = 3;
  const ColorCases cases = casesOfDrive(options);
  ASSERT_EQ(cases.searches.size(), 2 * cases.models.size());
  for (const ColorCases::Search& search : cases.searches)
    if (!search.truth.empty()) {
      EXPECT_GT(agreement(cases, search, 0.05F), 0.6);
    }
  for (const ColorCases::Model& model : cases.models) {
    EXPECT_GE(model.cloud.points.size(), 1500U);
    EXPECT_EQ(model.cloud.colors.size(), model.cloud.points.size());
  }
}

class ColorRecognition : public testing::Test {
 protected:
  Findings run(const std::string& config) {
    writeFile(scratch_ / "color.toml", "type = \"color-recognition\"\n" + config);
    Progress silent;
    return runExperiment({scratch_ / "color.toml"}, {scratch_ / "out", {}, {}, nullptr}, silent);
  }
  test::ScratchFolder scratch_;
};

TEST_F(ColorRecognition, ComparesConditionsOnLookAlikes) {
  const Findings findings =
      run("look-alikes = 1\n[[condition]]\nname = \"shape\"\n[[condition]]\nname = "
          "\"color\"\ncolor-tolerance = 20\n");
  const auto& table = std::get<ResultTable>(findings.sections.at(0));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].values[0], 3);
  EXPECT_GE(table.rows[1].values[2], table.rows[0].values[2]);  // the right thing
}

TEST_F(ColorRecognition, SaysWhatIsWrong) {
  EXPECT_THAT([&] { run("look-alikes = 1\n"); }, FailsWith(ErrorCode::malformedFile, "condition"));
  EXPECT_THAT([&] { run("[[condition]]\nname = \"a\"\ndescriptor = \"sift\"\n"); },
              FailsWith(ErrorCode::malformedFile, "shot-color"));
  EXPECT_THAT([&] { run("[[condition]]\nname = \"a\"\n[[drive]]\nname = \"b\"\npath = \"nowhere\"\n"); },
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
}

TEST(Recognizer, TellsPlainCansApartByTheirColor) {
  const ColorCases cases = lookAlikeCases(2, 3);
  RecognitionOptions options;
  options.colorTolerance = 20;
  const Recognizer recognizer(options);
  for (const ColorCases::Search& search : cases.searches) {
    const ColorCases::Model& model = cases.models[search.model];
    if (model.group != "plain cans") continue;
    const auto scene = recognizer.prepareScene("scene", cases.scenes[search.scene].cloud);
    const auto found = recognizer.find(*recognizer.prepareModel(model.name, model.cloud), *scene);
    ASSERT_EQ(found.size(), search.truth.size()) << model.name;
    if (found.empty()) continue;
    EXPECT_TRUE(
        isCorrect(poseError(found[0].pose, search.truth[0], centerOf(model.cloud), model.symmetries)));
  }
}

}  // namespace
}  // namespace estancia::experiments
