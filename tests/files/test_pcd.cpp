// Point clouds in PCD files: what PCL writes, what the format allows, and what must be refused.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/pcd.hpp"
#include "estancia/files/ply.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "estancia/files/cloud_file.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/numbers.hpp"

namespace estancia {
namespace {

using test::bytesOf;
using test::FailsWith;
using test::quietNan;
using ::testing::ElementsAre;

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

/// Reads bytes as a file of this name.
class CloudBytes : public ::testing::Test {
 protected:
  explicit CloudBytes(const char* name) : file_(folder_ / name) {}
  PointCloud read(const std::string& bytes) {
    test::writeFile(file_, bytes);
    return readCloud(file_);
  }
  test::Caught refusal(const std::string& bytes) {
    return test::caught([&] { read(bytes); });
  }
  test::ScratchFolder folder_;
  const std::filesystem::path file_;
};

class Pcd : public CloudBytes {
 protected:
  Pcd() : CloudBytes("cloud.pcd") {}
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
};

void expectTwoPoints(const PointCloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.width, 2U);
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_FALSE(cloud.organized());
  EXPECT_EQ(cloud.points[0], cv::Point3f(1, -2.5F, 3));
  EXPECT_EQ(cloud.points[1].y, 5);
  EXPECT_TRUE(std::isnan(cloud.points[1].z));
  EXPECT_THAT(cloud.colors, testing::IsEmpty());
}

TEST_F(Pcd, ReadsItsThreeForms) {
  expectTwoPoints(read(header("ascii") + "1 -2.5 3\n4 5 nan\n"));
  expectTwoPoints(read(header("ascii") + "1 -2.5\t3\r\n\n 4 5 -nan"));
  expectTwoPoints(read(header("binary") + floats({1, -2.5F, 3, 4, 5, quietNan}) + "padding"));
  expectTwoPoints(read(header("binary_compressed") + packed(floats({1, 4, -2.5F, 5, 3, quietNan}))));
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
  for (const PointCloud& one : {cloud, readPcd(folder_ / "again.pcd")})
    EXPECT_THAT(one.viewpoint, ::testing::Optional(::testing::FieldsAre(1, -2, 3.5, 0, 1, 0, 0)));
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

TEST_F(Pcd, AColorMayBeAFloatOfTheSameBits) {
  const std::string fields = "FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nHEIGHT 1\nDATA ";
  EXPECT_EQ(read(fields + "ascii\n1 2 3 4210752\n").colors.at(0), cv::Vec3b(0x80, 0x80, 0x80));
  EXPECT_EQ(read(fields + "binary\n" + floats({1, 2, 3}) + bytesOf(0x00010203U)).colors.at(0),
            cv::Vec3b(3, 2, 1));
}

TEST_F(Pcd, RefusesWhatIsCutShortAndWhatIsDamagedBeyondReading) {
  const std::string files[] = {writtenByPcl(), header("binary") + floats({1, 2, 3, 4, 5, 6}),
                               header("ascii") + "1 2 3\n4 5 6"};
  for (const std::string& file : files) {
    EXPECT_FALSE(refusal(file).code);
    for (std::size_t size = 0; size < file.size(); ++size)
      EXPECT_TRUE(refusal(file.substr(0, size)).code) << size << " of " << file.size() << " bytes";
  }
  EXPECT_THAT(refusal(files[1].substr(0, files[1].size() - 1)), FailsWith(ErrorCode::truncatedFile));
  for (std::size_t at = 0; at < files[0].size(); ++at) {
    std::string damaged = files[0];
    damaged[at] = static_cast<char>(damaged[at] ^ (at % 2 == 0 ? '\x15' : '\x60'));
    EXPECT_TRUE(refusal(damaged).code || readCloud(file_).points.size() == 24U) << at;
  }
}

TEST_F(Pcd, TellsOfNoMorePointsThanItHas) {
  const std::string huge = "WIDTH 2000000000\nHEIGHT 2000000000\n";
  EXPECT_THAT(refusal(header("ascii", huge) + "1 2 3\n"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal(header("binary", huge) + "1 2 3\n"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal(header("binary_compressed", huge) + packed("123")), FailsWith(ErrorCode::corruptFile));
}

TEST_F(Pcd, RefusesHeadersThatContradictThemselves) {
  const std::string whole = header("ascii") + "1 2 3\n4 5 6\n";
  // The line that begins with the same word is replaced.
  const auto refusalOf = [&](const std::string& line) {
    const std::size_t at = whole.find("\n" + line.substr(0, line.find(' '))) + 1;
    return refusal(whole.substr(0, at) + line + whole.substr(whole.find('\n', at)));
  };
  EXPECT_FALSE(refusalOf("FIELDS x y z").code);
  for (const char* line : {"FIELDS x y w", "FIELDS x y", "FIELDS x x z", "SIZE 4 4 2", "SIZE 4 4 four",
                           "TYPE F F X", "COUNT 1 1 2", "COUNT 1 1 0", "COUNT 1 1 70000", "POINTS 3",
                           "WIDTH -2", "WIDTH", "HEIGHT 0", "4 5", "4 5 six"})
    EXPECT_THAT(refusalOf(line), FailsWith(ErrorCode::malformedFile)) << line;
  for (const char* line : {"VERSION 0.5", "DATA zip"})
    EXPECT_THAT(refusalOf(line), FailsWith(ErrorCode::unsupportedFile)) << line;
  EXPECT_THAT(refusal(header("ascii").replace(header("ascii").find("TYPE"), 11, "") + "1 2 3\n4 5 6\n"),
              FailsWith(ErrorCode::malformedFile));
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

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n";
}
const std::string kPoints = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";

class Ply : public CloudBytes {
 protected:
  Ply() : CloudBytes("cloud.ply") {}
};

TEST_F(Ply, ReadsItsThreeForms) {
  expectTwoPoints(read(header("ascii", kPoints) + "1 -2.5 3\n4 5 nan\n"));
  expectTwoPoints(read(header("ascii", kPoints + faces) + "1 -2.5\t3\r\n4 5 nan\n3 0 1 0"));
  for (const bool big : {false, true}) {
    std::string data;
    for (const float value : {1.F, -2.5F, 3.F, 4.F, 5.F, quietNan}) data += bytesOf(value, big);
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    expectTwoPoints(read(header(format, kPoints) + data));
    data += "\x02";
    for (const std::int32_t vertex : {0, 1}) data += bytesOf(vertex, big);
    expectTwoPoints(read(header(format, kPoints + faces) + data));
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

TEST_F(Ply, FacesAreTrianglesAndFansOfThem) {
  const std::string corners =
      kPoints + "element face 2\nproperty uchar flags\nproperty list uchar int vertex_index\n";
  const std::string text = header("ascii", corners) + "1 2 3\n4 5 6\n7 3 1 0 0\n7 4 1 0 0 1\n";
  test::writeFile(file_, text);
  using Triangle = PlyMesh::Triangle;
  EXPECT_THAT(readPlyMesh(file_).triangles,
              ElementsAre(Triangle{1, 0, 0}, Triangle{1, 0, 0}, Triangle{1, 0, 1}));
  EXPECT_EQ(readPlyMesh(file_).vertices.points, readPly(file_).points);
  for (const bool big : {false, true}) {
    std::string data;
    for (const float value : {1.F, 2.F, 3.F, 4.F, 5.F, 6.F}) data += bytesOf(value, big);
    data += "\x03";
    for (const std::int32_t vertex : {1, 0, 1}) data += bytesOf(vertex, big);
    test::writeFile(file_,
                    header(big ? "binary_big_endian" : "binary_little_endian", kPoints + faces) + data);
    EXPECT_THAT(readPlyMesh(file_).triangles, ElementsAre(Triangle{1, 0, 1}));
  }
}

TEST_F(Ply, RefusesFacesOfVerticesThatAreNotThere) {
  const std::string vertices = "1 2 3\n4 5 6\n";
  for (const std::string& text :
       {header("ascii", kPoints + faces) + vertices + "3 0 1 2\n",
        header("ascii", kPoints + faces) + vertices + "3 0 1 -1\n",
        header("ascii", kPoints + faces) + vertices + "3 0 1 nan\n",
        header("ascii", faces + kPoints) + "3 0 1 0\n" + vertices,
        header("ascii", kPoints + "element face 1\nproperty int on\n") + vertices + "3\n"}) {
    test::writeFile(file_, text);
    EXPECT_THAT([&] { readPlyMesh(file_); }, FailsWith(ErrorCode::malformedFile)) << text;
    EXPECT_EQ(readPly(file_).points.size(), 2U) << "faces do not matter to it";
  }
}

PointCloud three() {
  PointCloud cloud = test::cloudOf({{0.1F, 1e-8F, -3}, {quietNan, 1, 1}, {1.F / 3, 2e7F, 5}},
                                   {{1, 0, 254}, {4, 2, 251}, {255, 127, 0}});
  cloud.normals = {{0, 0, -1}, {1, 0, 0}, {0.6F, 0.8F, 0}};
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

TEST_F(Ply, DamageMakesNoPointsThatAreNotThere) {
  for (const std::string& whole : {header("ascii", kPoints + faces) + "1 -2.5 3\n4 5 6\n3 0 1 0\n",
                                   header("binary_little_endian", kPoints + faces) + std::string(25, '\1')})
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (at % 2 == 0 ? '\1' : '\x15'));
      EXPECT_TRUE(refusal(damaged).code || readCloud(file_).points.size() <= 3U) << at;
    }
}

TEST_F(Ply, RefusesWhatIsNoCloud) {
  const std::string list = "element face 1\nproperty list char int vertex_indices\n";
  for (const std::string& text :
       {std::string(), std::string("plyformat ascii 1.0\n"), "ply\n" + kPoints + "end_header\n",
        "ply\nformat ascii 1.0\n" + kPoints, "ply\n" + std::string(100000, '\n'),
        std::string("ply\nproperty float x\n"), std::string("ply\nformat ascii\n"),
        header("binary_little_endian", list + kPoints) + "\xFF" + std::string(24, '\0')})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile)) << text;
  const std::string one = "element vertex 1\nproperty ";
  for (const std::string& elements :
       {std::string("element vertex\n"), std::string("property float x\n"),
        std::string("element vertex -1\n"), std::string("element vertex 1e3\n"),
        std::string("element vertex 99999999999999999999\n"), one + "quad x\n", one + "list float int x\n",
        one + "list uchar int\n", std::string("element vertex 0\nproperty float x\n")})
    EXPECT_THAT(refusal(header("ascii", elements)), FailsWith(ErrorCode::malformedFile)) << elements;
  for (const auto& [elements, data] : std::vector<std::pair<std::string, const char*>>{
           {one + "list uchar float x\nproperty float y\nproperty float z\n", "1 2 3 4\n"},
           {one + "float x\nproperty float y\n", "1 2\n"},
           {faces, "1 0\n"},
           {kPoints + "property float y\n", "1 2 3 4\n1 2 3 4\n"},
           {kPoints + kPoints, "1 2 3\n1 2 3\n1 2 3\n1 2 3\n"},
           {kPoints, "1 2 3\n10 200\n"},
           {kPoints, "1 2 3\n1 2 3 4\n"},
           {kPoints, "1 2 3\n1 2 x\n"},
           {list + kPoints, "-1\n1 2 3\n1 2 3\n"},
           {list + kPoints, "nan\n1 2 3\n1 2 3\n"}})
    EXPECT_THAT(refusal(header("ascii", elements) + data), FailsWith(ErrorCode::malformedFile))
        << elements << data;
  for (const char* text : {"ply\nformat ascii 2.0\n", "ply\nformat b\xC3inary 1.0\n"})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::unsupportedFile)) << text;
  EXPECT_THAT([&] { readPly(folder_ / "none.ply"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(Ply, ReadsTheMeshesOfTheData) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const PointCloud cloud = readPly(*data / "meshes/mario000_0.ply");
  EXPECT_EQ(cloud.points.size(), 12843U);
  EXPECT_EQ(readPlyMesh(*data / "meshes/mario000_0.ply").triangles.size(), 24501U);
  EXPECT_EQ(cloud.colors.size(), cloud.points.size());
}

}  // namespace
}  // namespace estancia
