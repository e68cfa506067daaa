// Words of another language, looked up in English.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/dictionary.hpp"

#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;

class Dictionaries : public testing::Test {
 protected:
  Dictionary of(const std::string& text) {
    writeFile(file_, text);
    return Dictionary(file_);
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path file_ = scratch_ / "german.txt";
};

TEST_F(Dictionaries, TranslateWholeTextsThenWords) {
  const Dictionary german =
      of("# German\nK\xC3\xBC"
         "che\tkitchen\r\n\nstuhl,chair\nrotes Sofa\tred couch\nrot\tred\nstuhl\tstool\n");
  EXPECT_EQ(german.translate("K\xC3\xBC"
                             "che"),
            "kitchen");
  EXPECT_EQ(german.translate("K\xC3\x9C"
                             "CHE"),
            "kitchen")
      << "capitals of Latin-1";
  EXPECT_EQ(german.translate("  Stuhl "), "chair") << "the first of two lines";
  EXPECT_EQ(german.translate("rotes sofa"), "red couch");
  EXPECT_EQ(german.translate("rot Stuhl blau"), "red chair blau");
  EXPECT_EQ(german.translate(""), "");
}

TEST_F(Dictionaries, MayBeginWithAByteOrderMark) {
  EXPECT_EQ(of("\xEF\xBB\xBFstuhl\tchair\n").translate("Stuhl"), "chair");
}

TEST_F(Dictionaries, SayWhichLineIsWrong) {
  EXPECT_THAT([&] { of("stuhl\tchair\nsofa\n"); }, FailsWith(ErrorCode::malformedFile, "german.txt, line 2"));
  EXPECT_THAT([&] { of("stuhl\t\n"); }, FailsWith(ErrorCode::malformedFile, "line 1"));
  EXPECT_THAT([&] { of("\tchair\n"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { Dictionary(scratch_ / "none.txt"); }, FailsWith(ErrorCode::fileUnreadable, "none.txt"));
  EXPECT_THAT([&] { Dictionary{scratch_.path()}; }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT([&] { of("# nothing yet\n\n"); }, FailsWith(ErrorCode::insufficientData, "without words"));
  EXPECT_THAT(
      [&] {
        of("stuhl\tchair\nK\xFC"
           "che\tkitchen\n");
      },
      FailsWith(ErrorCode::malformedFile, "line 2: it is no UTF-8"))
      << "Latin-1";
  EXPECT_THAT([&] { of(std::string("\xFF\xFEs\0t\0", 6)); }, FailsWith(ErrorCode::malformedFile, "line 1"))
      << "UTF-16";
}

}  // namespace
}  // namespace estancia
