// What all tests share: scratch folders, the command as a user runs it, and the real data.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace estancia::test {

/// A new empty folder, removed at the end of the test.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// During its life, commands find no WordNet: words are matched with names alone.
class WithoutWordNet {
 public:
  WithoutWordNet() { setenv("ESTANCIA_WORDNET", "/nowhere", 1); }
  ~WithoutWordNet() { unsetenv("ESTANCIA_WORDNET"); }
  WithoutWordNet(const WithoutWordNet&) = delete;
  WithoutWordNet& operator=(const WithoutWordNet&) = delete;
};

void writeFile(const std::filesystem::path& path, const std::string& bytes);
std::string readFile(const std::filesystem::path& path);

/// The message of the Error that `work` throws; "" when it throws none.
std::string errorOf(const std::function<void()>& work);

/// Whether the process whose number is in the file is there and no zombie; waits a little for it to go.
bool livesOn(const std::filesystem::path& pidFile);

struct CommandResult {
  int exitCode;
  std::string out;
  std::string err;
};
/// Runs `estancia arguments…` (quoted for the shell) in a clean environment.
CommandResult run(const std::vector<std::string>& arguments);
/// Runs another program.
CommandResult runProgram(const std::string& program, const std::vector<std::string>& arguments);

/// A folder of the real data ($ESTANCIA_DATA, else ~/.cache/estancia/data), or nothing when it is not there.
/// With CI set its absence is a failure instead: there the real data must be unpacked.
std::optional<std::filesystem::path> findData(const std::string& set);

/// The folder of the fetched models and panoramas ($ESTANCIA_HOME, else ~/.local/share/estancia), same rule.
std::optional<std::filesystem::path> findFetched(const std::string& what);

/// The folder with the test networks beside the project (../shared/models or $ESTANCIA_TEST_MODELS), same
/// rule.
std::optional<std::filesystem::path> findTestModels();

}  // namespace estancia::test

/// Skips the test with a sentence when `found` is empty.
#define ESTANCIA_NEEDS(found, sentence) \
  if (!(found)) GTEST_SKIP() << (sentence)
