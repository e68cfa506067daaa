// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <opencv2/videoio.hpp>

#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using ::testing::IsEmpty;

constexpr int kFrames = 120;

/// The frame's number in binary: eight black or white bars, which no coding blurs away.
cv::Mat imageOf(int number) {
  cv::Mat image = test::plain(64, 48, {});
  for (int bit = 0; bit < 8; ++bit)
    if ((number >> bit & 1) != 0) image.colRange(8 * bit, 8 * bit + 8).setTo(cv::Scalar::all(255));
  return image;
}

int numberOf(const cv::Mat& image) {
  EXPECT_EQ(image.type(), CV_8UC3);
  EXPECT_EQ(image.size(), cv::Size(64, 48));
  int number = 0;
  for (int bit = 0; bit < 8; ++bit) number |= (image.at<cv::Vec3b>(24, 8 * bit + 4)[1] > 127) << bit;
  return number;
}

struct Coding {
  std::string suffix, fourcc;
  friend std::ostream& operator<<(std::ostream& out, const Coding& coding) { return out << coding.fourcc; }
};

class Video : public ::testing::TestWithParam<Coding> {
 protected:
  void SetUp() override {
    file_ = folder_ / ("drive" + GetParam().suffix);
    const std::string& c = GetParam().fourcc;
    cv::VideoWriter writer(file_, cv::VideoWriter::fourcc(c[0], c[1], c[2], c[3]), 20, {64, 48});
    ASSERT_TRUE(writer.isOpened());
    for (int i = 0; i < kFrames; ++i) writer.write(imageOf(i));
  }
  test::ScratchFolder folder_;
  std::filesystem::path file_;
};

TEST_P(Video, GivesItsFramesInOrderWithTheirTimes) {
  const auto video = openSequence(file_);
  ASSERT_EQ(video->size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(video->name(), file_.filename());
  EXPECT_EQ(video->frame(7).name, "frame 000007");
  EXPECT_DOUBLE_EQ(video->frame(7).timestamp.value(), 7 / 20.0);
  EXPECT_THAT(video->warnings(), IsEmpty());
  for (int i = 0; i < kFrames; ++i) EXPECT_EQ(numberOf(video->image(static_cast<std::size_t>(i))), i);
}

TEST_P(Video, SeeksToTheRightFrame) {
  const auto video = openSequence(file_);
  for (const int i : {100, 3, 119, 0, 60, 59, 58, 118, 1, 1, 2})
    EXPECT_EQ(numberOf(video->image(static_cast<std::size_t>(i))), i);
}

TEST_P(Video, MayBeReadFromSeveralThreads) {
  const auto video = openSequence(file_);
  std::atomic<int> wrong = 0;
  test::inThreads(3, [&](int t) {
    for (int i = t; i < kFrames; i += 3)
      if (numberOf(video->image(static_cast<std::size_t>(i))) != i) ++wrong;
  });
  EXPECT_EQ(wrong, 0);
}

INSTANTIATE_TEST_SUITE_P(Codings, Video, ::testing::Values(Coding{".avi", "MJPG"}, Coding{".mp4", "mp4v"}),
                         [](const auto& coding) { return coding.param.fourcc; });

class DamagedVideo : public Video {};

TEST_P(DamagedVideo, ListsOnlyWhatIsThereWhenItWasCut) {
  const std::string whole = test::readFile(file_);
  test::writeFile(folder_ / "cut.avi", whole.substr(0, whole.size() / 2));
  const auto video = openSequence(folder_ / "cut.avi");
  EXPECT_GT(video->size(), 40U);
  EXPECT_LT(video->size(), 80U);
  for (std::size_t i = 0; i + 1 < video->size(); ++i)
    EXPECT_EQ(numberOf(video->image(i)), static_cast<int>(i));
}

TEST_P(DamagedVideo, DoesNotBelieveADeclaredNumberOfFrames) {
  const std::string whole = test::readFile(file_);
  const auto length = whole.find("vids") + 32;  // dwLength of the stream header
  const auto total = whole.find("avih") + 8 + 16;
  const auto sizeWith = [&](const std::string& lie) {
    std::string bytes = whole;
    bytes.replace(length, 4, lie);
    bytes.replace(total, 4, lie);
    test::writeFile(folder_ / "lie.avi", bytes);
    const auto video = openSequence(folder_ / "lie.avi");
    for (std::size_t i = 0; i < video->size(); ++i) EXPECT_EQ(numberOf(video->image(i)), static_cast<int>(i));
    return static_cast<int>(video->size());
  };
  EXPECT_EQ(sizeWith("\xFF\xFF\xFF\x7F"), kFrames);
  EXPECT_EQ(sizeWith(std::string(4, '\0')), kFrames);
  EXPECT_GE(sizeWith(std::string("\x05\0\0\0", 4)), 5)
      << "OpenCV itself stops there, but no frame may be missing";
}

INSTANTIATE_TEST_SUITE_P(Codings, DamagedVideo, ::testing::Values(Coding{".avi", "MJPG"}));

TEST(NoVideo, IsRefusedWithASentence) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "a.mp4", "Dear reader, this is text.");
  test::writeFile(folder / "b.mp4", "");
  test::writeFile(folder / "c.PNG", test::encoded(".png", test::plain(4, 4, {})));
  test::writeFile(folder / "d.mp4", std::string("no video\0\1\2", 11));
  EXPECT_THAT([&] { openSequence(folder / "a.mp4"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { openSequence(folder / "d.mp4"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { openSequence(folder / "b.mp4"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_EQ(openSequence(folder / "c.PNG")->frame(0).name, "c.PNG") << "a sequence of one image";
  SequenceOptions options;
  options.type = "video";
  EXPECT_TRUE(test::caught([&] { openSequence(folder.path(), options); }).code);
}

}  // namespace
}  // namespace estancia
