// The words: an ordered list of labels, identified by a digest.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace estancia {

/// An ordered list of labels L = {l_1 … l_L}. A label line may hold synonyms: "cup, mug".
/// Invariant: at least one label, none empty; position i belongs to value i of every descriptor.
class Vocabulary {
 public:
  /// Throws Error on an empty list or an empty label.
  explicit Vocabulary(std::vector<std::string> labels);

  /// One label a line (UTF-8, CR and trailing blanks dropped, empty last lines ignored).
  /// Throws Error naming file and line.
  static Vocabulary fromFile(const std::filesystem::path& path);

  std::size_t size() const { return labels_.size(); }
  const std::string& operator[](std::size_t i) const { return labels_[i]; }
  const std::vector<std::string>& labels() const { return labels_; }

  /// SHA-256 (64 hex digits) over the labels in order: two vocabularies are the same iff their digests are.
  const std::string& digest() const { return digest_; }

  bool operator==(const Vocabulary& other) const { return digest_ == other.digest_; }

 private:
  std::vector<std::string> labels_;
  std::string digest_;
};

/// Throws Error saying how the two differ (sizes, first different label) unless they are equal.
void requireSameVocabulary(const Vocabulary& expected, const Vocabulary& actual, const std::string& context);

}  // namespace estancia
