// Point clouds in PLY files: the three forms, what others put into them, and what must be refused.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/ply.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

using test::kNaN;

using test::bytesOf;

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n";
}
const std::string kPoints = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "element face 1\nproperty list uchar int vertex_indices\n";

class Ply : public ::testing::Test {
 protected:
  PointCloud read(const std::string& bytes) {
    test::writeFile(folder_ / "cloud.ply", bytes);
    return readPly(folder_ / "cloud.ply");
  }
  test::Caught refusal(const std::string& bytes) {
    return test::caught([&] { read(bytes); });
  }
  test::ScratchFolder folder_;
};

void expectTwoPlyPoints(const PointCloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.width, 2U);
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_EQ(cloud.points[0], cv::Point3f(1, -2.5F, 3));
  EXPECT_EQ(cloud.points[1].y, 5);
  EXPECT_TRUE(std::isnan(cloud.points[1].z));
}

TEST_F(Ply, ReadsItsThreeForms) {
  expectTwoPlyPoints(read(header("ascii", kPoints) + "1 -2.5 3\n4 5 nan\n"));
  expectTwoPlyPoints(read(header("ascii", kPoints + kFaces) + "1 -2.5\t3\r\n4 5 nan\n3 0 1 0"));
  for (const bool big : {false, true}) {
    std::string data;
    for (const float value : {1.F, -2.5F, 3.F, 4.F, 5.F, kNaN}) data += bytesOf(value, big);
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    expectTwoPlyPoints(read(header(format, kPoints) + data));
    data += "\x02";
    for (const std::int32_t vertex : {0, 1}) data += bytesOf(vertex, big);
    expectTwoPlyPoints(read(header(format, kPoints + kFaces) + data));
  }
}

TEST_F(Ply, TakesOtherNumbersAndPassesOverTheRest) {
  const std::string elements =
      "obj_info whatever this is\nelement camera 1\nproperty list ushort double view\nproperty int8 on\n"
      "element nothing 18446744073709551615\nelement vertex 1\nproperty uchar blue\nproperty double z\n"
      "property list int8 float32 weights\nproperty int16 y\nproperty float64 nx\nproperty float ny\n"
      "property float nz\nproperty uint32 x\nproperty ushort green\nproperty float red\n";
  for (const bool big : {false, true}) {
    const std::string data = bytesOf(std::uint16_t{2}, big) + bytesOf(1.0, big) + bytesOf(2.0, big) + "\x01" +
                             "\x10" + bytesOf(0.5, big) + "\x01" + bytesOf(9.F, big) +
                             bytesOf(std::int16_t{-7}, big) + bytesOf(0.0, big) + bytesOf(0.F, big) +
                             bytesOf(-2.F, big) + bytesOf(std::uint32_t{12}, big) +
                             bytesOf(std::uint16_t{65535}, big) + bytesOf(0.2F, big);
    const PointCloud cloud =
        read(header(big ? "binary_big_endian" : "binary_little_endian", elements) + data);
    EXPECT_THAT(cloud.points, ElementsAre(cv::Point3f(12, -7, 0.5F)));
    EXPECT_THAT(cloud.normals, ElementsAre(cv::Point3f(0, 0, -1)));
    EXPECT_THAT(cloud.colors, ElementsAre(cv::Vec3b(16, 255, 51)));
  }
  const PointCloud cloud =
      read(header("ascii", elements) + "2 1 2 1\n16 0.5 3 7 7 7 -7 0 0 0 12 65535 0.2\n");
  EXPECT_THAT(cloud.points, ElementsAre(cv::Point3f(12, -7, 0.5F)));
  EXPECT_TRUE(std::isnan(cloud.normals.at(0).x));  // 0 0 0 has no direction
  EXPECT_THAT(cloud.colors, ElementsAre(cv::Vec3b(16, 255, 51)));
}

PointCloud three() {
  PointCloud cloud;
  cloud.points = {{0.1F, 1e-8F, -3}, {kNaN, 1, 1}, {1.F / 3, 2e7F, 5}};
  for (const int c : {1, 4, 255}) cloud.colors.emplace_back(c, c / 2, 255 - c);
  cloud.normals = {{0, 0, -1}, {1, 0, 0}, {0.6F, 0.8F, 0}};
  cloud.width = 3;
  cloud.height = 1;
  return cloud;
}

TEST_F(Ply, WhatIsWrittenIsReadAgain) {
  for (const bool ascii : {false, true}) {
    const PointCloud cloud = three();
    writePly(cloud, folder_ / "a.ply", {{0, 2}}, ascii);
    const PointCloud again = readPly(folder_ / "a.ply");
    EXPECT_THAT(again.points, ElementsAre(cloud.points[0], cloud.points[2]));
    EXPECT_THAT(again.colors, ElementsAre(cloud.colors[0], cloud.colors[2]));
    EXPECT_THAT(again.normals, ElementsAre(cloud.normals[0], cloud.normals[2]));
  }
}

