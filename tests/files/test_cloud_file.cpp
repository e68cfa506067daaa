// Clouds by the ending of their name, written PCD files, and depth images that become clouds.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/cloud_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/bytes.hpp"
#include "estancia/files/pcd.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using ::testing::IsEmpty;

using test::quietNan;

PointCloud organized() {
  PointCloud cloud;
  cloud.width = 3;
  cloud.height = 2;
  for (int i = 0; i < 6; ++i) {
    const auto f = static_cast<float>(i);
    cloud.points.emplace_back(i == 4 ? quietNan : f / 3, -f, 1e6F + f);
    cloud.colors.emplace_back(10 * i, 200 + i, i);
    cloud.normals.emplace_back(i == 2 ? cv::Point3f(quietNan, quietNan, quietNan)
                                      : cv::Point3f(0, 0.6F, -0.8F));
  }
  return cloud;
}

std::vector<std::uint32_t> bitsOf(const std::vector<cv::Point3f>& points) {
  std::vector<std::uint32_t> bits;
  for (const cv::Point3f& p : points)
    for (const float v : {p.x, p.y, p.z})
      bits.push_back(std::isnan(v) ? 0x7FC00000U : std::bit_cast<std::uint32_t>(v));
  return bits;
}

void expectSame(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(bitsOf(a.points), bitsOf(b.points));
  EXPECT_EQ(bitsOf(a.normals), bitsOf(b.normals));
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
}

class CloudFile : public ::testing::Test {
 protected:
  test::ScratchFolder folder_;
};

TEST_F(CloudFile, APcdKeepsEveryBitAndTheShape) {
  PointCloud cloud = organized();
  for (const bool ascii : {false, true}) {
    writePcd(cloud, folder_ / "a.pcd", ascii);
    expectSame(readPcd(folder_ / "a.pcd"), cloud);
  }
  cloud.colors.clear();
  writeCloud(cloud, folder_ / "a.PCD");
  expectSame(readCloud(folder_ / "a.PCD"), cloud);
  cloud.normals.clear();
  writeCloud(cloud, folder_ / "a.pcd");
  expectSame(readCloud(folder_ / "a.pcd"), cloud);
}

// A pcl::PointXYZRGB as written by pcl::io::savePCDFileBinary (PCL 1.13), after its own comment and order of
// lines.
TEST_F(CloudFile, APcdHasPclsFields) {
  PointCloud cloud;
  cloud.points = {{1, 2, 3}};
  cloud.colors.emplace_back(0x30, 0x20, 0x10);
  cloud.width = cloud.height = 1;
  writePcd(cloud, folder_ / "a.pcd");
  ByteWriter data;
  for (const float value : {1.F, 2.F, 3.F}) data.number(value);
  data.number(std::uint32_t{0x00102030});
  EXPECT_EQ(
      test::readFile(folder_ / "a.pcd"),
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F "
      "U\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n" +
          data.bytes());
}

TEST_F(CloudFile, OtherEndingsAreRefusedByName) {
  EXPECT_THAT([&] { readCloud(folder_ / "a.xyz"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { writeCloud(organized(), folder_ / "a.png"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(
      [&] {
        writeCloud(organized(), folder_ / "a.pcd", {{0, 1}});
      },
      FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { writeCloud({}, folder_ / "a.pcd"); }, FailsWith(ErrorCode::invalidInput));
  PointCloud torn = organized();
  torn.width = 4;
  EXPECT_THAT([&] { writeCloud(torn, folder_ / "a.pcd"); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { writeCloud(organized(), folder_ / "none" / "a.ply"); },
              FailsWith(ErrorCode::fileUnwritable));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(CloudFile, ADepthImageIsAnOrganizedCloud) {
  std::filesystem::create_directories(folder_ / "depth");
  const auto image = folder_ / "depth/1.png";
  cv::Mat depth(2, 4, CV_16U, cv::Scalar(2000));
  depth.at<std::uint16_t>(0, 1) = 0;
  cv::imwrite(image.string(), depth);
  EXPECT_THAT([&] { readCloud(image); }, FailsWith(ErrorCode::insufficientData));
  test::writeFile(folder_ / "intrinsics.txt", "4 4 1.5 0.5\n");  // above the image's folder
  PointCloud cloud = readCloud(image);
  EXPECT_EQ(cloud.width, 4U);
  EXPECT_EQ(cloud.height, 2U);
  EXPECT_EQ(cloud.points.at(0), cv::Point3f(-0.75F, -0.25F, 2));
  EXPECT_TRUE(std::isnan(cloud.points.at(1).z));
  EXPECT_THAT(cloud.colors, IsEmpty());

  cv::Mat colors(4, 8, CV_8UC3, cv::Scalar(1, 2, 3));
  colors(cv::Rect(4, 0, 4, 4)) = cv::Scalar(7, 8, 9);
  cv::imwrite((folder_ / "colors.png").string(), colors);
  test::writeFile(folder_ / "mine.txt", "8 8 1.5 0.5\n");
  cloud = readCloud(image, {500, folder_ / "mine.txt", folder_ / "colors.png"});
  EXPECT_EQ(cloud.points.at(0), cv::Point3f(-0.75F, -0.25F, 4));
  EXPECT_EQ(cloud.colors.at(5), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(cloud.colors.at(6), cv::Vec3b(7, 8, 9));
}

}  // namespace
}  // namespace estancia
