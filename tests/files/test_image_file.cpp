// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "estancia/files/image_decoding.hpp"
#include "estancia/files/image_file.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia::io {
namespace {

using test::encoded;
using test::FailsWith;
using test::texture;

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

TEST_F(ImageFile, NoticesACutWithinTheHeader) {
  for (const char* suffix : {".jpg", ".png", ".bmp", ".webp", ".tif", ".ppm", ".exr", ".hdr"}) {
    const bool radiance = suffix == std::string(".exr") || suffix == std::string(".hdr");
    const std::string whole = encoded(suffix, texture(40, 30, radiance ? CV_32FC3 : CV_8UC3));
    for (std::size_t length = 0; length < 64; ++length)
      EXPECT_TRUE(refusal(std::string("cut") + suffix, whole.substr(0, length)).code)
          << suffix << " of " << length << " bytes";
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
