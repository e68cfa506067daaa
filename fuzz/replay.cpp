// What fuzzing has found once must not come back: each target reads its corpus, a test a target.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {
namespace {

namespace fs = std::filesystem;

class Corpus : public testing::Test {
 public:
  explicit Corpus(Target target) : target_(std::move(target)) {}

  void TestBody() override {
    const fs::path folder = fs::path(ESTANCIA_FUZZ_CORPUS) / target_.name;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    ASSERT_FALSE(files.empty()) << folder;
    std::ranges::sort(files);
    for (const fs::path& file : files) {
      SCOPED_TRACE(file.string());
      std::ifstream in(file, std::ios::binary);
      const std::string bytes(std::istreambuf_iterator<char>(in), {});
      EXPECT_NO_THROW(run(target_, bytes));
    }
  }

 private:
  Target target_;
};

}  // namespace
}  // namespace estancia::fuzz

int main(int argc, char** argv) {
  for (const estancia::fuzz::Target& target : estancia::fuzz::targets())
    testing::RegisterTest("Corpus", target.name.c_str(), nullptr, nullptr, __FILE__, __LINE__,
                          [target]() -> testing::Test* { return new estancia::fuzz::Corpus(target); });
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
