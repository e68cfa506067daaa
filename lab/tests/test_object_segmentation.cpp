// Segmentation scored on made-up scenes: a wall, and before it a board and a ball.
// SPDX-License-Identifier: Apache-2.0
#include "objects/object_segmentation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "counting.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "objects/made_up_scenes.hpp"
#include "objects/object_segmentation_findings.hpp"
#include "objects/object_segmentation_score.hpp"
#include "objects/optimal_assignment.hpp"
#include "objects/segmentation_measures.hpp"
#include "runner/experiment.hpp"
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

TEST(OptimalAssignment, IsTheOneOfTheGreatestSum) {
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  // Taking the greatest first, 9, leaves 1: 10; 8 and 7 are 15.
  const cv::Mat_<double> gain = (cv::Mat_<double>(2, 2) << 9, 8, 7, 1);
  EXPECT_EQ(optimalAssignment(gain), (Pairs{{0, 1}, {1, 0}}));
  const cv::Mat_<double> wide = (cv::Mat_<double>(2, 3) << 1, 5, 2, 1, 5, 4);
  EXPECT_EQ(optimalAssignment(wide), (Pairs{{0, 1}, {1, 2}}));
  EXPECT_EQ(optimalAssignment(wide.t()), (Pairs{{1, 0}, {2, 1}}));
}

TEST(MeasureClusters, OverlapAndBoundaryByHand) {
  // The boundary of a rectangle not at the image's edge is a closed line of pixels; one pixel is near here.
  cv::Mat truth(10, 10, CV_32S, cv::Scalar(0));
  truth(cv::Rect(2, 2, 4, 4)).setTo(2);
  const SegmentationMeasures same = measureClusters(truth, {rectangle(2, 2, 4, 4)});
  for (const PrecisionRecall& all : {same.overlap, same.boundary}) {
    EXPECT_DOUBLE_EQ(all.precision, 1);
    EXPECT_DOUBLE_EQ(all.recall, 1);
    EXPECT_DOUBLE_EQ(all.f, 1);
  }
  EXPECT_EQ(same.atThreeQuarters, 1);

  const SegmentationMeasures half = measureClusters(truth, {rectangle(2, 2, 2, 4)});
  EXPECT_DOUBLE_EQ(half.overlap.precision, 1);
  EXPECT_DOUBLE_EQ(half.overlap.recall, 0.5);
  EXPECT_DOUBLE_EQ(half.overlap.f, 2. / 3);
  EXPECT_EQ(half.atThreeQuarters, 0);
  // The half's line, around columns 1 … 3 and rows 1 … 5, has 12 pixels, and all but the middle of column 3
  // are within a pixel of the object's line. The object's line, around columns and rows 1 … 5, has 16:
  // columns 1 … 4 are near.
  EXPECT_DOUBLE_EQ(half.boundary.precision, 11. / 12);
  EXPECT_DOUBLE_EQ(half.boundary.recall, 11. / 16);

  // Two clusters: the second one, of no object, counts against precision alone.
  const SegmentationMeasures more = measureClusters(truth, {rectangle(2, 2, 4, 4), rectangle(7, 7, 2, 2)});
  EXPECT_DOUBLE_EQ(more.overlap.precision, 16. / 20);
  EXPECT_DOUBLE_EQ(more.overlap.recall, 1);
  EXPECT_LT(more.boundary.precision, 1);
}

TEST(MeasureClusters, NothingFoundIsPreciseAndNothingToFindIsRecalled) {
  const SegmentationMeasures none = measureClusters(twoObjects(), {});
  EXPECT_EQ(none.overlap.precision, 1);
  EXPECT_EQ(none.overlap.recall, 0);
  EXPECT_EQ(none.boundary.f, 0);
  const SegmentationMeasures false_ =
      measureClusters(cv::Mat::zeros(10, 10, CV_32S), {rectangle(0, 0, 2, 2)});
  EXPECT_EQ(false_.overlap.precision, 0);
  EXPECT_EQ(false_.overlap.recall, 1);
  EXPECT_THAT([] { measureClusters(twoObjects(), {{100}}); }, FailsWith(ErrorCode::invalidInput, "100"));
  EXPECT_THROW(measureClusters(cv::Mat(2, 2, CV_8U), {}), Error);
}

