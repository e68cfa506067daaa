// Segmentation scored on made-up scenes: a wall, and before it a board and a ball.
// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/objects/object_segmentation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "estancia/io/csv.hpp"
#include "experiments/counting.hpp"
#include "experiments/src/objects/object_segmentation_findings.hpp"
#include "experiments/src/objects/object_segmentation_score.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;

/// The pixels of a rectangle in an image 10 wide.
PixelSet rectangle(int x, int y, int width, int height) {
  PixelSet pixels;
  for (int r = y; r < y + height; ++r)
    for (int c = x; c < x + width; ++c) pixels.push_back(static_cast<std::uint32_t>(10 * r + c));
  return pixels;
}

/// Objects 2 and 3, side by side: 4×5 pixels each.
cv::Mat twoObjects() {
  cv::Mat truth(10, 10, CV_32S, cv::Scalar(0));
  truth(cv::Rect(0, 0, 4, 5)).setTo(2);
  truth(cv::Rect(4, 0, 4, 5)).setTo(3);
  return truth;
}

TEST(ScoreClusters, CountsWhatIsFoundCutApartAndRunTogether) {
  const auto score = [](const std::vector<PixelSet>& clusters) {
    return scoreClusters(twoObjects(), clusters);
  };
  const SegmentationScore right = score({rectangle(0, 0, 4, 5), rectangle(4, 0, 4, 5)});
  EXPECT_EQ(right.objects, 2U);
  EXPECT_EQ(right.found, 2U);
  EXPECT_EQ(right.over, 0U);
  EXPECT_EQ(right.under, 0U);
  EXPECT_DOUBLE_EQ(right.iou, 2);

  const SegmentationScore together = score({rectangle(0, 0, 8, 5)});
  EXPECT_EQ(together.found, 2U) << "each has exactly half of it";
  EXPECT_EQ(together.under, 2U);
  EXPECT_EQ(together.over, 0U);
  EXPECT_EQ(score({rectangle(0, 0, 9, 5)}).found, 0U) << "what is no object's counts, too";

  const SegmentationScore apart =
      score({rectangle(0, 0, 3, 5), rectangle(3, 0, 1, 5), rectangle(4, 0, 4, 4)});
  EXPECT_EQ(apart.found, 2U);
  EXPECT_EQ(apart.over, 1U) << "a quarter of object 2 lies in another cluster";
  EXPECT_EQ(apart.under, 0U);
  EXPECT_DOUBLE_EQ(apart.iou, 0.75 + 0.8);
  EXPECT_EQ(score({rectangle(0, 0, 4, 5), rectangle(0, 0, 1, 3)}).over, 0U) << "less than a fifth";

  EXPECT_EQ(score({}).objects, 2U);
  EXPECT_EQ(score({}).found, 0U);
}

TEST(ScoreClusters, KnowsObjectsOnlyWhereDepthIs) {
  cv::Mat depth(10, 10, CV_32F, cv::Scalar(1));
  depth(cv::Rect(0, 0, 4, 5)).setTo(0);
  depth.at<float>(0, 4) = std::nanf("");
  const cv::Mat known = whereDepthIs(twoObjects(), depth);
  EXPECT_EQ(cv::countNonZero(known), 19);
  EXPECT_EQ(objectsOf(known).size(), 1U);
  EXPECT_THAT([&] { whereDepthIs(twoObjects(), cv::Mat(5, 5, CV_32F, cv::Scalar(1))); },
              FailsWith(ErrorCode::mismatch, "10×10", "5×5"));
  EXPECT_THAT([] { scoreClusters(twoObjects(), {{100}}); }, FailsWith(ErrorCode::invalidInput, "100"));
  EXPECT_THROW(scoreClusters(cv::Mat(2, 2, CV_8U), {}), Error);
}

constexpr int width = 160, height = 120;
const CameraIntrinsics camera{width, height, 131.25, 131.25, 79.5, 59.5};

/// A wall at 1.2 m, a board of 24×24 pixels at 1 m, and a ball of 8 cm radius; each number of meters beside
/// the middle.
struct Made {
  cv::Mat depth{height, width, CV_32F, cv::Scalar(1.2)}, label{height, width, CV_8U, cv::Scalar(1)};
  Made() {
    const cv::Rect board(20, 50, 24, 24);
    depth(board).setTo(1.0);
    label(board).setTo(20);
    const cv::Vec3d center(0.2, 0, 1);
    for (int r = 0; r < height; ++r)
      for (int c = 0; c < width; ++c) {
        const cv::Vec3d ray(camera.slopeX(c), camera.slopeY(r), 1);
        const double b = ray.dot(center), a = ray.dot(ray);
        const double inside = b * b - a * (center.dot(center) - 0.08 * 0.08);
        if (inside < 0) continue;
        depth.at<float>(r, c) = static_cast<float>((b - std::sqrt(inside)) / a);
        label.at<unsigned char>(r, c) = 31;
      }
  }
};

