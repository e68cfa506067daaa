// What people and scripts type, and names that others gave to files: reported unchanged, on one line.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

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

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder folder_;
  const fs::path labels_ = folder_ / "labels.csv";
};

TEST_F(HostileWords, NumbersAreWholeAndInTheirRange) {
  const fs::path file = folder_ / "a.estancia";
  ASSERT_EQ(map(file).exitCode, 0);
  EXPECT_THAT(run({"ask", file, "mug", "b", "c"}), FailsWith(ErrorCode::invalidOption)) << "surplus words";
  for (const std::string number : {"-1", "0", "abc", "1.5", "99999999999999999999", "nan", ""})
    EXPECT_THAT(run({"ask", file, "mug", "-n", number}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"localize", file, labels_, "--lookahead", "-1"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(run({"drives", file, "--undo", "kitchen"}), FailsWith(ErrorCode::invalidOption));
}

TEST_F(HostileWords, OutputsThatCannotBeAreToldBeforeTheWork) {
  const std::string tooLong(300, 'a');
  fs::create_symlink("circle", folder_ / "circle");
  for (const std::string command : {"map", "label"}) {
    EXPECT_THAT(run({command, labels_, "-o", folder_ / (tooLong + ".labels")}),
                FailsWith(ErrorCode::fileUnwritable));
    EXPECT_THAT(run({command, labels_, "-o", ""}), FailsWith(ErrorCode::invalidOption));
  }
  EXPECT_THAT(map(folder_ / "circle"), FailsWith(ErrorCode::fileUnwritable));
  fs::create_symlink("there.estancia", folder_ / "link.estancia");
  EXPECT_EQ(map(folder_ / "link.estancia").exitCode, 0) << "the file is made where the link leads";
  EXPECT_TRUE(fs::is_regular_file(folder_ / "there.estancia"));
}

}  // namespace
}  // namespace estancia::test
