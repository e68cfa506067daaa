// SPDX-License-Identifier: Apache-2.0
#include "support/support.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia::test {
namespace fs = std::filesystem;
namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

fs::path environmentOr(const char* variable, const fs::path& otherwise) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0' ? fs::path(value) : otherwise;
}

fs::path home() {
  return environmentOr("HOME", "/");
}

/// Beside the command: making the word graph takes seconds, and many tests need it.
fs::path sharedWords() {
  return fs::path(ESTANCIA_COMMAND).parent_path().parent_path() / "test-words";
}

std::vector<fs::path> wordGraphsIn(const fs::path& folder) {
  std::vector<fs::path> graphs;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.path().extension() == ".graph") graphs.push_back(entry.path());
  return graphs;
}

/// What an earlier command made.
void lendWordGraph(const fs::path& cache) {
  for (const fs::path& graph : wordGraphsIn(sharedWords())) {
    fs::create_directories(cache);
    fs::create_symlink(graph, cache / graph.filename());
  }
}

/// What this command made, for later ones; whole or not at all.
void keepWordGraph(const fs::path& cache) {
  for (const fs::path& graph : wordGraphsIn(cache)) {
    if (fs::is_symlink(graph)) continue;
    fs::create_directories(sharedWords());
    const fs::path part = sharedWords() / fmt::format("{}.{}", graph.filename().string(), getpid());
    std::error_code none;
    fs::copy_file(graph, part, none);
    fs::rename(part, sharedWords() / graph.filename(), none);
  }
}

std::optional<fs::path> existing(const fs::path& path) {
  if (fs::exists(path)) return path;
  if (std::getenv("CI") != nullptr)
    ADD_FAILURE() << path << " is missing, and CI may not skip real-data tests";
  return std::nullopt;
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::string pattern = (fs::temp_directory_path() / "estancia-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a scratch folder");
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void writeFile(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string readFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream all;
  all << file.rdbuf();
  return all.str();
}

std::string errorOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "more than one line: " << e.what();
    return e.what();
  }
  return "";
}

bool livesOn(const fs::path& pidFile) {
  const std::string pid = std::to_string(std::atoi(readFile(pidFile).c_str()));
  if (pid == "0") return true;  // the script did not get as far: the test is wrong
  for (int i = 0; i < 500; ++i) {
    const std::string status = readFile("/proc/" + pid + "/stat");
    if (status.empty() || status.find(") Z ") != std::string::npos) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

CommandResult run(const std::vector<std::string>& arguments) {
  return runProgram(ESTANCIA_COMMAND, arguments);
}

CommandResult runProgram(const std::string& program, const std::vector<std::string>& arguments) {
  const ScratchFolder scratch;
  // Labels of earlier runs would hide what this one does.
  const fs::path cache = environmentOr("ESTANCIA_CACHE", scratch / "cache");
  if (cache == scratch / "cache") lendWordGraph(cache);
  std::string line = "ESTANCIA_CACHE=" + quoted(cache.string()) + " " + quoted(program);
  for (const auto& argument : arguments) line += " " + quoted(argument);
  line += " >" + quoted(scratch / "out") + " 2>" + quoted(scratch / "err") + " </dev/null";
  const int status = std::system(line.c_str());
  if (cache == scratch / "cache") keepWordGraph(cache);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), readFile(scratch / "out"),
          readFile(scratch / "err")};
}

std::optional<fs::path> findData(const std::string& set) {
  return existing(environmentOr("ESTANCIA_DATA", home() / ".cache/estancia/data") / set);
}

std::optional<fs::path> findFetched(const std::string& what) {
  return existing(environmentOr("ESTANCIA_HOME", home() / ".local/share/estancia") / what);
}

std::optional<fs::path> findTestModels() {
  return existing(environmentOr("ESTANCIA_TEST_MODELS", fs::path(ESTANCIA_SOURCE_DIR) / "../shared/models"));
}

}  // namespace estancia::test
