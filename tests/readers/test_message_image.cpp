// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/message_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "estancia/readers/undistortion.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"

namespace estancia::io {
namespace {

ros::ImageMessage messageOf(const cv::Mat& pixels, const std::string& encoding, std::uint32_t width,
                            std::uint32_t height) {
  ros::ImageMessage message;
  message.width = width;
  message.height = height;
  message.encoding = encoding;
  message.step = static_cast<std::uint32_t>(pixels.step);
  message.data = {reinterpret_cast<const std::byte*>(pixels.data), pixels.total() * pixels.elemSize()};
  return message;
}
ros::ImageMessage messageOf(const cv::Mat& pixels, const std::string& encoding) {
  return messageOf(pixels, encoding, static_cast<std::uint32_t>(pixels.cols),
                   static_cast<std::uint32_t>(pixels.rows));
}

/// A smooth scene with saturated colors in BGR.
cv::Mat colorScene() {
  cv::Mat scene(48, 64, CV_8UC3);
  for (int y = 0; y < scene.rows; ++y)
    for (int x = 0; x < scene.cols; ++x)
      scene.at<cv::Vec3b>(y, x) =
          cv::Vec3b(40, static_cast<uchar>(2 * y + 60), static_cast<uchar>(2 * x + 90));
  return scene;
}

double meanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

/// A Bayer mosaic: `pattern` has the colors of the pixels of a 2 × 2 block, "RGGB".
cv::Mat mosaicOf(const cv::Mat& bgr, const char* pattern) {
  cv::Mat mosaic(bgr.size(), CV_8U);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const char color = pattern[(y % 2) * 2 + x % 2];
      mosaic.at<uchar>(y, x) = bgr.at<cv::Vec3b>(y, x)[color == 'B' ? 0 : color == 'G' ? 1 : 2];
    }
  return mosaic;
}

TEST(MessageImage, EveryEncodingShowsTheScene) {
  const cv::Mat scene = colorScene();
  cv::Mat stored;
  EXPECT_EQ(meanDifference(imageOf(messageOf(scene, "bgr8")), scene), 0);
  cv::cvtColor(scene, stored, cv::COLOR_BGR2RGB);
  EXPECT_EQ(meanDifference(imageOf(messageOf(stored, "rgb8")), scene), 0);
  cv::cvtColor(scene, stored, cv::COLOR_BGR2RGBA);
  EXPECT_EQ(meanDifference(imageOf(messageOf(stored, "rgba8")), scene), 0);
  stored.convertTo(stored, CV_16U, 257);
  EXPECT_EQ(meanDifference(imageOf(messageOf(stored, "rgba16")), scene), 0);
  for (const auto& [encoding, pattern] : {std::pair("bayer_rggb8", "RGGB"),
                                          {"bayer_bggr8", "BGGR"},
                                          {"bayer_gbrg8", "GBRG"},
                                          {"bayer_grbg8", "GRBG"}})
    EXPECT_LT(meanDifference(imageOf(messageOf(mosaicOf(scene, pattern), encoding)), scene), 3) << encoding;
}

TEST(MessageImage, YuvIsReadInBothOrders) {
  // Gray of luminance 128 with V above the middle: reddish. UYVY and YUYV differ in the order of bytes.
  cv::Mat uyvy(4, 4, CV_8UC2), yuyv(4, 4, CV_8UC2);
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y) {
      const uchar chroma = x % 2 == 0 ? 128 : 200;
      uyvy.at<cv::Vec2b>(y, x) = {chroma, 128};
      yuyv.at<cv::Vec2b>(y, x) = {128, chroma};
    }
  const cv::Vec3b one = imageOf(messageOf(uyvy, "yuv422")).at<cv::Vec3b>(1, 1);
  EXPECT_EQ(one, imageOf(messageOf(yuyv, "yuv422_yuy2")).at<cv::Vec3b>(1, 1));
  EXPECT_GT(one[2], one[0] + 50);
}

TEST(MessageImage, BigEndianDepthIsSwapped) {
  cv::Mat stored(1, 2, CV_16U);
  stored.at<std::uint16_t>(0, 0) = 0xE803;  // 1000 with its bytes swapped
  stored.at<std::uint16_t>(0, 1) = 0;
  ros::ImageMessage message = messageOf(stored, "16UC1");
  message.bigEndian = true;
  const cv::Mat depth = depthOf(message, 0);
  EXPECT_EQ(depth.at<float>(0, 0), 1.0F);
  EXPECT_EQ(depth.at<float>(0, 1), 0.0F);
}

