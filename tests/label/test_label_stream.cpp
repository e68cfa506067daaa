// Frames are labeled in order, ahead of who asks for them, and as small as the labeler wants them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "estancia/core/error.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/ensemble.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

/// Frames 0 … size − 1; frame i is an image of one pixel with the value i. Frames in `unreadable`
/// throw.
class StreamFrames final : public Sequence {
 public:
  explicit StreamFrames(std::size_t size, std::vector<std::size_t> unreadable = {})
      : frames_(size), unreadable_(std::move(unreadable)) {
    for (std::size_t i = 0; i < size; ++i) frames_[i].name = std::to_string(i) + ".png";
  }
  std::string name() const override { return "frames"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override {
    // Not simply the last one: of two threads the one with the earlier frame may be slower.
    for (std::size_t most = read; most < i + 1 && !read.compare_exchange_weak(most, i + 1);) {
    }
    changed.notify_all();
    if (i == outOfMemoryAt) throw std::bad_alloc();
    if (const auto found = failing.find(i); found != failing.end()) found->second();
    if (std::count(unreadable_.begin(), unreadable_.end(), i) > 0)
      throw Error(ErrorCode::fileUnreadable, "frame " + std::to_string(i) + " is torn");
    return cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(static_cast<double>(i)));
  }
  std::string fingerprint(std::size_t i) const override { return named ? "image " + std::to_string(i) : ""; }

  bool named = false;  ///< whether images are known apart by their files too
  std::size_t outOfMemoryAt = static_cast<std::size_t>(-1);
  std::map<std::size_t, std::function<void()>> failing;
  mutable std::atomic<std::size_t> read{0};  ///< the frame asked for that is furthest ahead, plus one
  mutable std::condition_variable changed;

 private:
  std::vector<Frame> frames_;
  std::vector<std::size_t> unreadable_;
};

/// Answers with the pixel's value over 100.
class PixelLabeler final : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "pixel"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override {
    if (beforePrepare) beforePrepare(bgr.at<cv::Vec3b>(0, 0)[0]);
    return {bgr, frame, {}};
  }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const int value = prepared.input.at<cv::Vec3b>(0, 0)[0];
    if (beforeInfer) beforeInfer(value);
    return {static_cast<float>(value) / 100};
  }
  std::function<void(int)> beforePrepare, beforeInfer;

 private:
  Vocabulary vocabulary_{{"bright"}};
};

TEST(LabelStream, LabelsAllFramesInOrder) {
  const StreamFrames frames(50);
  PixelLabeler labeler;
  LabelStream stream(frames, labeler);
  for (std::size_t i = 0; i < 50; ++i) {
    const auto frame = stream.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    ASSERT_TRUE(frame->labeled());
    EXPECT_EQ(frame->descriptor, LexicalDescriptor{static_cast<float>(i) / 100});
    EXPECT_EQ(frame->image.at<cv::Vec3b>(0, 0)[2], i);
  }
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(stream.next());
}

TEST(LabelStream, StartsWhereItIsToldAndChecksItsOptions) {
  const StreamFrames frames(5);
  PixelLabeler labeler;
  LabelStream stream(frames, labeler, {.first = 3});
  EXPECT_EQ(stream.next()->index, 3U);
  EXPECT_EQ(stream.next()->index, 4U);
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(LabelStream(frames, labeler, {.first = 9}).next());
  EXPECT_FALSE(LabelStream(StreamFrames(0), labeler).next());
  EXPECT_THAT([&] { LabelStream(frames, labeler, {.ahead = 0}).next(); },
              FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { LabelStream(frames, labeler, {.readers = 0}).next(); },
              FailsWith(ErrorCode::invalidOption));
}

std::vector<std::string> problemsOf(const Sequence& frames, Labeler& labeler) {
  LabelStream stream(frames, labeler);
  std::vector<std::string> problems;
  while (const auto frame = stream.next()) problems.push_back(frame->problem);
  return problems;
}

/// The frames that problems "FRAME: …" name.
std::vector<std::string> framesOf(std::vector<std::string> problems) {
  for (std::string& problem : problems) problem.resize(std::min(problem.find(": "), problem.size()));
  return problems;
}

