// Model file: magic, version and digest around a trained model.
// SPDX-License-Identifier: Apache-2.0
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
  /// The first eight bytes of the file.
  std::string_view magic;
  /// The version that is written, and the only one that is read.
  std::uint32_t version;
  /// For messages: "room classifier".
  std::string_view noun;
  /// The command that writes it: "estancia classify train".
  std::string_view command;
};

constexpr ModelFileKind roomClassifierKind{"ESTROOMS", 2, "room classifier", "estancia classify train"},
    objectModelKind{"ESTOBJCT", 1, "object model", "estancia objects train"};

/// Writes atomically. Throws Error as writeWhole().
void writeModelFile(const std::filesystem::path& file, const ModelFileKind& kind, std::string_view content);

/// An open model file of the right kind and version, whose digest is right. Its content may still be hostile.
class ModelFileReader {
 public:
  /// Throws Error (unsupportedFile, corruptFile, fileUnreadable).
  ModelFileReader(const std::filesystem::path& file, const ModelFileKind& kind);

  ModelFileReader(const ModelFileReader&) = delete;
  ModelFileReader& operator=(const ModelFileReader&) = delete;

  ByteReader& content() { return in_; }
  /// Throws Error (malformedFile) unless all texts are UTF-8 without control characters.
  void requirePrintable(const std::vector<std::string>& texts) const;
  /// The embedding and the classifier at the end of the content. Throws Error (malformedFile) when anything
  /// follows, and unless they fit each other and the number of classes.
  std::pair<FeatureEmbedding, std::shared_ptr<const Classifier>> classifier(std::size_t classes);

 private:
  std::string bytes_;
  ByteReader in_;
};

/// Whether the file begins with the magic.
bool isModelFile(const std::filesystem::path& file, const ModelFileKind& kind);

}  // namespace estancia
