// Configurations of experiments, cut and garbled: read or refused, but nothing else.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "estancia/core/error.hpp"
#include "runner/experiment.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

namespace fs = std::filesystem;
using test::readFile;
using test::ScratchFolder;
using test::writeFile;

TEST(Configurations, AreReadOrRefused) {
  const ScratchFolder scratch;
  std::mt19937 random(1);
  std::size_t files = 0, refused = 0;
  const auto isRefused = [&](const std::string& text) {
    const std::string file = scratch / "garbled.toml";
    writeFile(file, text);
    try {
      checkExperiments({file});
    } catch (const Error&) {
      return true;
    }
    return false;
  };
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(ESTANCIA_LAB_DIR) / "experiments")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path());
    ++files;
    const std::string text = readFile(entry.path());
    for (int round = 0; round < 60; ++round) {
      std::string changed = text;
      const std::size_t at = random() % text.size();
      if (round % 2 == 0) changed.resize(at);
      for (int k = 0; k < round % 4 && !changed.empty(); ++k)
        changed[random() % changed.size()] = static_cast<char>(random() % 256);
      refused += isRefused(changed);
    }
  }
  EXPECT_GE(files, 33U);
  EXPECT_GE(refused, files) << "some of it is wrong";
}

}  // namespace
}  // namespace estancia::experiments
