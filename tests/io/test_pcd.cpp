// Point clouds in PCD files: what PCL writes, what the format allows, and what must be refused.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/pcd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::Mentions;
using ::testing::IsEmpty;

using test::kNaN;

using test::bytesOf;

/// LZF without any match: what is written stands there as it is.
std::string packed(const std::string& bytes) {
  std::string result;
  for (std::size_t i = 0; i < bytes.size(); i += 32) {
    const std::string run = bytes.substr(i, 32);
    result += static_cast<char>(run.size() - 1) + run;
  }
  return bytesOf(static_cast<std::uint32_t>(result.size())) +
         bytesOf(static_cast<std::uint32_t>(bytes.size())) + result;
}

class Pcd : public ::testing::Test {
 protected:
  PointCloud read(const std::string& bytes) {
    test::writeFile(folder_ / "cloud.pcd", bytes);
    return readPcd(folder_ / "cloud.pcd");
  }
  test::Caught refusal(const std::string& bytes) {
    return test::caught([&] { read(bytes); });
  }
  static std::string header(const std::string& data,
                            const std::string& size = "WIDTH 2\nHEIGHT 1\nPOINTS 2\n") {
    return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n" + size +
           "VIEWPOINT 0 0 0 1 0 0 0\nDATA " + data + "\n";
  }
  static std::string floats(const std::vector<float>& values) {
    std::string bytes;
    for (const float value : values) bytes += bytesOf(value);
    return bytes;
  }
  test::ScratchFolder folder_;
};

void expectTwoPoints(const PointCloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.width, 2U);
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_FALSE(cloud.organized());
  EXPECT_EQ(cloud.points[0], cv::Point3f(1, -2.5F, 3));
  EXPECT_EQ(cloud.points[1].y, 5);
  EXPECT_TRUE(std::isnan(cloud.points[1].z));
  EXPECT_THAT(cloud.colors, IsEmpty());
}

TEST_F(Pcd, ReadsItsThreeForms) {
  expectTwoPoints(read(header("ascii") + "1 -2.5 3\n4 5 nan\n"));
  expectTwoPoints(read(header("ascii") + "1 -2.5\t3\r\n\n 4 5 -nan"));
  expectTwoPoints(read(header("binary") + floats({1, -2.5F, 3, 4, 5, kNaN}) + "padding"));
  expectTwoPoints(read(header("binary_compressed") + packed(floats({1, 4, -2.5F, 5, 3, kNaN}))));
  expectTwoPoints(
      read("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n1 -2.5 3\n4 5 nan\n"));
}

// Written by pcl::io::savePCDFileBinaryCompressed (PCL 1.13): 6 × 4 points XYZRGB with x = column / 4, y =
// row / 2, z = NaN where i % 5 = 3, else 1 + (i % 3) / 8; r = i, g = 2 i, b = 255 - i.
const std::string& writtenByPcl() {
  static const std::string bytes = [] {
    const std::string hex =
        "b500000080010000010000400001803e2005033f00004020030080200300a020034000e03f17e00c004063e00a03407f"
        "e00b0300c0202be00b03402b0090201b40b302c07f00e0000bc0174013c00b4023400b4013c00be0153b1fff0000fffe"
        "0201fffd0402fffc0603fffb0804fffa0a05fff90c06fff80e07ff1ff71008fff61209fff5140afff4160bfff3180cff"
        "f21a0dfff11c0efff01e0fff1fef2010ffee2211ffed2412ffec2613ffeb2814ffea2a15ffe92c16ffe82e17ff";
    std::string all =
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F "
        "U\n"
        "COUNT 1 1 1 1\nWIDTH 6\nHEIGHT 4\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 24\nDATA binary_compressed\n";
    for (std::size_t i = 0; i < hex.size(); i += 2)
      all += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    return all;
  }();
  return bytes;
}

TEST_F(Pcd, ReadsWhatPclPacked) {
  const PointCloud cloud = read(writtenByPcl());
  ASSERT_EQ(cloud.points.size(), 24U);
  ASSERT_EQ(cloud.colors.size(), 24U);
  EXPECT_TRUE(cloud.organized());
  const cv::Mat depth = depthOf(cloud);
  ASSERT_EQ(depth.size(), cv::Size(6, 4));
  for (int i = 0; i < 24; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(cloud.points[k].x, 0.25F * static_cast<float>(i % 6));
    EXPECT_EQ(cloud.points[k].y, 0.5F * static_cast<float>(i / 6));
    const float z = i % 5 == 3 ? 0 : 1 + 0.125F * static_cast<float>(i % 3);
    EXPECT_EQ(std::isnan(cloud.points[k].z), z == 0);
    EXPECT_EQ(depth.at<float>(i / 6, i % 6), z);
    EXPECT_EQ(cloud.colors[k],
              cv::Vec3b(static_cast<uchar>(255 - i), static_cast<uchar>(2 * i), static_cast<uchar>(i)));
  }
}

