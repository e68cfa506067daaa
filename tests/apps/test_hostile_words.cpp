// What people and scripts type, and names that others gave to files: told as they are, on one line.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/model_support.hpp"

namespace estancia::test {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

class HostileWords : public testing::Test {
 protected:
  void SetUp() override {
    std::string lines = "image,mug,desk,tree\n";
    for (int i = 0; i < 40; ++i)
      lines +=
          fmt::format("i{}.png,{},{},0.05\n", i, i / 10 % 2 == 0 ? 0.9 : 0.05, i / 10 % 2 == 0 ? 0.05 : 0.9);
    writeFile(labels_, lines);
  }
  CommandResult map(const std::string& output) const { return run({"map", labels_, "-o", output}); }

  ScratchFolder folder_;
  const fs::path labels_ = folder_ / "labels.csv";
};

TEST_F(HostileWords, SurplusWordsAreToldInTheirOrder) {
  const fs::path file = folder_ / "a.estancia";
  ASSERT_EQ(map(file).exitCode, 0);
  EXPECT_THAT(run({"ask", file, "mug", "b", "c"}), FailsWith(ErrorCode::invalidOption, "\"b c\""));
  EXPECT_THAT(run({"map", labels_, "-o", folder_ / "b.estancia", "--blur", "-1"}),
              FailsWith(ErrorCode::invalidOption, "no option --blur"));
}

TEST_F(HostileWords, NumbersAreWholeAndInTheirRange) {
  const fs::path file = folder_ / "a.estancia";
  ASSERT_EQ(map(file).exitCode, 0);
  for (const std::string number : {"-1", "0", "abc", "1.5", "99999999999999999999", "nan", ""})
    EXPECT_THAT(run({"ask", file, "mug", "-n", number}), FailsWith(ErrorCode::invalidOption, "--max-places"));
  EXPECT_THAT(run({"localize", file, labels_, "--lookahead", "-1"}),
              FailsWith(ErrorCode::invalidOption, "--lookahead", "at least 0"));
  EXPECT_THAT(run({"drives", file, "--undo", "kitchen"}),
              FailsWith(ErrorCode::invalidOption, "--undo", "kitchen"));
}

TEST_F(HostileWords, OutputsThatCannotBeAreToldBeforeTheWork) {
  const std::string tooLong(300, 'a');
  fs::create_symlink("circle", folder_ / "circle");
  for (const std::string command : {"map", "label"}) {
    EXPECT_THAT(run({command, labels_, "-o", folder_ / (tooLong + ".labels")}),
                FailsWith(ErrorCode::fileUnwritable, tooLong));
    EXPECT_THAT(run({command, labels_, "-o", ""}), FailsWith(ErrorCode::invalidOption, "--output"));
  }
  EXPECT_THAT(map(folder_ / "circle"), FailsWith(ErrorCode::fileUnwritable, "circle"));
  fs::create_symlink("there.estancia", folder_ / "link.estancia");
  EXPECT_EQ(map(folder_ / "link.estancia").exitCode, 0) << "the file is made where the link leads";
  EXPECT_TRUE(fs::is_regular_file(folder_ / "there.estancia"));
}

TEST_F(HostileWords, ControlCharactersOfNamesReachNoTerminal) {
  const std::string name = "\x1b[31mred\nline\u202E.estancia";
  const CommandResult made = map(folder_ / name), asked = run({"ask", folder_ / name, "\x1b[2Jmug"});
  const CommandResult missing = run({"ask", folder_ / ("no" + name), "mug"});
  for (const CommandResult& result : {made, asked, missing})
    for (const std::string& text : {result.out, result.err}) {
      EXPECT_THAT(text, Not(HasSubstr("\x1b[31m")));
      EXPECT_THAT(text, Not(HasSubstr("\x1b[2J")));
      EXPECT_THAT(text, Not(HasSubstr("\u202E")));
    }
  EXPECT_THAT(made.out, HasSubstr("\\x1B[31mred\\x0Aline"));
  EXPECT_THAT(missing, FailsWith(ErrorCode::fileNotFound, "\\x1B[31mred"));
}

TEST_F(HostileWords, ManyBadImagesAreCounted) {
  writeSmallModel(folder_ / "model");
  const fs::path images = folder_ / "images";
  fs::create_directory(images);
  for (int i = 0; i < 200; ++i) writeFile(images / fmt::format("{}.png", i), "no image");
  const CommandResult result =
      run({"map", images, "-o", folder_ / "a.estancia", "--model", folder_ / "model"});
  EXPECT_NE(result.exitCode, 0);
  EXPECT_LT(std::ranges::count(result.err, '\n'), 40);
  EXPECT_THAT(result.err, HasSubstr("180 more"));
}

TEST_F(HostileWords, ImagesOfOtherFormatsAreNamed) {
  const fs::path images = folder_ / "images";
  fs::create_directory(images);
  cv::imwrite(images / "1.png", cv::Mat(8, 8, CV_8UC3, cv::Scalar(9, 9, 9)));
  writeFile(images / "2.HEIC", "x");
  writeFile(images / "3.gif", "x");
  EXPECT_THAT(run({"check", images}).out + run({"check", images}).err,
              HasSubstr("2 images are of other formats, 2.HEIC"));
}

}  // namespace
}  // namespace estancia::test
