// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/black_box.hpp"

#include "estancia/core/digest.hpp"

#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "estancia/core/vocabulary.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace fs = std::filesystem;

void readBlackBox(ConfigFile& config, std::vector<ConfigFile::Key> keys) {
  for (const char* common : {"name", "type", "labels", "license", "source", "sha256"})
    keys.push_back({common, false, "", [](const toml::node&) {}});
  config.read(keys);
}

std::string blackBoxIdentity(const ModelSpec& spec, const ConfigFile& config,
                             const std::vector<fs::path>& files, const std::vector<std::string>& without) {
  toml::table settings = config.table();
  for (const char* described : {"name", "license", "source", "sha256"}) settings.erase(described);
  for (const auto& key : without) settings.erase(key);
  std::ostringstream text;  // sorted, and without comments
  text << settings << '\n';
  ModelSpec whole = spec;
  for (const auto& file : files)
    if (!fs::is_regular_file(spec.folder / file))
      continue;  // no file, or a program of the system
    else if (file.is_relative())
      whole.sha256.try_emplace(file.lexically_normal().string());  // any digest will do, but it counts
    else
      text << file.string() << ' ' << sha256OfFile(file) << '\n';
  return fmt::format("{} {}", spec.name, modelDigest(whole, text.str()));
}

std::vector<ConfigFile::Key> AnswerSettings::keys(ConfigFile& config) {
  return {
      {"best", false, "how many words are used",
       [this, &config](auto& n) { best = static_cast<std::size_t>(config.integer(n, 1, 1'000'000)); }},
      {"scale", false, "the factor from confidences to probabilities",
       [this, &config](auto& n) { format.scale = config.number(n, 1e-9, 1e9); }},
      {"labels_at", false, "the JSON pointer to the words",
       [this, &config](auto& n) {
         format.at = config.text(n);
         io::requireJsonPointer(format.at,
                                fmt::format("{}:{}", config.path().string(), n.source().begin.line));
       }},
      {"label_key", false, "the member with a word's label",
       [this, &config](auto& n) { format.label = config.text(n); }},
      {"confidence_key", false, "the member with its confidence",
       [this, &config](auto& n) { format.confidence = config.text(n); }},
  };
}

io::WordBook wordBook(const ModelSpec& spec) {
  if (spec.labels.empty()) return {};
  return io::WordBook(readVocabulary(modelFile(spec, spec.labels)));
}

LexicalDescriptor describe(io::WordBook& book, std::vector<LabelProbability> words, std::size_t best,
                           const std::string& source) {
  const auto places = book.place(std::move(words), best, source);
  if (places.empty()) throw FrameError(fmt::format("{}: no words for this image", source));
  return book.toDescriptor(places);
}

}  // namespace estancia