TEST(MessageImage, AMessageThatIsTooSmallOrHugeIsRefused) {
  const cv::Mat scene = colorScene();
  EXPECT_THAT([&] { imageOf(messageOf(scene, "bgr8", 64, 49)); }, test::FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { imageOf(messageOf(scene, "bgr8", 65, 48)); }, test::FailsWith(ErrorCode::malformedFile));
  const auto sized = [&scene](std::uint32_t width, std::uint32_t height) {
    return test::caught([&] { imageOf(messageOf(scene, "bgr8", width, height)); });
  };
  constexpr std::uint32_t huge = 0xffffffff;
  for (const auto& none : {sized(0, 48), sized(64, 0)})
    EXPECT_THAT(none, test::FailsWith(ErrorCode::malformedFile));
  for (const auto& beyond : {sized(huge, huge), sized(huge, 1), sized(1, huge)})
    EXPECT_THAT(beyond, test::FailsWith(ErrorCode::tooLarge));
  EXPECT_THAT([&] { imageOf(messageOf(scene, "xyz")); }, test::FailsWith(ErrorCode::unsupportedFile));
  ros::ImageMessage step = messageOf(scene, "bgr8");
  step.step = 0;
  EXPECT_EQ(meanDifference(imageOf(step), scene), 0) << "rows without a gap";
  step.step = 0xffffffff;
  EXPECT_THAT([&] { imageOf(step); }, test::FailsWith(ErrorCode::malformedFile));
  ros::ImageMessage halves = messageOf(cv::Mat(4, 4, CV_16U, cv::Scalar(7)), "16UC1", 2, 2);
  halves.step = 5;  // the second row would begin inside of a number
  EXPECT_THAT([&] { depthOf(halves, 1000); }, test::FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { depthOf(messageOf(scene, "bgr8"), 0); }, test::FailsWith(ErrorCode::unsupportedFile));
}

/// The format of compressed_depth_image_transport: 12 bytes, then the image.
ros::CompressedImageMessage compressedDepth(std::string& bytes, const std::string& format, float a, float b,
                                            const std::string& body) {
  bytes.assign(4, '\0');
  bytes.append(reinterpret_cast<const char*>(&a), 4)
      .append(reinterpret_cast<const char*>(&b), 4)
      .append(body);
  return {{}, format, {reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}};
}

std::string pngOf(const cv::Mat& image) {
  std::vector<uchar> png;
  cv::imencode(".png", image, png);
  return {png.begin(), png.end()};
}

TEST(CompressedDepth, MillimetersAndQuantizedFloatsAreMeters) {
  cv::Mat raw(2, 2, CV_16U, cv::Scalar(0));
  raw.at<std::uint16_t>(0, 1) = 1500;
  std::string bytes;
  const auto whole = compressedDepth(bytes, "16UC1; compressedDepth png", 0, 0, pngOf(raw));
  EXPECT_EQ(contentOf(whole), ImageContent::depth);
  EXPECT_EQ(depthOf(whole, 0).at<float>(0, 1), 1.5F);
  EXPECT_EQ(depthOf(whole, 0).at<float>(0, 0), 0.0F);
  // z = a / (v − b) = 3000 / (1500 − 500)
  const cv::Mat floats =
      depthOf(compressedDepth(bytes, "32FC1; compressedDepth png", 3000, 500, pngOf(raw)), 0);
  EXPECT_EQ(floats.at<float>(0, 1), 3.0F);
  EXPECT_EQ(floats.at<float>(0, 0), 0.0F);
}

TEST(CompressedDepth, RvlIsReadAndItsDamageToo) {
  const std::vector<std::uint16_t> values = {0, 0, 1000, 1004, 990, 0, 40000, 1, 0, 0, 0, 0};
  // 4 × 3 pixels, and what the program in Wilson's paper makes of them.
  const std::uint32_t words[] = {4, 3, 0x238AF381, 0xB312C8B8, 0xB2DF9CB2, 0x40000000};
  const std::string body(reinterpret_cast<const char*>(words), sizeof words);
  std::string bytes;
  const auto message = compressedDepth(bytes, "16UC1; compressedDepth rvl", 0, 0, body);
  const cv::Mat depth = depthOf(message, 0);
  ASSERT_EQ(depth.size(), cv::Size(4, 3));
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(depth.at<float>(static_cast<int>(i / 4), static_cast<int>(i % 4)), values[i] / 1000.0, 1e-4);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    auto part = message;
    part.data = part.data.first(cut);
    EXPECT_THROW(depthOf(part, 0), Error) << cut;
  }
  bytes[12] = bytes[13] = bytes[14] = bytes[15] = '\xff';
  EXPECT_THAT([&] { depthOf(message, 0); }, test::FailsWith(ErrorCode::tooLarge));
  for (const std::uint32_t word : {0xFFFFFFFFU, 0xF7000000U, 0x00000000U}) {  // too long; more than 12; none
    const std::string damaged = body.substr(0, 8) + std::string(reinterpret_cast<const char*>(&word), 4) +
                                std::string(reinterpret_cast<const char*>(&word), 4);
    EXPECT_THAT([&] { depthOf(compressedDepth(bytes, "16UC1; compressedDepth rvl", 0, 0, damaged), 0); },
                test::FailsWith(ErrorCode::malformedFile));
  }
  const cv::Mat eightBits(2, 2, CV_8U, cv::Scalar(7));
  EXPECT_THAT(
      [&] { depthOf(compressedDepth(bytes, "32FC1; compressedDepth png", 3000, 500, pngOf(eightBits)), 0); },
      test::FailsWith(ErrorCode::unsupportedFile));
}

