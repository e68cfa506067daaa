// What the files of all learned models have in common: a name, a version, and a digest of the rest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/core/bytes.hpp"

namespace estancia {

struct ModelFileKind {
  std::string_view magic;    ///< eight bytes that the file begins with
  std::uint32_t version;     ///< that is written, and the only one that is read
  std::string_view noun;     ///< for messages: "room classifier"
  std::string_view command;  ///< that writes it: "estancia classify train"
};

/// Writes the content whole or not at all. Throws Error as writeWhole() does.
void writeModelFile(const std::filesystem::path& file, const ModelFileKind& kind, std::string_view content);

/// A model file that is open: of the right kind and version, and not damaged by accident. What stands in it
/// may still be a forgery.
class ModelFileReader {
 public:
  /// Throws Error unless it is such a file.
  ModelFileReader(const std::filesystem::path& file, const ModelFileKind& kind);

  ModelFileReader(const ModelFileReader&) = delete;
  ModelFileReader& operator=(const ModelFileReader&) = delete;

  ByteReader& content() { return in_; }
  /// Throws Error unless all of these can be shown on a terminal.
  void requirePrintable(const std::vector<std::string>& texts) const;
  /// The embedding and the classifier of its coordinates that end the content. Throws Error when something
  /// follows, and unless they fit each other and so many classes.
  std::pair<FeatureEmbedding, std::shared_ptr<const Classifier>> classifier(std::size_t classes);

 private:
  std::string bytes_;
  ByteReader in_;
};

/// Whether the file begins as one does, sound or not, whatever its name.
bool isModelFile(const std::filesystem::path& file, const ModelFileKind& kind);

}  // namespace estancia