TEST(EuclideanClusters, PartsWhatIsFartherApartThanTheTolerance) {
  const Made made;
  Plane wall;
  wall.normal = {0, 0, -1};
  wall.offset = -1.2;
  ClusterOptions options;
  const auto found = euclideanClusters(made.depth, camera, {wall}, options, 0.02);
  EXPECT_EQ(found.size(), 2U);
  EXPECT_EQ(euclideanClusters(made.depth, camera, {wall}, options, 1.0).size(), 1U);
  EXPECT_EQ(euclideanClusters(made.depth, camera, {}, options, 0.02).size(), 3U) << "the wall is one, too";
  options.minPoints = 100'000;
  EXPECT_TRUE(euclideanClusters(made.depth, camera, {wall}, options, 0.02).empty());
}

TEST(Poster, LiesOnAPlaneThatFacesTheCamera) {
  const Made made;
  const PointCloud cloud = backProject(made.depth, camera);
  cv::Mat truth;
  made.label.convertTo(truth, CV_32S);
  truth.setTo(0, truth != 31);
  const PixelSet ball = objectsOf(truth).at(0);
  const PointCloud poster = posterOf(cloud, ball, 1);
  ASSERT_EQ(poster.points.size(), ball.size());
  cv::Vec3d center(0, 0, 0);
  for (const std::uint32_t i : ball)
    center += cv::Vec3d(cloud.points[i].x, cloud.points[i].y, cloud.points[i].z) / double(ball.size());
  for (std::size_t i = 0; i < ball.size(); ++i) {
    const cv::Point3f &p = poster.points[i], &q = cloud.points[ball[i]];
    EXPECT_NEAR(p.x / p.z, q.x / q.z, 1e-5) << "seen in the same pixel";
    EXPECT_NEAR((cv::Vec3d(p.x, p.y, p.z) - center).dot(center) / cv::norm(center), 0, 0.008);
  }
  EXPECT_EQ(poster.points, posterOf(cloud, ball, 1).points);
  EXPECT_NE(poster.points, posterOf(cloud, ball, 2).points);
}

class ObjectSegmentation : public testing::Test {
 protected:
  void SetUp() override {
    const Made made;
    cv::Mat millimeters;
    made.depth.convertTo(millimeters, CV_16U, 1000);
    std::filesystem::create_directories(scratch_ / "scenes/learn");
    writeFile(scratch_ / "scenes/index.csv",
              "split,n,category\nlearn,0,first\nlearn,1,second\nlearn,2,second\n");
    for (const std::string n : {"0", "1", "2"}) {
      const std::string stem = scratch_ / ("scenes/learn/learn" + n);
      cv::imwrite(stem + "_rgb.jpg", cv::Mat(height, width, CV_8UC3, cv::Scalar(90, 120, 150)));
      cv::imwrite(stem + "_depth.png", millimeters);
      cv::imwrite(stem + "_label.png", made.label);
    }
  }

  Findings run(const std::string& more = "", int threads = 2, const std::string& out = "out") {
    writeFile(scratch_ / "study.toml",
              "type = \"object-segmentation\"\nscenes = \"scenes\"\nimages = 1\n" + more +
                  "[camera]\nwidth = 160\nheight = 120\nfx = 131.25\nfy = 131.25\ncx = 79.5\ncy = 59.5\n");
    return runExperiment({scratch_ / "study.toml"}, {scratch_ / out, {}, {"", threads}, nullptr}, progress_);
  }

  test::ScratchFolder scratch_;
  test::Counting progress_{{"segmenting"}};
};