TEST(MessageCloud, AnOrganizedCloudIsDepth) {
  // 2 × 1 points of x, y, z, and a hole.
  const float points[] = {0.1F, 0, 1.5F, std::nanf(""), std::nanf(""), std::nanf("")};
  ros::PointCloudMessage message;
  message.height = 1;
  message.width = 2;
  message.pointStep = 12;
  for (std::uint32_t i = 0; i < 3; ++i) message.fields.push_back({std::string(1, "xyz"[i]), 4 * i, 7, 1});
  message.data = std::as_bytes(std::span(points));
  EXPECT_EQ(contentOf(message), ImageContent::unknown) << "one row is no image";
  message.height = 2;
  message.width = 1;
  EXPECT_EQ(contentOf(message), ImageContent::depth);
  const cv::Mat depth = depthOf(message);
  EXPECT_EQ(depth.at<float>(0), 1.5F);
  EXPECT_EQ(depth.at<float>(1), 0);
  message.width = 2;
  EXPECT_THAT([&] { depthOf(message); }, test::FailsWith(ErrorCode::malformedFile));
  message.width = 1;
  message.fields[2].offset = 0xfffffff0;
  EXPECT_THAT([&] { depthOf(message); }, test::FailsWith(ErrorCode::malformedFile));
  message.width = message.height = 0xFFFFFFFF;
  EXPECT_THAT([&] { depthOf(message); }, test::FailsWith(ErrorCode::tooLarge));
  message.width = message.height = 1;
  message.fields[2] = {"z", 8, 99, 1};
  EXPECT_THAT([&] { depthOf(message); }, test::FailsWith(ErrorCode::malformedFile)) << "no such type";
  message.fields[2] = {"z", 8, 7, 1};
  message.fields.push_back({"rgba", 0, 6, 1});
  EXPECT_EQ(cloudOf(message).colors.size(), 1U);
  message.bigEndian = true;
  EXPECT_EQ(cloudOf(message).colors.at(0)[0], 0x3d) << "of 0.1F, the other way round";
  message.fields[2].name = "intensity";
  EXPECT_THAT([&] { depthOf(message); }, test::FailsWith(ErrorCode::unsupportedFile));
}

ros::CameraInfo cameraInfo(const std::string& model, std::vector<double> distortion) {
  ros::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortionModel = model;
  info.distortion = std::move(distortion);
  info.matrix = {300, 0, 319.5, 0, 300, 239.5, 0, 0, 1};
  return info;
}

/// The pixel of a fisheye camera (r = f θ) that sees the direction (x, y, 1).
cv::Point2d fisheyePixel(double x, double y) {
  const double slope = std::hypot(x, y), theta = std::atan(slope);
  return {319.5 + 300 * theta * x / slope, 239.5 + 300 * theta * y / slope};
}

