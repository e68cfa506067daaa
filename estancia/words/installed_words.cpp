// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/installed_words.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/words/word_graph_file.hpp"
#include "estancia/words/wordnet.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::uintmax_t maxCacheBytes = 1u << 30;  // WordNet 3.0's has 33 MB

/// Names, sizes and times of WordNet's files: reading them all would take as long as reading the graph.
std::string sourceOf(const fs::path& folder) {
  std::string listed;
  for (const fs::path& file : wordNetFiles(folder)) {
    struct stat status {};
    if (stat(file.c_str(), &status) == 0)
      listed += fmt::format("{} {} {}.{}\n", file.string(), status.st_size, status.st_mtim.tv_sec,
                            status.st_mtim.tv_nsec);
  }
  return listed;
}

fs::path cacheFolder() {
  if (const std::string own = environment("ESTANCIA_CACHE"); !own.empty()) return own;
  if (const std::string cache = environment("XDG_CACHE_HOME"); !cache.empty())
    return fs::path(cache) / "estancia";
  return userHome() / ".cache/estancia";
}

std::optional<WordGraph> readCached(const fs::path& path, const std::string& source) {
  std::error_code error;
  const std::uintmax_t bytes = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (error || bytes == 0 || bytes > maxCacheBytes) return std::nullopt;
  const auto content = std::make_unique_for_overwrite<char[]>(bytes);  // zeros would cost as much as reading
  std::ifstream file(path, std::ios::binary);
  if (!file.read(content.get(), static_cast<std::streamsize>(bytes))) return std::nullopt;
  try {
    return unpackWordGraph({content.get(), bytes}, source, path.string());
  } catch (const Error&) {
    return std::nullopt;  // damaged, or of another WordNet: made anew
  }
}

}  // namespace

InstalledWords loadInstalledWords() {
  const std::optional<fs::path> folder = findWordNet();
  if (!folder)
    return {std::nullopt, environment("ESTANCIA_WORDNET").empty()
                              ? "install WordNet (Debian: wordnet-base) to ask in words that no label has"
                              : fmt::format("ESTANCIA_WORDNET: {} has no data.noun; name WordNet's folder",
                                            environment("ESTANCIA_WORDNET"))};
  const std::string source = sourceOf(*folder);
  const fs::path cache = cacheFolder() / fmt::format("words-{}.graph", sha256(source).substr(0, 8));
  if (std::optional<WordGraph> graph = readCached(cache, source)) return {std::move(graph), ""};
  try {
    WordGraph graph = buildWordGraph(readWordNet(*folder));
    try {
      fs::create_directories(cache.parent_path());
      writeWhole(cache, packWordGraph(graph, source));
    } catch (const std::exception&) {
      // A folder that cannot be written costs two seconds each time, nothing else.
    }
    return {std::move(graph), ""};
  } catch (const Error& error) {
    return {std::nullopt, error.what()};
  }
}

namespace {

const InstalledWords& installed() {
  static const InstalledWords words = loadInstalledWords();
  return words;
}

}  // namespace

const WordGraph* installedWordGraph() {
  return installed().graph ? &*installed().graph : nullptr;
}

std::string wordNetHint() {
  return installed().hint;
}

}  // namespace estancia
