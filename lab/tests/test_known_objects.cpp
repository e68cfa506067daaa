// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "recognition/depth_frames.hpp"
#include "recognition/known_objects.hpp"
#include "recognition/made_up_models.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

constexpr double pitch = 0.6;  // [rad] by which the camera looks down

/// A camera 1 m from a table that fills the image.
DepthFrame table() {
  DepthFrame frame{"table", {}, {640, 480, 525, 525, 319.5, 239.5}};
  cv::Mat_<float> depth(480, 640, 0.F);
  for (int v = 0; v < depth.rows; ++v) {
    const double z = std::sin(pitch) / (std::sin(pitch) + std::cos(pitch) * frame.camera.slopeY(v));
    if (z > 0 && z < 3) depth.row(v) = z;
  }
  frame.depth = depth;
  return frame;
}

const cv::Vec3d up(0, -std::cos(pitch), -std::sin(pitch));

MadeUpModel modelOf(const std::string& family) {
  for (MadeUpModel& model : madeUpModels(1))
    if (model.family == family) return model;
  return {};
}

TEST(Solids, AreMetWhereTheyAre) {
  const cv::Vec3d from(0, 0, 2), down(0, 0, -1);
  const auto depthOf = [&](const Solid& solid, const cv::Vec3d& at) {
    SolidHit hit;
    cast(solid, from + at, down, hit);
    return hit.t;
  };
  const cv::Vec3d size(0.2, 0.2, 0.5);
  for (const auto shape : {Solid::Shape::box, Solid::Shape::cylinder, Solid::Shape::ellipsoid})
    EXPECT_DOUBLE_EQ(depthOf({shape, {}, size, 0}, {0, 0, 0}), 1.5);
  const cv::Vec3d corner(0.09, 0.09, 0);
  EXPECT_DOUBLE_EQ(depthOf({Solid::Shape::box, {}, size, 0}, corner), 1.5);
  EXPECT_EQ(depthOf({Solid::Shape::cylinder, {}, size, 0}, corner), HUGE_VAL);
  EXPECT_EQ(depthOf({Solid::Shape::ellipsoid, {}, size, 0}, corner), HUGE_VAL);
  EXPECT_EQ(depthOf({Solid::Shape::box, {}, size, CV_PI / 4}, corner), HUGE_VAL);
}

TEST(MadeUpModels, SidesShowTheSolidsOfTheWhole) {
  for (const MadeUpModel& model : madeUpModels(1)) {
    ASSERT_GT(model.oneSided.points.size(), 500U) << model.name;
    EXPECT_LT(model.diameter(), 1) << model.name;
    // A point of the side lies on a solid: the depth there, seen from its camera, is its own but for noise.
    const CameraIntrinsics camera{640, 480, 525, 525, 319.5, 239.5};
    const cv::Mat depth = renderSolids(model.solids, model.view.inv(), camera);
    for (std::size_t i = 0; i < model.oneSided.points.size(); i += 97) {
      const cv::Point3f p = model.oneSided.points[i];
      const auto u = cvRound(p.x / p.z * 525 + 319.5), v = cvRound(p.y / p.z * 525 + 239.5);
      EXPECT_NEAR(depth.at<float>(v, u), p.z, 0.005) << model.name;
    }
  }
}

TEST(DepthFrames, ModelsStandLieAndStackWhereTheyArePut) {
  const DepthFrame frame = table();
  const MadeUpModel box = modelOf("box");  // 16 × 6 × 21 cm
  for (const auto& [placement, upwards, foot] :
       {std::tuple{Placement::standing, 2, 0.0}, {Placement::lying, 1, 0.0}, {Placement::byWall, 2, 0.0}}) {
    const auto placed = place(box, frame, placement, 0, false, 3);
    ASSERT_TRUE(placed) << nameOf(placement);
    const cv::Matx33d turn = placed->pose.rotation();
    EXPECT_NEAR(std::abs(cv::Vec3d(turn(0, upwards), turn(1, upwards), turn(2, upwards)).dot(up)), 1, 1e-3);
    EXPECT_EQ(placed->hidden, 0);
    // Its lowest point is on the table, which is 1 m · sin(pitch) below the camera.
    double low = HUGE_VAL;
    for (const cv::Point3f& p : box.whole.points)
      low = std::min(low, up.dot(placed->pose * cv::Vec3d(p.x, p.y, p.z)));
    EXPECT_NEAR(low, -std::sin(pitch), 0.003) << nameOf(placement);
  }
  const auto stacked = place(box, frame, Placement::stacked, 0, false, 3);
  ASSERT_TRUE(stacked);
  EXPECT_GT(up.dot(stacked->pose.translation()), -std::sin(pitch) + 0.035);
}

TEST(DepthFrames, SomethingHidesAboutAsMuchAsIsAsked) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed)
    if (const auto placed = place(modelOf("box"), table(), Placement::standing, 0.45, true, seed)) {
      sum += placed->hidden;
      ++count;
    }
  ASSERT_GT(count, 3);
  EXPECT_NEAR(sum / count, 0.45, 0.15);
}

TEST(DepthFrames, NothingIsPutWhereNothingIsFlat) {
  DepthFrame frame = table();
  cv::randu(frame.depth, 0.5, 2);
  EXPECT_FALSE(place(modelOf("box"), frame, Placement::standing, 0, false, 1));
}

class KnownObjects : public ::testing::Test {
 protected:
  /// A folder of tables as the object scenes have them.
  void SetUp() override {
    std::filesystem::create_directories(folder.path() / "learn");
    writeText("index.csv", "split,n\nlearn,0\nlearn,1\n");
    cv::Mat depth;
    table().depth.convertTo(depth, CV_16U, 1000);
    for (const char* n : {"0", "1"})
      for (const char* end : {"_depth.png", "_label.png", "_rgb.jpg"})
        cv::imwrite((folder.path() / "learn" / (std::string("learn") + n + end)).string(), depth);
  }
  std::filesystem::path writeText(const std::string& name, const std::string& text) {
    test::writeFile(folder.path() / name, text);
    return folder.path() / name;
  }
  Findings run(const std::filesystem::path& config) const {
    ExperimentRun run;
    run.folder = folder.path() / "out";
    return runExperiment({config}, run, Progress::none());
  }
  test::ScratchFolder folder;
};

TEST_F(KnownObjects, PutOnATableAreFoundAndAbsentOnesAreNot) {
  const auto config = writeText("known.toml",
                                "type = \"known-objects\"\nfamilies = [\"toy\"]\n[[frames]]\n"
                                "name = \"tables\"\npath = \".\"\n");
  const Findings findings = run(config);
  ASSERT_EQ(findings.sections.size(), 4U);  // absent and present, by halves
  for (const auto& section : findings.sections) {
    const auto& table = std::get<ResultTable>(section);
    const ResultTable::Row& all = table.rows.back();
    ASSERT_EQ(all.name, "all");
    const bool present = table.title.starts_with("Present");
    EXPECT_EQ(all.values[0], present ? 2 : 6) << table.title;
    EXPECT_EQ(all.values[1], present ? 2 : 0) << table.title;
    EXPECT_EQ(all.values[5], 0) << table.title;  // wrong
  }
}

TEST_F(KnownObjects, AnUnknownHalfIsRefused) {
  const auto config = writeText("known.toml",
                                "type = \"known-objects\"\nhalves = [\"third\"]\n[[frames]]\n"
                                "name = \"tables\"\npath = \".\"\n");
  EXPECT_THAT([&] { run(config); }, test::FailsWith(ErrorCode::malformedFile, "reporting"));
}

}  // namespace
}  // namespace estancia::experiments