TEST_F(Ply, WritesWhatTheFormatSays) {
  PointCloud cloud = three();
  cloud.normals.clear();
  writePly(cloud, folder_ / "a.ply", {{2, 0}}, true);
  const std::string colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string vertices =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n" + colors;
  const std::string edges = "element edge 1\nproperty int vertex1\nproperty int vertex2\n";
  EXPECT_EQ(test::readFile(folder_ / "a.ply"),
            "ply\nformat ascii 1.0\n" + vertices + edges +
                "end_header\n0.1 1e-08 -3 254 0 1\n0.33333334 20000000 5 0 127 255\n1 0\n");
  cloud.points.resize(1);
  cloud.colors.clear();
  cloud.width = 1;
  writePly(cloud, folder_ / "a.ply");
  EXPECT_EQ(test::readFile(folder_ / "a.ply"),
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n" +
                bytesOf(0.1F) + bytesOf(1e-8F) + bytesOf(-3.F));
}

TEST_F(Ply, RefusesToWriteWhatIsNoCloud) {
  PointCloud cloud = three();
  const auto refusalOf = [&](const PointCloud& refused, const CloudEdges& edges = {}) {
    return test::caught([&] { writePly(refused, folder_ / "a.ply", edges); });
  };
  EXPECT_THAT(refusalOf(cloud, {{0, 3}}), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusalOf(cloud, {{1, 2}}), FailsWith(ErrorCode::invalidInput));  // a hole
  EXPECT_THAT(refusalOf({}), FailsWith(ErrorCode::invalidInput));
  cloud.colors.pop_back();
  EXPECT_THAT(refusalOf(cloud), FailsWith(ErrorCode::invalidInput));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.ply"));
}

TEST_F(Ply, RefusesHugeCountsWithoutTakingTheMemory) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    EXPECT_THAT(refusal(header(format, "element vertex 4294967296" + kPoints.substr(16)) + "1 2 3\n4 5 6\n"),
                FailsWith(ErrorCode::truncatedFile))
        << format;
}

TEST_F(Ply, RefusesWhatIsNoCloud) {
  const std::string list = "element face 1\nproperty list char int vertex_indices\n";
  for (const std::string& text :
       {std::string(),
        std::string("plyformat ascii 1.0\n"),
        "ply\n" + kPoints + "end_header\n",
        "ply\nformat ascii 1.0\n" + kPoints,
        "ply\n" + std::string(100000, '\n'),
        std::string("ply\nproperty float x\n"),
        header("ascii", "element vertex -1\n"),
        header("ascii", "element vertex 1e3\n"),
        header("ascii", "element vertex 99999999999999999999\n"),
        header("ascii", "element vertex 1\nproperty quad x\n"),
        header("ascii", "element vertex 1\nproperty list float int x\n"),
        header("ascii", "element vertex 1\nproperty list uchar int\n"),
        header("ascii", "element vertex 1\nproperty float x\nproperty float y\n") + "1 2\n",
        header("ascii", kPoints + "property float y\n") + "1 2 3 4\n1 2 3 4\n",
        header("ascii", kPoints + kPoints) + "1 2 3\n1 2 3\n1 2 3\n1 2 3\n",
        header("ascii", "element vertex 0\nproperty float x\n"),
        header("ascii", kFaces) + "1 0\n",
        header("ascii", kPoints) + "1 2 3\n10 200\n",
        header("ascii", kPoints) + "1 2 3\n1 2 3 4\n",
        header("ascii", kPoints) + "1 2 3\n1 2 x\n",
        header("ascii", list + kPoints) + "-1\n1 2 3\n1 2 3\n",
        header("ascii", list + kPoints) + "nan\n1 2 3\n1 2 3\n",
        header("binary_little_endian", list + kPoints) + "\xFF" + std::string(24, '\0')})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile)) << text;
  for (const char* text : {"ply\nformat ascii 2.0\n", "ply\nformat b\xC3inary 1.0\n"})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::unsupportedFile)) << text;
  EXPECT_THAT([&] { readPly(folder_ / "none.ply"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(Ply, ReadsTheMeshesOfTheData) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const PointCloud cloud = readPly(*data / "meshes/mario000_0.ply");
  EXPECT_EQ(cloud.points.size(), 12843U);
  EXPECT_EQ(cloud.colors.size(), cloud.points.size());
}

}  // namespace
}  // namespace estancia