TEST(LabelStream, AnExceptionOfAnyTypeIsItsFramesFailure) {
  StreamFrames frames(9, {8});
  frames.failing[0] = [] { std::string("RIFF").substr(8); };
  frames.failing[2] = [] { CV_Error(cv::Error::StsAssert, "two\nlines"); };
  frames.failing[3] = [] { throw std::filesystem::filesystem_error("gone", std::error_code()); };
  frames.failing[5] = [] { std::vector<int>().reserve(std::numeric_limits<std::size_t>::max()); };
  PixelLabeler labeler;
  labeler.beforePrepare = [](int value) {
    if (value == 6) throw std::out_of_range("prepared");
  };
  labeler.beforeInfer = [](int value) {
    if (value == 7) throw std::out_of_range("inferred");
  };
  const auto problems = problemsOf(frames, labeler);
  EXPECT_THAT(framesOf(problems),
              ElementsAre("0.png", "", "2.png", "3.png", "", "5.png", "6.png", "7.png", "frame 8 is torn"));
  EXPECT_EQ(problems[2].find('\n'), std::string::npos) << problems[2];
  LabelStream strict(frames, labeler, {.strict = true});
  EXPECT_THAT([&] { strict.next(); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_FALSE(strict.next());
}

TEST(LabelStream, PassesOnWhatIsNoMatterOfOneFrame) {
  StreamFrames frames(4);
  frames.outOfMemoryAt = 1;
  PixelLabeler labeler;
  LabelStream stream(frames, labeler);
  EXPECT_TRUE(stream.next());
  EXPECT_THROW(stream.next(), std::bad_alloc);
  EXPECT_FALSE(stream.next());
  StreamFrames others(2);
  others.failing[0] = [] { CV_Error(cv::Error::StsNoMem, "OpenCV has no memory left"); };
  EXPECT_THROW(LabelStream(others, labeler).next(), std::bad_alloc);
  others.failing[0] = [] { throw Interrupted("the user asks to stop"); };
  EXPECT_THROW(LabelStream(others, labeler).next(), Interrupted);
}

/// Refuses one frame, likes batches of four.
class Refusing final : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "refusing"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& prepared) override {
    ++asked;
    const int value = prepared.input.at<cv::Vec3b>(0, 0)[0];
    if (value == 2) throw FrameError("frame 2 is refused");
    if (value == endsAt) throw Error(ErrorCode::serverFailure, "no more money");
    return {0.5F};
  }
  std::size_t batchSize() const override { return 4; }
  int asked = 0, endsAt = -1;

 private:
  Vocabulary vocabulary_{{"bright"}};
};

TEST(LabelStream, StrictEndsAtARefusedFrameWithoutPayingForMore) {
  StreamFrames frames(20);
  Refusing labeler;
  LabelStream stream(frames, labeler, {.strict = true});
  EXPECT_EQ(stream.next()->index, 0U);
  EXPECT_EQ(stream.next()->index, 1U);
  EXPECT_THAT([&] { stream.next(); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_FALSE(stream.next());
  EXPECT_EQ(labeler.asked, 4) << "one batch";
}

TEST(LabelStream, KeepsWhatWasPaidForWhenTheWorkMustEnd) {
  const test::ScratchFolder scratch;
  LabelCache cache(scratch.path(), 1 << 20);
  StreamFrames frames(8);
  Refusing labeler;
  labeler.endsAt = 7;
  LabelStream stream(frames, labeler, {.cache = &cache});
  EXPECT_THAT(
      [&] {
        while (stream.next()) {
        }
      },
      FailsWith(ErrorCode::serverFailure));
  labeler.endsAt = -1;
  labeler.asked = 0;
  LabelStream again(frames, labeler, {.cache = &cache});
  std::size_t labeled = 0;
  while (const auto frame = again.next()) labeled += frame->labeled() ? 1 : 0;
  EXPECT_EQ(labeled, 7U);
  EXPECT_EQ(labeler.asked, 2) << "the refused one and the last one";
}

TEST(LabelStream, RemembersDiscoveredWordsByNameAndAsksAgainWhereTheyAreDamaged) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "asked", "");
  test::writeFile(scratch / "labeler.sh",
                  "while read -r image; do echo >>asked; n=$(wc -l <asked)\n"
                  "echo \"{\\\"image\\\": \\\"$image\\\", \\\"labels\\\": {\\\"w$n\\\": 0.5, "
                  "\\\"all\\\": 0.25}}\"\ndone\n");
  test::writeFile(scratch / "model.toml",
                  "name = \"web\"\ntype = \"process\"\ncommand = [\"sh\", \"labeler.sh\"]\n");
  LabelCache cache(scratch / "labels", 1 << 20);
  StreamFrames frames(3);
  frames.named = true;
  std::string key;
  const auto words = [&] {
    const auto labeler = loadModel(scratch.path().string());
    key = labeler->cacheKey();
    LabelStream stream(frames, *labeler, {.cache = &cache});
    std::vector<std::map<std::string, float>> found;
    while (const auto frame = stream.next()) {
      found.emplace_back();
      for (std::size_t i = 0; i < frame->descriptor.size(); ++i)
        if (frame->descriptor[i] > 0) found.back()[labeler->vocabulary()[i]] = frame->descriptor[i];
    }
    return found;
  };
  using Words = std::map<std::string, float>;
  const auto first = words();
  EXPECT_THAT(first, ElementsAre(Words{{"w1", 0.5F}, {"all", 0.25F}}, Words{{"w2", 0.5F}, {"all", 0.25F}},
                                 Words{{"w3", 0.5F}, {"all", 0.25F}}));
  EXPECT_EQ(words(), first);
  EXPECT_EQ(test::readFile(scratch / "asked").size(), 3U) << "not asked again";
  const std::string sound = cache.find(key, "image 1").value();
  std::vector<std::string> damaged{sound.substr(0, 3) + "\x40" + sound.substr(4),
                                   sound.substr(0, 4) + std::string(4, '\0')};
  for (std::size_t size = 1; size < sound.size(); size += 3) damaged.push_back(sound.substr(0, size));
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    cache.put(key, "image 1", damaged[i]);
    EXPECT_EQ(words()[1], (Words{{"w" + std::to_string(i + 4), 0.5F}, {"all", 0.25F}})) << i;
  }
}

