// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/installed_words.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/home.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/words/word_files.hpp"
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

/// Result of `unpack` on the file's bytes; nothing if there is no such file, or `unpack` throws Error.
template <class Unpack>
auto readCached(const fs::path& path, const Unpack& unpack)
    -> std::optional<decltype(unpack(std::string_view()))> {
  std::error_code error;
  const std::uintmax_t bytes = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (error || bytes == 0 || bytes > maxCacheBytes) return std::nullopt;
  const auto content = std::make_unique_for_overwrite<char[]>(bytes);  // zeros would cost as much as reading
  std::ifstream file(path, std::ios::binary);
  if (!file.read(content.get(), static_cast<std::streamsize>(bytes))) return std::nullopt;
  try {
    return unpack(std::string_view(content.get(), bytes));
  } catch (const Error&) {
    return std::nullopt;  // damaged, or of another WordNet: made anew
  }
}

/// Returns whether the file is there now: a folder that cannot be written only costs seconds each time.
bool writeCached(const fs::path& path, const std::string& bytes) {
  try {
    fs::create_directories(path.parent_path());
    writeWhole(path, bytes);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

fs::path cacheFile(const char* kind, const std::string& source, const char* ending) {
  return cacheFolder() / fmt::format("{}-{}.{}", kind, sha256(source).substr(0, 8), ending);
}

}  // namespace

OptionGroup declare(NamingOptions& options) {
  using Words = NamingOptions::Words;
  OptionGroup group("naming", "Which words name zones and areas.");
  group.add("words", options.words,
            {{{"wordnet", "\"dog\" for several breeds, where WordNet is installed"}, Words::wordNet},
             {{"raw", "the labels as the network has them"}, Words::raw}},
            "The words that zones and areas are called by.");
  return group;
}

InstalledWords loadInstalledWords() {
  const std::optional<fs::path> folder = findWordNet();
  if (!folder)
    return {std::nullopt, environment("ESTANCIA_WORDNET").empty()
                              ? "install WordNet (Debian: wordnet-base) to ask in words that no label has"
                              : fmt::format("ESTANCIA_WORDNET: {} has no data.noun; name WordNet's folder",
                                            environment("ESTANCIA_WORDNET"))};
  const std::string source = sourceOf(*folder);
  const fs::path cache = cacheFile("words", source, "graph");
  if (auto graph = readCached(
          cache, [&](std::string_view bytes) { return unpackWordGraph(bytes, source, cache.string()); }))
    return {std::move(graph), ""};
  try {
    InstalledWords words{buildWordGraph(readWordNet(*folder)), ""};
    if (!writeCached(cache, packWordGraph(*words.graph, source)))
      words.problem = fmt::format(
          "{} cannot be written, so that WordNet is read anew each time, which takes seconds; let "
          "ESTANCIA_CACHE name a folder that can be written",
          cache.string());
    return words;
  } catch (const Error& error) {
    return {std::nullopt, error.what()};
  }
}

namespace {

/// Set when the data were first requested.
std::atomic<const InstalledWords*> loaded = nullptr;

const InstalledWords& installed() {
  static const InstalledWords words = loadInstalledWords();
  loaded = &words;
  return words;
}

}  // namespace

const WordGraph* installedWordGraph() {
  return installed().graph ? &*installed().graph : nullptr;
}

std::shared_ptr<const std::vector<WordAssociation>> installedAssociations(const Vocabulary& vocabulary,
                                                                          Progress& progress) {
  using Associations = std::vector<WordAssociation>;
  const std::optional<fs::path> folder = findWordNet();
  if (!folder) return std::make_shared<Associations>();
  const std::string source = sourceOf(*folder) + "labels " + vocabulary.digest() + '\n';
  const fs::path cache = cacheFile("associations", source, "words");
  if (auto kept = readCached(cache, [&](std::string_view bytes) {
        return unpackAssociationsFile(bytes, source, vocabulary.size(), cache.string());
      }))
    return std::make_shared<Associations>(std::move(*kept));
  const std::optional<WordGraph> graph = loadInstalledWords().graph;
  if (!graph) return std::make_shared<Associations>();
  auto associations = std::make_shared<Associations>(associateWords(*graph, vocabulary, 0, progress));
  writeCached(cache, packAssociationsFile(*associations, source));
  return associations;
}

std::string wordNetHint() {
  return installed().hint;
}

std::string missingWordsHint(WordGraphSource source) {
  return source == nullptr || source() != nullptr ? "" : fmt::format(" ({})", wordNetHint());
}

std::string wordNetProblem() {
  const InstalledWords* words = loaded;
  return words == nullptr ? "" : words->problem;
}

}  // namespace estancia
