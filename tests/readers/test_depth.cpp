// Depth images of each kind and of each data set, and the intrinsics of cameras.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "estancia/files/camera_file.hpp"
#include "estancia/files/depth_file.hpp"
#include "readers/sequence_folder.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::encoded;
using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const float kNan = std::numeric_limits<float>::quiet_NaN();

/// A depth image with two pixels.
template <typename T>
cv::Mat two(int type, T first, T second) {
  cv::Mat raw(1, 2, type);
  raw.at<T>(0, 0) = first;
  raw.at<T>(0, 1) = second;
  return raw;
}

class DepthFiles : public test::SequenceFolder {
 protected:
  void writeDepth(const std::string& name, std::uint16_t raw, cv::Size size = {2, 1}) {
    write(name, encoded(".png", cv::Mat(size, CV_16U, cv::Scalar(raw))));
  }
  std::vector<float> read(const std::string& name, const cv::Mat& raw, double scale = 0) {
    write(name, encoded(name.substr(name.find('.')), raw));
    const cv::Mat meters = io::readDepth(folder_ / name, scale);
    EXPECT_EQ(meters.type(), CV_32F);
    return {meters.begin<float>(), meters.end<float>()};
  }
  static float depthOf(const Sequence& sequence, std::size_t i) { return sequence.depth(i).at<float>(0, 0); }
};

TEST_F(DepthFiles, AreReadAsMetersWhateverTheirKind) {
  EXPECT_THAT(read("mm.png", two<std::uint16_t>(CV_16U, 1500, 0)), ElementsAre(1.5F, 0));
  EXPECT_THAT(read("none.png", two<std::uint16_t>(CV_16U, 65535, 65534)), ElementsAre(0, 65.534F));
  EXPECT_THAT(read("tum.png", two<std::uint16_t>(CV_16U, 5000, 10000), 5000), ElementsAre(1, 2));
  EXPECT_THAT(read("coarse.png", two<uchar>(CV_8U, 51, 255)), ElementsAre(2, 10));
  EXPECT_THAT(read("gray.png", cv::Mat(1, 2, CV_8UC3, cv::Scalar::all(51))), ElementsAre(2, 2));
  EXPECT_THAT(read("float.tiff", two<float>(CV_32F, 1.25F, kNan)), ElementsAre(1.25F, 0));
  EXPECT_THAT(read("float.exr", two<float>(CV_32F, 1.25F, -1)), ElementsAre(1.25F, 0));
  EXPECT_THAT(read("float.pfm", two<float>(CV_32F, 1.25F, INFINITY)), ElementsAre(1.25F, 0));
  EXPECT_THAT(read("mm.pfm", two<float>(CV_32F, 1250, 1e38F), 1000), ElementsAre(1.25F, 0));
  EXPECT_THAT(read("mm.pgm", two<std::uint16_t>(CV_16U, 1500, 1)), ElementsAre(1.5F, 0.001F));
}