TEST(Undistortion, AThingIsSeenAlongItsRayAfterIt) {
  // Where the lens draws a point of light that lies in the direction (x, y, 1).
  const auto radial = [](double x, double y) {
    const double stretch = 1 - 0.1 * (x * x + y * y);
    return cv::Point2d(319.5 + 300 * x * stretch, 239.5 + 300 * y * stretch);
  };
  using Lens = std::tuple<const char*, std::vector<double>, std::function<cv::Point2d(double, double)>>;
  std::vector<Lens> lenses;
  for (const char* model : {"equidistant", "fisheye", "kannala_brandt"})
    lenses.emplace_back(model, std::vector<double>{1e-9, 0, 0, 0}, fisheyePixel);
  for (const std::size_t count : {1, 4, 5, 8, 12, 14}) {
    std::vector<double> coefficients(count);
    coefficients[0] = -0.1;
    lenses.emplace_back(count == 1  ? ""
                        : count > 5 ? "rational_polynomial"
                                    : "plumb_bob",
                        coefficients, radial);
  }
  for (const auto& [model, coefficients, pixel] : lenses) {
    SCOPED_TRACE(std::string(model) + std::to_string(coefficients.size()));
    const Undistortion lens(cameraInfo(model, coefficients), false);
    ASSERT_TRUE(lens.isNeeded());
    const CameraIntrinsics& camera = lens.camera();
    EXPECT_LE(std::atan(319.5 / camera.fx) * 180 / M_PI, 50.01);
    cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(0));
    cv::circle(image, pixel(0.5, 0.25), 3, cv::Scalar::all(255), cv::FILLED);
    cv::Mat gray;
    cv::cvtColor(lens.image(image), gray, cv::COLOR_BGR2GRAY);
    const cv::Moments light = cv::moments(gray);
    EXPECT_NEAR(light.m10 / light.m00, camera.cx + 0.5 * camera.fx, 1.5);
    EXPECT_NEAR(light.m01 / light.m00, camera.cy + 0.25 * camera.fy, 1.5);
    EXPECT_EQ(lens.image(image(cv::Rect(0, 0, 320, 240)).clone()).size(), cv::Size(320, 240));
  }
}

TEST(Undistortion, RectifiedImagesHaveTheCameraOfTheirProjection) {
  ros::CameraInfo info = cameraInfo("plumb_bob", {-0.1});
  EXPECT_EQ(Undistortion(info, true).camera().fx, 300);
  info.projection = {200, 0, 310, 0, 0, 210, 230, 0, 0, 0, 1, 0};
  const Undistortion rectified(info, true);
  EXPECT_FALSE(rectified.isNeeded());
  EXPECT_THAT(rectified.camera(), testing::FieldsAre(640, 480, 200, 210, 310, 230));
}

TEST(Undistortion, BadCalibrationsAreRefused) {
  EXPECT_THAT([] { Undistortion(ros::CameraInfo{}, false); }, test::FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { Undistortion(cameraInfo("magic", {1}), false); },
              test::FailsWith(ErrorCode::unsupportedFile));
  const std::vector<std::function<void(ros::CameraInfo&)>> changes{
      [](auto& info) { info.distortion = {std::nan("")}; },
      [](auto& info) { info.distortion.resize(15, 0.1); },
      [](auto& info) { info.matrix[0] = 0; },
      [](auto& info) { info.matrix[4] = -1; },
      [](auto& info) { info.matrix[2] = INFINITY; },
      [](auto& info) { info.projection[0] = 1e10; },
      [](auto& info) { info.height = 0; },
      [](auto& info) { info.width = 1 << 15; },
      [](auto& info) { info.height = 1 << 15; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ros::CameraInfo info = cameraInfo("plumb_bob", {0.1});
    changes[i](info);
    EXPECT_THAT([&] { Undistortion(info, false); }, test::FailsWith(ErrorCode::invalidInput)) << i;
  }
}

TEST(DepthRegistration, AWallIsSeenFromTheOtherCamera) {
  const CameraIntrinsics camera{64, 48, 50, 50, 31.5, 23.5};
  cv::Mat wall(48, 64, CV_32F, cv::Scalar(2));
  wall(cv::Rect(20, 10, 10, 10)) = 1;
  // The other camera is 0.1 m to the right: near things move 5 pixels left, far ones 2.5.
  const cv::Mat seen =
      registerDepth(wall, camera, cv::Affine3d(cv::Matx33d::eye(), cv::Vec3d(-0.1, 0, 0)), camera);
  EXPECT_FLOAT_EQ(seen.at<float>(15, 20), 1);
  EXPECT_FLOAT_EQ(seen.at<float>(15, 13), 2);
  EXPECT_FLOAT_EQ(seen.at<float>(40, 40), 2);
  EXPECT_FLOAT_EQ(seen.at<float>(15, 27), 0) << "hidden behind the near thing";
  EXPECT_FLOAT_EQ(seen.at<float>(40, 63), 0) << "not seen by the first camera";
  wall = std::nanf("");
  wall.at<float>(9, 9) = INFINITY;
  wall.at<float>(8, 8) = 2;
  EXPECT_EQ(cv::countNonZero(registerDepth(wall, camera, cv::Affine3d::Identity(), camera)), 1);
  const cv::Affine3d ahead(cv::Matx33d::eye(), cv::Vec3d(0, 0, -3));
  EXPECT_EQ(cv::countNonZero(registerDepth(wall, camera, ahead, camera)), 0) << "behind the other camera";
}

}  // namespace
}  // namespace estancia::io
