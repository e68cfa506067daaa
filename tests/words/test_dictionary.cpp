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

TEST_F(Dictionaries, RefuseOtherFiles) {
  for (const std::string& text :
       {std::string("stuhl\tchair\nsofa\n"), std::string("stuhl\t\n"), std::string("\tchair\n"),
        std::string("K\xFC\tkitchen\n"), std::string("\xFF\xFEs\0t\0", 6)})
    EXPECT_THAT([&] { of(text); }, FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT([&] { of("# nothing yet\n\n"); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { Dictionary(scratch_ / "none.txt"); }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT([&] { Dictionary{scratch_.path()}; }, FailsWith(ErrorCode::fileUnreadable));
}

}  // namespace
}  // namespace estancia
