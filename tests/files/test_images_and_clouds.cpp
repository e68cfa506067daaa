// Files of images, of clouds, and of depth, which is both.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/cloud_file.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/bytes.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/files/pcd.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/numbers.hpp"

namespace estancia::io {
namespace {

using test::encoded;
using test::FailsWith;
using test::quietNan;
using test::texture;

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
  EXPECT_THAT(cloud.colors, testing::IsEmpty());

  cv::Mat colors(4, 8, CV_8UC3, cv::Scalar(1, 2, 3));
  colors(cv::Rect(4, 0, 4, 4)) = cv::Scalar(7, 8, 9);
  cv::imwrite((folder_ / "colors.png").string(), colors);
  test::writeFile(folder_ / "mine.txt", "8 8 1.5 0.5\n");
  cloud = readCloud(image, {500, folder_ / "mine.txt", folder_ / "colors.png"});
  EXPECT_EQ(cloud.points.at(0), cv::Point3f(-0.75F, -0.25F, 4));
  EXPECT_EQ(cloud.colors.at(5), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(cloud.colors.at(6), cv::Vec3b(7, 8, 9));
}

TEST_F(CloudFile, CoordinatesInOtherUnitsBecomeMeters) {
  PointCloud cloud = organized();
  cloud.points[1] = {1500, -20, 3};
  cloud.viewpoint = Pose{100, 0, -2000};
  writeCloud(cloud, folder_ / "a.pcd");
  const auto in = [&](const std::string& unit) { return readCloud(folder_ / "a.pcd", {.unit = unit}); };
  expectSame(in("m"), cloud);
  EXPECT_EQ(in("mm").points[1], cv::Point3f(1.5F, -0.02F, 0.003F));
  EXPECT_EQ(in("cm").points[1], cv::Point3f(15, -0.2F, 0.03F));
  EXPECT_EQ(in("mm").normals[1], cloud.normals[1]);
  EXPECT_EQ(in("mm").viewpoint->z, -2);
  EXPECT_THAT([&] { in("inch"); }, FailsWith(ErrorCode::unknownName));
  cv::imwrite(folder_ / "depth.png", cv::Mat(2, 4, CV_16U, cv::Scalar(2000)));
  test::writeFile(folder_ / "intrinsics.txt", "4 4 1.5 0.5\n");
  EXPECT_THAT([&] { readCloud(folder_ / "depth.png", {.unit = "mm"}); }, FailsWith(ErrorCode::invalidOption))
      << "its unit is its depth-scale";
}

class ImageFile : public ::testing::Test {
 protected:
  cv::Mat read(const std::string& name, const std::string& bytes) {
    test::writeFile(folder_ / name, bytes);
    return readImage(folder_ / name);
  }
  test::Caught refusal(const std::string& name, const std::string& bytes) {
    return test::caught([&] { read(name, bytes); });
  }
  test::ScratchFolder folder_;
};

void expectPixel(const cv::Mat& image, int row, int column, const cv::Vec3b& bgr, int tolerance = 0) {
  ASSERT_EQ(image.type(), CV_8UC3);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at<cv::Vec3b>(row, column)[c], bgr[c], tolerance);
}

TEST_F(ImageFile, GivesBgrOfEightBitsWhateverIsInside) {
  const cv::Mat gray(4, 6, CV_8U, cv::Scalar(90)), color = test::plain(6, 4, {10, 20, 30});
  expectPixel(read("gray.png", encoded(".png", gray)), 0, 0, {90, 90, 90});
  expectPixel(read("gray.jpg", encoded(".jpg", gray)), 0, 0, {90, 90, 90}, 2);
  expectPixel(read("color.bmp", encoded(".bmp", color)), 3, 5, {10, 20, 30});
  expectPixel(read("color.webp", encoded(".webp", color)), 3, 5, {10, 20, 30}, 3);
  expectPixel(read("color.ppm", encoded(".ppm", color)), 3, 5, {10, 20, 30});
  expectPixel(read("gray.pgm", encoded(".pgm", gray)), 3, 5, {90, 90, 90});
  expectPixel(read("color.tiff", encoded(".tiff", color)), 3, 5, {10, 20, 30});
}

TEST_F(ImageFile, ScalesSixteenBitsDropsAlphaAndTakesFloatAsZeroToOne) {
  const cv::Mat deep(4, 6, CV_16UC3, cv::Scalar(257 * 10, 257 * 20, 65535));
  expectPixel(read("deep.png", encoded(".png", deep)), 1, 1, {10, 20, 255});
  expectPixel(read("deep.tif", encoded(".tif", deep)), 1, 1, {10, 20, 255});
  expectPixel(read("gray.png", encoded(".png", cv::Mat(4, 6, CV_16U, cv::Scalar(257 * 77)))), 1, 1,
              {77, 77, 77});
  expectPixel(read("gray.pgm", encoded(".pgm", cv::Mat(4, 6, CV_16U, cv::Scalar(257 * 77)))), 1, 1,
              {77, 77, 77});
  expectPixel(read("alpha.png", encoded(".png", cv::Mat(4, 6, CV_8UC4, cv::Scalar(10, 20, 30, 0)))), 1, 1,
              {10, 20, 30});
  cv::Mat light(4, 6, CV_32FC3, cv::Scalar(0.2, 0.4, 7));
  light.at<cv::Vec3f>(0, 0)[0] = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat image = read("float.tif", encoded(".tif", light, {cv::IMWRITE_TIFF_COMPRESSION, 1}));
  expectPixel(image, 1, 1, {51, 102, 255});
  expectPixel(image, 0, 0, {0, 102, 255});
}

TEST_F(ImageFile, ConvertsCmykJpeg) {
  const std::string hex =  // 8×8 pixels of pure red in Adobe's inverted CMYK, made with ImageMagick
      "ffd8ffee000e41646f626500640000000002ffdb00430006040506050406060506070706080a100a0a09090a140e0f0c"
      "1017141818171416161a1d251f1a1b231c1616202c20232627292a29191f2d302d283025282928ffdb0043010707070a"
      "080a130a0a13281a161a2828282828282828282828282828282828282828282828282828282828282828282828282828"
      "282828282828282828282828ffc00014080008000804012200021101031101042200ffc4001600010101000000000000"
      "00000000000000000708ffc40014100100000000000000000000000000000000ffc40015010101000000000000000000"
      "00000000000608ffc40014110100000000000000000000000000000000ffda000e040100021103110400003f00a20062"
      "9b5aa407ffd9";
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  expectPixel(read("cmyk.jpg", bytes), 4, 4, {0, 0, 255}, 12);
}

TEST_F(ImageFile, TurnsByTheExifOrientation) {
  cv::Mat wide = test::plain(16, 8, {0, 0, 0});
  wide.colRange(0, 8).setTo(cv::Scalar(255, 255, 255));  // white on the left
  std::string jpeg = encoded(".jpg", wide);
  using namespace std::string_literals;
  const std::string tiff =
      "MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"s;  // orientation 6
  jpeg.insert(2, "\xFF\xE1\0\x22"s + "Exif\0\0"s + tiff);
  const cv::Mat upright = read("turned.jpg", jpeg);  // "the image's left is the top": turn clockwise
  ASSERT_EQ(upright.size(), cv::Size(8, 16));
  EXPECT_EQ(readReducedImage(folder_ / "turned.jpg", 4).size(), cv::Size(4, 8));
  expectPixel(upright, 2, 4, {255, 255, 255}, 5);
  expectPixel(upright, 13, 4, {0, 0, 0}, 5);
  for (const auto& before : {"\xFF\x01"s, "\xFF\xD0"s, "\xFF"s}) {  // a marker alone, padding
    std::string later = jpeg;
    EXPECT_EQ(read("later.jpg", later.insert(2, before)).size(), cv::Size(8, 16));
  }
}

TEST_F(ImageFile, DecodesJpegToTheBitsOfOpencv) {
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(33, 17), cv::Size(1, 1)})
    for (const int progressive : {0, 1})
      for (const int type : {CV_8UC3, CV_8UC1}) {
        const std::string jpeg = encoded(".jpg", texture(size.width, size.height, type),
                                         {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
        const std::vector<uchar> bytes(jpeg.begin(), jpeg.end());
        test::expectSame(read("a.jpg", jpeg), cv::imdecode(bytes, cv::IMREAD_COLOR));
      }
}

TEST_F(ImageFile, TakesTheFirstSizeThatAJpegDeclares) {
  using namespace std::string_literals;
  const std::string jpeg = encoded(".jpg", texture(16, 16));
  const auto frame = [](char high, char low) {  // frame of high·256 + low pixels a side, three colors
    return "\xFF\xC0\0\x11\x08"s + high + low + high + low + "\3\1\x22\0\2\x11\1\3\x11\1"s;
  };
  const std::string huge = jpeg.substr(0, 2) + frame('\xFD', '\xE8') + jpeg.substr(2);
  EXPECT_THAT(refusal("huge.jpg", huge), FailsWith(ErrorCode::tooLarge));
}

TEST_F(ImageFile, ReducesJpegToNoLessThanTheSide) {
  const auto reduced = [this](const std::string& name, const std::string& bytes, int side) {
    test::writeFile(folder_ / name, bytes);
    return readReducedImage(folder_ / name, side);
  };
  const std::string jpeg = encoded(".jpg", texture(640, 480));
  EXPECT_EQ(reduced("a.jpg", jpeg, 241).size(), cv::Size(640, 480));
  EXPECT_EQ(reduced("a.jpg", jpeg, 240).size(), cv::Size(320, 240));
  EXPECT_EQ(reduced("a.jpg", jpeg, 120).size(), cv::Size(160, 120));
  EXPECT_EQ(reduced("a.jpg", jpeg, 1).size(), cv::Size(80, 60));
  EXPECT_EQ(reduced("gray.jpg", encoded(".jpg", texture(40, 30, CV_8U)), 15).type(), CV_8UC3);
  EXPECT_EQ(reduced("a.png", encoded(".png", texture(640, 480)), 120).size(), cv::Size(640, 480));
  const std::vector<uchar> bytes(jpeg.begin(), jpeg.end());
  test::expectSame(reduced("a.jpg", jpeg, 240), cv::imdecode(bytes, cv::IMREAD_REDUCED_COLOR_2));
  EXPECT_THAT([&] { reduced("cut.jpg", jpeg.substr(0, 2000), 120); }, FailsWith(ErrorCode::truncatedFile));
}

TEST_F(ImageFile, NamesWhatIsWrongWithAFile) {
  EXPECT_THAT(refusal("a.jpg", ""), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal("b.jpg", "Dear reader, this is text."), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refusal("c.jpg", "\xFF\xD8\xFF"), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { readImage(folder_ / "none.jpg"); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT(refusal("new\nline.jpg", "text"), FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(ImageFile, NoticesACutAnywhere) {
  const cv::Mat image = texture(40, 30);
  const std::vector<std::pair<std::string, std::string>> whole = {
      {".jpg", encoded(".jpg", image)},
      {".jpg", encoded(".jpg", image, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})},
      {".png", encoded(".png", image)},
      {".bmp", encoded(".bmp", image)},
      {".webp", encoded(".webp", image)},
      {".tif", encoded(".tif", image, {cv::IMWRITE_TIFF_COMPRESSION, 1})},
      {".tif", encoded(".tif", image)},
      {".ppm", encoded(".ppm", image)},
      {".pgm", encoded(".pgm", texture(40, 30, CV_16U))}};
  for (const auto& [suffix, bytes] : whole) {
    ASSERT_FALSE(refusal("whole" + suffix, bytes).code) << suffix;
    for (const double share : {0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
      const auto cut = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
      EXPECT_TRUE(refusal("cut" + suffix, bytes.substr(0, cut)).code) << suffix << " cut at " << share;
      // A crash of the file system leaves the length and loses the content.
      if (suffix == ".jpg" || suffix == ".png") {
        EXPECT_TRUE(
            refusal("lost" + suffix, bytes.substr(0, cut) + std::string(bytes.size() - cut, '\0')).code)
            << suffix << " lost from " << share;
      }
    }
    EXPECT_TRUE(refusal("cut" + suffix, bytes.substr(0, bytes.size() - 1)).code)
        << suffix << " without its end";
  }
}

TEST_F(ImageFile, RefusesHugeDeclaredSizesBeforeAllocating) {
  using namespace std::string_literals;
  std::string png = encoded(".png", texture(4, 4)), jpeg = encoded(".jpg", texture(4, 4)),
              bmp = encoded(".bmp", texture(4, 4)), tiff = encoded(".tif", texture(4, 4));
  png.replace(16, 8, "\0\0\x75\x30\0\0\x75\x30"s);  // 30,000 × 30,000
  EXPECT_THAT(refusal("huge.png", png), FailsWith(ErrorCode::tooLarge));
  jpeg.replace(jpeg.find("\xFF\xC0") + 5, 4, "\xEA\x60\xEA\x60");
  EXPECT_THAT(refusal("huge.jpg", jpeg), FailsWith(ErrorCode::tooLarge));
  bmp.replace(18, 8, "\xFF\xFF\xFF\x7F\xFF\xFF\xFF\x7F");
  EXPECT_THAT(refusal("huge.bmp", bmp), FailsWith(ErrorCode::tooLarge));
  EXPECT_THAT(refusal("huge.ppm", "P6\n900000 900000\n255\nabc"), FailsWith(ErrorCode::tooLarge));
  const auto width = tiff.find("\x00\x01\x03\x00\x01\x00\x00\x00"s);  // tag 256, one SHORT
  ASSERT_NE(width, std::string::npos);
  tiff.replace(width, 12, "\x00\x01\x04\x00\x01\x00\x00\x00\xFF\xFF\xFF\x7F"s);
  EXPECT_THAT(refusal("huge.tif", tiff), FailsWith(ErrorCode::tooLarge));
}

TEST_F(ImageFile, BelievesOfTwoSizesTheOneThatTheDecoderWould) {
  using namespace std::string_literals;
  std::string tiff = encoded(".tif", texture(4, 4));
  const auto entry = [&](char tag) {  // one SHORT
    const auto at = tiff.find(tag + "\x01\x03\x00\x01\x00\x00\x00"s);
    EXPECT_NE(at, std::string::npos);
    return at;
  };
  const auto height = entry('\x01'), compression = entry('\x03');
  tiff.replace(compression, 12, tiff.substr(height, 12));
  tiff.replace(height, 12, "\x01\x01\x04\x00\x01\x00\x00\x00\xFF\xFF\xFF\x7F"s);
  EXPECT_THAT(refusal("two.tif", tiff), FailsWith(ErrorCode::tooLarge));

  std::string exr = encoded(".exr", cv::Mat(4, 8, CV_32FC3, cv::Scalar(1, 2, 3)));
  const std::string window = exr.substr(exr.find("dataWindow"), sizeof "dataWindow" + sizeof "box2i" + 20);
  exr.insert(exr.find(window), window);
  EXPECT_THAT(refusal("two.exr", exr), FailsWith(ErrorCode::malformedFile));
}

TEST_F(ImageFile, TellsRadianceFromImages) {
  const std::string exr = encoded(".exr", cv::Mat(4, 8, CV_32FC3, cv::Scalar(1, 2, 3)));
  EXPECT_THAT(refusal("radiance.png", exr), FailsWith(ErrorCode::unsupportedFile));
  test::writeFile(folder_ / "radiance.exr", exr);
  const cv::Mat radiance = readPanorama(folder_ / "radiance.exr");
  ASSERT_EQ(radiance.type(), CV_32FC3);
  EXPECT_EQ(radiance.at<cv::Vec3f>(3, 7), cv::Vec3f(1, 2, 3));
}

TEST_F(ImageFile, TakesTheRareFormsOfTheFormats) {
  using namespace std::string_literals;
  for (const std::string& pnm : {"P1\n2 1\n1 0\n"s, "P2\n2 1\n255\n7 8\n"s, "P3\n2 1\n255\n1 2 3 4 5 6\n"s,
                                 "P4\n2 1\n\x80"s, "P5 # by hand\n# twice\n2 1\n255\nab"s})
    EXPECT_EQ(read("a.pgm", pnm).size(), cv::Size(2, 1)) << pnm;
  EXPECT_EQ(
      read("a.bmp", "BM\x22\0\0\0\0\0\0\0\x1A\0\0\0\x0C\0\0\0\2\0\1\0\1\0\x18\0"s + "abcdef\0\0"s).size(),
      cv::Size(2, 1))
      << "OS/2";
  for (const std::string& webp : {encoded(".webp", texture(40, 30), {cv::IMWRITE_WEBP_QUALITY, 101}),
                                  encoded(".webp", texture(40, 30, CV_8UC4), {cv::IMWRITE_WEBP_QUALITY, 50})})
    EXPECT_EQ(read("a.webp", webp).size(), cv::Size(40, 30)) << webp.substr(12, 4);
}

TEST_F(ImageFile, RefusesHeadersThatContradictThemselves) {
  using namespace std::string_literals;
  for (const auto& [name, bytes, code] : std::vector<std::tuple<const char*, std::string, ErrorCode>>{
           {"a.pgm", "P4\n64 64\n\x80", ErrorCode::truncatedFile},
           {"a.pgm", "P5\n9999999999 1\n255\nab", ErrorCode::malformedFile},
           {"a.pgm", "P5\n0 1\n255\nab", ErrorCode::malformedFile},
           {"a.pgm", "P7\n1 1\n", ErrorCode::unsupportedFile},
           {"a.tif", "MM\0*\0\0\0\x08\xFF\xFF"s, ErrorCode::truncatedFile},
           {"a.tif", "II*\0\xFF\xFF\0\0"s, ErrorCode::truncatedFile},
           {"a.tif", "II+\0\x08\0\0\0\x10\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"s, ErrorCode::malformedFile},
           {"a.bmp", "BM"s + std::string(40, '\0'), ErrorCode::malformedFile},
           {"a.webp", "RIFF\4\0\0\0WEBP"s + std::string(20, '\0'), ErrorCode::malformedFile},
           {"a.webp", "RIFF\x18\0\0\0WEBPVP8 \xFF\0\0\0"s + std::string(12, '\0'), ErrorCode::malformedFile},
           {"a.webp", "RIFF\x18\0\0\0WEBPVP8L\4\0\0\0"s + std::string(12, '\0'), ErrorCode::malformedFile}})
    EXPECT_THAT(refusal(name, bytes), FailsWith(code)) << bytes;
  for (const char* size : {"-Y 0 +X 4", "-Y 4 +X x", "-Y 4", "-Y 1e9 +X 4", "-Y 4 +X 0"}) {
    test::writeFile(folder_ / "a.hdr", "#?RADIANCE\n\n"s + size + "\n");
    EXPECT_THAT([&] { readPanorama(folder_ / "a.hdr"); }, FailsWith(ErrorCode::malformedFile)) << size;
  }
}

TEST_F(ImageFile, NoticesACutAndDamageWithinTheHeader) {
  for (const char* suffix : {".jpg", ".png", ".bmp", ".webp", ".tif", ".ppm", ".exr", ".hdr"}) {
    const bool radiance = suffix == std::string(".exr") || suffix == std::string(".hdr");
    const std::string whole = encoded(suffix, texture(40, 30, radiance ? CV_32FC3 : CV_8UC3));
    for (std::size_t length = 0; length < 64; ++length)
      EXPECT_TRUE(refusal(std::string("cut") + suffix, whole.substr(0, length)).code)
          << suffix << " of " << length << " bytes";
    // Nothing but an Error is thrown, and no more allocated than the file can hold.
    for (std::size_t at = 0; at < 64; ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(at % 3 == 0 ? '1' : 0xFF - damaged[at]);
      const test::Caught caught = refusal(std::string("damaged") + suffix, damaged);
      EXPECT_TRUE(caught.code || at > 1) << suffix << " " << at;
    }
  }
  const std::string webp = encoded(".webp", texture(40, 30));
  for (std::size_t length = 4; length < 30; ++length)
    EXPECT_THAT(refusal("cut.webp", webp.substr(0, length)), FailsWith(ErrorCode::truncatedFile)) << length;
  using namespace std::string_literals;
  EXPECT_THAT(refusal("short.webp", "RIFF\0\0\0\0"s), FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT(refusal("song.wav", "RIFF\x24\0\0\0WAVE"s), FailsWith(ErrorCode::unsupportedFile));
}

}  // namespace
}  // namespace estancia::io