TEST_F(DepthFiles, RefuseColorsDamageAndSigns) {
  cv::Mat colors(1, 2, CV_8UC3, cv::Scalar(255, 0, 0));
  EXPECT_THAT([&] { read("jet.png", colors); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { read("signed.tiff", two<std::int16_t>(CV_16S, 1, -1)); },
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { io::readDepth(folder_ / "missing.png", 0); }, FailsWith(ErrorCode::fileNotFound));
  const std::string whole = encoded(".png", test::texture(64, 48, CV_16U));
  write("cut.png", whole.substr(0, whole.size() / 2));
  EXPECT_THAT([&] { io::readDepth(folder_ / "cut.png", 0); }, FailsWith(ErrorCode::truncatedFile));
  for (const char* header :
       {"", "Pf\n2 1\n-1\n", "Pf\n99999 99999\n-1\n", "Pf\n-1 2\n-1\n", "Pf\nnan 2\n-1\n"}) {
    write("a.pfm", header);
    EXPECT_TRUE(test::caught([&] { io::readDepth(folder_ / "a.pfm", 0); }).code) << header;
  }
}

TEST_F(DepthFiles, LeaveNothingInTheTemporaryFolder) {
  setenv("OPENCV_TEMP_PATH", folder_.path().c_str(), 1);
  const auto isRefused = [this](const std::string& header) {
    write("depth.pfm", header + std::string(64, '\1'));
    return test::caught([&] { io::readDepth(folder_ / "depth.pfm", 0); }).code.has_value();
  };
  EXPECT_FALSE(isRefused("Pf\n4 2\n-1\n"));
  EXPECT_FALSE(isRefused("Pf\n4\t2\r-1 "));
  for (const std::string& sides : {std::string("4 \n2"), std::string("4  2"), std::string("\n4 2"),
                                   std::string("4 0"), std::string("1e0 2"), std::string(3000, '0') + "4 2"})
    EXPECT_TRUE(isRefused("Pf\n" + sides + "\n-1\n")) << sides;
  unsetenv("OPENCV_TEMP_PATH");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(DepthFiles, InAFolderBesideImagesArePairedByTheirNames) {
  for (const char* name : {"rgb/9.png", "rgb/10.png", "rgb/11.png"}) add(name);
  writeDepth("depth/9.png", 900);
  writeDepth("depth/11.png", 1100, {64, 48});
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_TRUE(sequence->hasDepth());
  EXPECT_EQ(sequence->frame(1).name, "10.png");
  EXPECT_EQ(depthOf(*sequence, 0), 0.9F);
  EXPECT_EQ(depthOf(*sequence, 2), 1.1F);
  EXPECT_EQ(sequence->depth(2).size(), cv::Size(64, 48)) << "its own size";
  EXPECT_THAT([&] { sequence->depth(1); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_EQ(sequence->image(0).size(), cv::Size(4, 3));
  EXPECT_EQ(sequence->fingerprint(0), openSequence(folder_ / "rgb")->fingerprint(0));
}

TEST_F(DepthFiles, InAFolderBesideTimedImagesArePairedByTime) {
  for (const char* name : {"color/10.000000.png", "color/10.033333.png", "color/10.066667.png"}) add(name);
  writeDepth("depth/9.991000.png", 1000);
  writeDepth("depth/10.040000.png", 2000);
  writeDepth("depth/10.120000.png", 3000);
  const auto sequence = open();
  EXPECT_EQ(depthOf(*sequence, 0), 1);
  EXPECT_EQ(depthOf(*sequence, 1), 2);
  EXPECT_THAT([&] { sequence->depth(2); }, FailsWith(ErrorCode::insufficientData)) << "0.027 s is too far";
  EXPECT_EQ(sequence->depthTimestamp(0), 9.991);
  EXPECT_EQ(sequence->depthTimestamp(2), 10.04);
}

TEST_F(DepthFiles, MayBeInOtherUnits) {
  add("rgb/a.png");
  writeDepth("depth/a.png", 1000);
  options_.depthScale = 5000;
  EXPECT_EQ(depthOf(*open(), 0), 0.2F);
  for (const double scale : {-1.0, 1e300, 1e-300, std::nan(""), static_cast<double>(INFINITY)}) {
    options_.depthScale = scale;
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::invalidOption)) << scale;
  }
}

TEST_F(DepthFiles, OfTumAreTheNearestInTime) {
  for (const char* name : {"rgb/1.png", "rgb/2.png", "rgb/3.png"}) add(name);
  write("rgb.txt", "1.00 rgb/1.png\n1.03 rgb/2.png\n1.50 rgb/3.png\n");
  write("depth.txt", "# depth maps\n1.045 depth/b.png\n1.012 depth/a.png\n");
  writeDepth("depth/a.png", 5000);
  writeDepth("depth/b.png", 10000);
  const auto sequence = open();
  EXPECT_EQ(depthOf(*sequence, 0), 1) << "5000 units are a meter";
  EXPECT_EQ(depthOf(*sequence, 1), 2);
  EXPECT_THAT([&] { sequence->depth(2); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_EQ(sequence->depthTimestamp(2), 1.045);
  EXPECT_FALSE(sequence->intrinsics()) << "no camera is published for this folder";
  EXPECT_THAT(sequence->warnings(), IsEmpty());
}

TEST_F(DepthFiles, OfTumAreLeftOutWithTheirListWhenItIsWrong) {
  write("rgb.txt", "1.00 rgb/1.png\n2.00 rgb/1.png\n");
  write("depth.txt", "noon depth/a.png\n");
  EXPECT_FALSE(open()->hasDepth());
  EXPECT_THAT(open()->warnings(), ::testing::Contains(Mentions({"depth.txt"})));
}

TEST_F(DepthFiles, OfTumComeWithThePublishedCamera) {
  const fs::path data = folder_ / "rgbd_dataset_freiburg3_office";
  test::writeFile(data / "1.png", encoded(".png", test::plain(4, 3, {1, 2, 3})));
  test::writeFile(data / "rgb.txt", "1.00 1.png\n");
  EXPECT_EQ(openSequence(data)->intrinsics()->fx, 535.4);
}

class Intrinsics : public DepthFiles {
 protected:
  CameraIntrinsics read(const std::string& text) {
    write("camera", text);
    return io::readIntrinsics(folder_ / "camera");
  }
  using DepthFiles::refusal;
  test::Caught refusal(const std::string& text) {
    return test::caught([&] { read(text); });
  }
};

void expectCamera(const CameraIntrinsics& camera, int width = 0, int height = 0) {
  EXPECT_THAT(camera, ::testing::FieldsAre(width, height, 517.3, 516.5, 318.6, 255.25));
}

TEST_F(Intrinsics, AreReadFromWhatPeopleHave) {
  expectCamera(read("517.3 516.5 318.6 255.25\n"));
  expectCamera(read("# fx, fy, cx, cy\n517.3, 516.5, 318.6, 255.25"));
  expectCamera(read("5.173e+02 0 318.6\r\n0 516.5 255.25\r\n0 0 1\r\n"));
  expectCamera(read("517.3 0 318.6 0\n0 516.5 255.25 0\n0 0 1 0\n0 0 0 1\n"));
  expectCamera(read("image_width: 640\nimage_height: 480\ncamera_name: kinect\ncamera_matrix:\n  rows: 3\n"
                    "  cols: 3\n  data: [517.3, 0, 318.6, 0, 516.5, 255.25, 0, 0, 1]\n"),
               640, 480);
  expectCamera(read("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
                    "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 5.173e+02, 0., 318.6, 0.,\n       516.5, "
                    "255.25, 0., 0., 1. ]\ndistortion_coefficients: [0]\n"),
               640, 480);
  expectCamera(
      read("header:\n  seq: 1\nheight: 480\nwidth: 640\nK: [517.3, 0, 318.6, 0, 516.5, 255.25, 0, 0, 1]\n"),
      640, 480);
}

TEST_F(Intrinsics, AreRefusedWhenTheyMakeNoCamera) {
  for (const char* text : {"", "\n", "517 516 318", "517 516 318 255 0", "-517 516 318 255", "0 516 318 255",
                           "nan 516 318 255", "517 inf 318 255", "1e300 516 318 255", "517 516 318 cy",
                           "517 0 0 0 516 0 318 255 1", "517 9 318 0 516 255 0 0 1", "K: 517\n", "K: [517, 0",
                           "camera_matrix:\n  data: [1, 2]\n", "517 0 318 0 516 255 0 0 2"})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_TRUE(refusal(std::string(1 << 17, ' ')).code) << "too long for a calibration";
  EXPECT_TRUE(refusal(std::string("517\0 516 318 255", 16)).code);
}

TEST_F(Intrinsics, InTheFolderAreForItsImagesUnlessTheySayTheirSize) {
  add("a.png");
  write("intrinsics.txt", "5 5 2 1.5\n");
  const auto camera = open()->intrinsics();
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->width, 4);
  EXPECT_EQ(camera->height, 3);
  const CameraIntrinsics twice = camera->scaledTo(8, 6);
  EXPECT_EQ(twice.fx, 10);
  EXPECT_EQ(twice.cx, 4.5) << "pixel centers are whole numbers: 2 lies at 2.5 of 4, which is 5 of 8";
  write("other", "50 50 2 1.5\n");
  options_.intrinsics = folder_ / "other";
  EXPECT_EQ(open()->intrinsics()->fx, 50) << "what the user names wins";
}

TEST_F(Intrinsics, TakeTheSizeOfTheFirstImageThatCanBeRead) {
  write("0.png", "no image");
  write("intrinsics.txt", "5 5 2 1.5\n");
  EXPECT_THAT(open()->warnings(), ::testing::Contains(Mentions({"intrinsics.txt"})));
  add("1.png");
  EXPECT_EQ(open()->intrinsics()->width, 4);
}

TEST_F(Intrinsics, ThatAreWrongStopOnlyWhoNamesThem) {
  add("a.png");
  write("intrinsics.txt", "none\n");
  const auto sequence = open();
  EXPECT_FALSE(sequence->intrinsics());
  EXPECT_THAT(sequence->warnings(), ::testing::Contains(Mentions({"intrinsics.txt"})));
  options_.intrinsics = folder_ / "intrinsics.txt";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
  options_.intrinsics = folder_ / "missing.txt";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::fileNotFound));
}

}  // namespace
}  // namespace estancia