TEST_F(ObjectSegmentation, HasARowAScene) {
  const Findings findings = run();
  const auto rows = io::readCsv(scratch_ / "out/results.csv");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_THAT(rows[0].cells, ElementsAre("scene", "objects", "found", "over", "under", "mean_iou", "posters",
                                         "posters_told", "taken_for_flat", "euclidean_found",
                                         "euclidean_over", "euclidean_under", "euclidean_mean_iou"));
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto& cells = rows[i].cells;
    EXPECT_EQ(cells[1], "2");
    EXPECT_EQ(cells[2], "2") << "both are found";
    EXPECT_EQ(cells[3] + cells[4], "00");
    EXPECT_GT(std::stod(cells[5]), 0.9);
    EXPECT_EQ(cells[7], "2") << "photographs of a board and of a ball are flat";
    EXPECT_EQ(cells[8], "1") << "so is the board";
    EXPECT_EQ(cells[9], "2");
  }
  EXPECT_TRUE(findings.summary.starts_with("6 of 6 ")) << findings.summary;
  const auto& table = std::get<ResultTable>(findings.sections.at(0));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[1].name, "second");
  EXPECT_EQ(table.rows[1].values[0], 4.0);
  EXPECT_EQ(table.rows[2].name, "all");
  EXPECT_LT(*table.rows[2].values[3], 70) << "six of six are no certainty";
  ASSERT_EQ(findings.sections.size(), 5U);
  for (const std::size_t s : {3U, 4U}) EXPECT_EQ(std::get<Images>(findings.sections[s]).images.size(), 1U);
}

TEST_F(ObjectSegmentation, GoesOnWhereItStoppedAndDoesNotDependOnThreads) {
  run("", 1);
  EXPECT_EQ(progress_.computed, 3U);
  run("", 3, "again");
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), readFile(scratch_ / "again/results.csv"));
  progress_.computed = 0;
  run();
  EXPECT_EQ(progress_.computed, 0U) << "all is known";
  run("seed = 2\n");
  EXPECT_EQ(progress_.computed, 3U);
}

TEST_F(ObjectSegmentation, SaysWhatIsWrong) {
  const auto problem = [&](const std::string& more) { return test::caught([&] { run(more); }); };
  EXPECT_THAT(problem("tolerance = 0\n"), FailsWith(ErrorCode::malformedFile, "study.toml:4", "`tolerance`"));
  EXPECT_THAT(problem("scene = 1\n"), FailsWith(ErrorCode::malformedFile, "study.toml:4", "`scene`"));
  writeFile(scratch_ / "bare.toml", "type = \"object-segmentation\"\nscenes = \"scenes\"\n");
  EXPECT_THAT(
      [&] {
        runExperiment({scratch_ / "bare.toml"}, {scratch_ / "out", {}, {}, nullptr}, progress_);
      },
      FailsWith(ErrorCode::malformedFile, "`camera`"));
  EXPECT_EQ(problem("").code, std::nullopt);
  EXPECT_THAT(
      [&] {
        runExperiment({scratch_ / "study.toml"}, {scratch_ / "out", {"net"}, {}, nullptr}, progress_);
      },
      FailsWith(ErrorCode::invalidOption, "net"));
  cv::imwrite(scratch_ / "scenes/learn/learn1_label.png", cv::Mat(5, 5, CV_8U, cv::Scalar(20)));
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::mismatch, "5×5", "160×120"));
  for (const char* n : {"0", "1", "2"})
    cv::imwrite(scratch_ / (std::string("scenes/learn/learn") + n + "_label.png"),
                cv::Mat(height, width, CV_8U, cv::Scalar(1)));
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::insufficientData, "scenes"));
  std::filesystem::remove_all(scratch_ / "scenes");
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::fileNotFound, "scenes"));
}

TEST(RealScenes, AreNearlyAllSegmentedRightly) {
  const auto data = test::findData("mosd_rgbd");
  ESTANCIA_NEEDS(data, "mosd_rgbd is not here");
  const test::ScratchFolder scratch;
  writeFile(scratch / "real.toml", "type = \"object-segmentation\"\nscenes = \"" + data->string() +
                                       "\"\nimages = 0\n[camera]\nwidth = 640\nheight = 480\nfx = 525\n"
                                       "fy = 525\ncx = 319.5\ncy = 239.5\n");
  Progress silent;
  runExperiment({scratch / "real.toml"}, {scratch / "out", {}, {}, nullptr}, silent);
  double objects = 0, found = 0, told = 0, taken = 0;
  const auto rows = io::readCsv(scratch / "out/results.csv");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    objects += std::stod(rows[i].cells[1]);
    found += std::stod(rows[i].cells[2]);
    told += std::stod(rows[i].cells[7]);
    taken += std::stod(rows[i].cells[8]);
  }
  EXPECT_EQ(objects, 112);
  EXPECT_GE(found / objects, 0.95);
  EXPECT_GE(told / objects, 0.95) << "photographs of them are told";
  EXPECT_LE(taken / objects, 0.05) << "and they are not taken for photographs";
}

}  // namespace
}  // namespace estancia::experiments