TEST(MadeUpScenes, AreAFunctionOfTheSeed) {
  const MadeUpScene scene = madeUpScene(8), again = madeUpScene(8), other = madeUpScene(15);
  EXPECT_EQ(scene.category, "side by side");
  EXPECT_EQ(scene.category, other.category);
  EXPECT_EQ(cv::norm(scene.depth, again.depth, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(scene.image, again.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(scene.truth, again.truth, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(scene.truth, other.truth, cv::NORM_INF), 0);
  EXPECT_GE(objectsOf(scene.truth).size(), 3U);
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
  const auto column = [&](const std::string& name) {
    const auto found = std::ranges::find(rows[0].cells, name);
    EXPECT_NE(found, rows[0].cells.end()) << name;
    return static_cast<std::size_t>(found - rows[0].cells.begin());
  };
  EXPECT_EQ(rows[0].cells.size(), 27U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto value = [&](const std::string& name) { return std::stod(rows[i].cells[column(name)]); };
    EXPECT_EQ(value("objects"), 2);
    EXPECT_EQ(value("found"), 2) << "both are found";
    EXPECT_EQ(value("over") + value("under"), 0);
    EXPECT_GT(value("mean_iou"), 0.9);
    EXPECT_GT(value("overlap_f"), 0.95);
    EXPECT_GT(value("boundary_f"), 0.9);
    EXPECT_EQ(value("f_above_75"), 2);
    EXPECT_EQ(value("posters_told"), 2) << "photographs of a board and of a ball are flat";
    EXPECT_EQ(value("taken_for_flat"), 1) << "so is the board";
    EXPECT_EQ(value("euclidean_found"), 2);
    EXPECT_GT(value("euclidean_overlap_f"), 0.8);
  }
  EXPECT_TRUE(findings.summary.starts_with("6 of 6 ")) << findings.summary;
  const auto& table = std::get<ResultTable>(findings.sections.at(0));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[1].name, "second");
  EXPECT_EQ(table.rows[1].values[0], 4.0);
  EXPECT_EQ(table.rows[2].name, "all");
  EXPECT_LT(*table.rows[2].values[3], 70) << "six of six are no certainty";
  ASSERT_EQ(findings.sections.size(), 7U);
  for (const std::size_t s : {5U, 6U}) EXPECT_EQ(std::get<Images>(findings.sections[s]).images.size(), 1U);
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

TEST_F(ObjectSegmentation, TakesMadeUpScenes) {
  writeFile(scratch_ / "made.toml",
            "type = \"object-segmentation\"\nimages = 1\n[made_up]\ncount = 2\nfirst = 6\n");
  runExperiment({scratch_ / "made.toml"}, {scratch_ / "made", {}, {"", 2}, nullptr}, progress_);
  const auto rows = io::readCsv(scratch_ / "made/results.csv");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1].cells[0], "6");
  for (const char* more : {"scenes = \"scenes\"\n", ""}) {
    writeFile(scratch_ / "made.toml", std::string("type = \"object-segmentation\"\n") + more +
                                          (*more != 0 ? "[made_up]\ncount = 2\n" : ""));
    EXPECT_THAT(
        [&] {
          runExperiment({scratch_ / "made.toml"}, {scratch_ / "made", {}, {}, nullptr}, progress_);
        },
        FailsWith(ErrorCode::malformedFile, "made_up"));
  }
}

TEST_F(ObjectSegmentation, SaysWhatIsWrong) {
  const auto problem = [&](const std::string& more) { return test::caught([&] { run(more); }); };
  EXPECT_THAT(problem("[made_up]\ncount = 0\n"),
              FailsWith(ErrorCode::malformedFile, "study.toml:4", "`made_up`"));
  EXPECT_THAT(problem("scene = 1\n"), FailsWith(ErrorCode::malformedFile, "study.toml:4", "`scene`"));
  writeFile(scratch_ / "bare.toml", "type = \"object-segmentation\"\nscenes = \"scenes\"\n");
  EXPECT_THAT(
      [&] {
        runExperiment({scratch_ / "bare.toml"}, {scratch_ / "out", {}, {}, nullptr}, progress_);
      },
      FailsWith(ErrorCode::malformedFile, "camera"));
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
    told += std::stod(rows[i].cells[14]);
    taken += std::stod(rows[i].cells[15]);
  }
  EXPECT_EQ(objects, 112);
  EXPECT_GE(found / objects, 0.95);
  EXPECT_GE(told / objects, 0.95) << "photographs of them are told";
  EXPECT_LE(taken / objects, 0.05) << "and they are not taken for photographs";
}

}  // namespace
}  // namespace estancia::experiments