TEST(LabelStream, DecodesTheNextFramesDuringInferenceButNotAll) {
  const StreamFrames frames(30);
  PixelLabeler labeler;
  constexpr std::size_t ahead = 3;
  std::mutex mutex;
  labeler.beforeInfer = [&](int value) {  // returns only when the frames behind this one have been read
    const std::size_t expected = std::min<std::size_t>(static_cast<std::size_t>(value) + 1 + ahead, 30);
    std::unique_lock lock(mutex);
    while (frames.read <
           expected)  // a stream that does not read ahead hangs here until the test's time is over
      frames.changed.wait_for(lock, std::chrono::milliseconds(20));
  };
  LabelStream stream(frames, labeler, {.ahead = ahead});
  while (const auto frame = stream.next())
    EXPECT_LE(frames.read, frame->index + 2 + ahead) << "queue, and the one that waits for room";
}

TEST(LabelStream, MayBeDroppedAtAnyTime) {
  const StreamFrames frames(1000);
  PixelLabeler labeler;
  for (int taken = 0; taken < 8; ++taken) {
    LabelStream stream(frames, labeler, {.ahead = 2});
    for (int i = 0; i < taken; ++i) stream.next();
  }
}

LabelerOptions reduced() {
  LabelerOptions options;
  options.reducedImages = true;
  return options;
}

/// A small network of 8×8 pixels, and JPEG files of 64×48: 10 pixels (8 / 0.875) or more are 16×12.
class ReducedImages : public testing::Test {
 protected:
  void SetUp() override {
    test::writeSmallModel(scratch_ / "small");
    std::filesystem::create_directory(photos());
    for (int i = 0; i < 3; ++i) {
      cv::Mat image(48, 64, CV_8UC3);
      cv::RNG(static_cast<std::uint64_t>(i) + 1).fill(image, cv::RNG::UNIFORM, 0, 255);
      cv::imwrite((photos() / (std::to_string(i) + ".jpg")).string(), image);
    }
    cv::imwrite((photos() / "9.png").string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(50, 100, 150)));
  }
  std::filesystem::path photos() const { return scratch_ / "photos"; }
  std::string model() const { return (scratch_ / "small").string(); }

  test::ScratchFolder scratch_;
};

std::vector<LabeledFrame> all(const Sequence& sequence, Labeler& labeler) {
  std::vector<LabeledFrame> frames;
  LabelStream stream(sequence, labeler);
  while (auto frame = stream.next()) frames.push_back(std::move(*frame));
  return frames;
}

TEST_F(ReducedImages, AreWhatTheNetworkSees) {
  const auto sequence = openSequence(photos());
  const auto labeler = loadModel(model(), reduced());
  EXPECT_EQ(labeler->imageSide(), 9);
  const auto frames = all(*sequence, *labeler);
  ASSERT_EQ(frames.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    const cv::Mat small = readReducedImage(photos() / sequence->frame(i).name, 9);
    ASSERT_EQ(small.size(), cv::Size(16, 12));
    EXPECT_EQ(frames[i].descriptor, labeler->label(small));
    EXPECT_NE(frames[i].descriptor, labeler->label(sequence->image(i)));
    EXPECT_TRUE(frames[i].image.empty());
  }
  EXPECT_EQ(frames[3].descriptor, labeler->label(sequence->image(3)));  // PNG
}

TEST_F(ReducedImages, MakeAnotherIdentity) {
  const auto whole = loadModel(model()), small = loadModel(model(), reduced());
  EXPECT_EQ(whole->imageSide(), 0);
  EXPECT_THAT(small->identity(), testing::StartsWith("small reduced-"));
  EXPECT_NE(small->identity(), whole->identity());
  EXPECT_NE(small->cacheKey(), whole->cacheKey());
  LabelerOptions later = reduced();
  later.onDemand = true;
  EXPECT_EQ(loadModel(model(), later)->identity(), small->identity());
}

}  // namespace
}  // namespace estancia