TEST_F(Pcd, TheViewpointIsKept) {
  const auto at = [&](const std::string& viewpoint) {
    return read("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nVIEWPOINT" + viewpoint +
                "\nDATA ascii\n1 2 3\n");
  };
  for (const char* none : {" 0 0 0 1 0 0 0", " 1 2 3 0 0 0 0", " nan 2 3 1 0 0 0", " 1e300 2 3 1 0 0 0"})
    EXPECT_FALSE(at(none).viewpoint) << none;
  const PointCloud cloud = at(" 1 -2 3.5 0 0 2 0");
  EXPECT_EQ(cloud.points.at(0), cv::Point3f(1, 2, 3));
  writePcd(cloud, folder_ / "again.pcd");
  for (const PointCloud& one : {cloud, readPcd(folder_ / "again.pcd")}) {
    ASSERT_TRUE(one.viewpoint);
    EXPECT_EQ(one.viewpoint->x, 1);
    EXPECT_EQ(one.viewpoint->y, -2);
    EXPECT_EQ(one.viewpoint->z, 3.5);
    EXPECT_EQ(one.viewpoint->qy, 1);
    EXPECT_EQ(one.viewpoint->qw, 0);
  }
  EXPECT_THAT([&] { at(" 1 2 3"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { at(" 1 2 3 one 0 0 0"); }, FailsWith(ErrorCode::malformedFile));
}

TEST_F(Pcd, PassesOverOtherFieldsAndTakesOtherNumbers) {
  const std::string fields =
      "VERSION .7\nFIELDS normal z _ y rgba x\nSIZE 4 8 1 2 4 4\nTYPE F F U I U U\nCOUNT 3 1 5 1 1 1\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\n";
  const std::string point = floats({9, 9, 9}) + bytesOf(0.5) + "abcde" + bytesOf(std::int16_t{-7}) +
                            bytesOf(std::uint32_t{0xFF102030}) + bytesOf(std::uint32_t{12});
  for (const std::string& file :
       {fields + "DATA binary\n" + point, fields + "DATA binary_compressed\n" + packed(point),
        fields + "DATA ascii\n9 9 9 0.5 1 2 3 4 5 -7 4279246896 12\n"}) {
    const PointCloud cloud = read(file);
    EXPECT_EQ(cloud.points.at(0), cv::Point3f(12, -7, 0.5F));
    EXPECT_EQ(cloud.colors.at(0), cv::Vec3b(0x30, 0x20, 0x10));
  }
}

TEST_F(Pcd, RefusesWhatIsCutShort) {
  const std::string files[] = {writtenByPcl(), header("binary") + floats({1, 2, 3, 4, 5, 6}),
                               header("ascii") + "1 2 3\n4 5 6"};
  for (const std::string& file : files) {
    EXPECT_FALSE(refusal(file).code);
    for (std::size_t size = 0; size < file.size(); ++size)
      EXPECT_TRUE(refusal(file.substr(0, size)).code) << size << " of " << file.size() << " bytes";
  }
  EXPECT_THAT(refusal(files[1].substr(0, files[1].size() - 1)), FailsWith(ErrorCode::truncatedFile));
}

TEST_F(Pcd, TellsOfNoMorePointsThanItHas) {
  const std::string huge = "WIDTH 2000000000\nHEIGHT 2000000000\n";
  EXPECT_THAT(refusal(header("ascii", huge) + "1 2 3\n"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal(header("binary", huge) + "1 2 3\n"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal(header("binary_compressed", huge) + packed("123")), FailsWith(ErrorCode::corruptFile));
}

TEST_F(Pcd, RefusesHeadersThatContradictThemselves) {
  const std::string whole = header("ascii") + "1 2 3\n4 5 6\n";
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"FIELDS x y z", "FIELDS x y w"},
                                                        {"FIELDS x y z", "FIELDS x y"},
                                                        {"FIELDS x y z", "FIELDS x x z"},
                                                        {"SIZE 4 4 4", "SIZE 4 4 2"},
                                                        {"SIZE 4 4 4", "SIZE 4 4 four"},
                                                        {"TYPE F F F", "TYPE F F X"},
                                                        {"TYPE F F F\n", ""},
                                                        {"COUNT 1 1 1", "COUNT 1 1 2"},
                                                        {"COUNT 1 1 1", "COUNT 1 1 0"},
                                                        {"COUNT 1 1 1", "COUNT 1 1 70000"},
                                                        {"POINTS 2", "POINTS 3"},
                                                        {"WIDTH 2", "WIDTH -2"},
                                                        {"WIDTH 2", "WIDTH"},
                                                        {"HEIGHT 1", "HEIGHT 0"},
                                                        {"4 5 6", "4 5"},
                                                        {"4 5 6", "4 5 six"}}) {
    std::string text = whole;
    EXPECT_THAT(refusal(text.replace(text.find(from), from.size(), to)), FailsWith(ErrorCode::malformedFile))
        << to;
  }
  for (const auto& [from, to] : {std::pair{"0.7\nF", "0.5\nF"}, {"DATA ascii", "DATA zip"}}) {
    std::string text = whole;
    EXPECT_THAT(refusal(text.replace(text.find(from), std::string(from).size(), to)),
                FailsWith(ErrorCode::unsupportedFile))
        << to;
  }
  for (const char* text : {"", "ply\nformat ascii 1.0\n"})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT([&] { readPcd(folder_ / "none.pcd"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(Pcd, OnlyAnOrganizedCloudHasADepthImage) {
  EXPECT_THAT([&] { depthOf(read(header("ascii") + "1 2 3\n4 5 6\n")); }, FailsWith(ErrorCode::invalidInput));
  const PointCloud cloud = read(header("ascii", "WIDTH 1\nHEIGHT 4\n") + "0 0 2\n0 0 -1\n0 0 inf\n0 0 nan\n");
  const cv::Mat depth = depthOf(cloud);
  EXPECT_EQ(cv::countNonZero(depth), 1);
  EXPECT_EQ(depth.at<float>(0), 2);
}

}  // namespace
}  // namespace estancia
