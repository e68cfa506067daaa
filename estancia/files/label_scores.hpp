// Label scores: labels with confidences from programs, services and people, and their index in a descriptor.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia::io {

/// Where labels stand in JSON: an object {LABEL: confidence, …} or a list [{"label": …, "confidence": …}].
struct WordFormat {
  /// A JSON pointer (RFC 6901: "/outputs/0/data"); "" takes `labels`, or a list that is the whole answer.
  std::string at;
  /// Names of the members in a list.
  std::string label = "label", confidence = "confidence";
  /// Factor from confidences to probabilities.
  double scale = 1;
};

/// One image's answer in JSON.
struct Answer {
  /// Its member `image`, "" where there is none.
  std::string image;
  /// Its member `error`: why there are no labels; "" on success.
  std::string error;
  /// In the order written (of an object: sorted by label).
  std::vector<LabelProbability> words;
};

/// Throws Error `SOURCE: …` when the text is no such answer.
Answer readAnswer(std::string_view json, const WordFormat& format, const std::string& source);

/// Throws Error unless `at` is a JSON pointer; `source` names its place in messages.
void requireJsonPointer(const std::string& at, const std::string& source);

/// `value` as a probability: clamped when it is within rounding of [0, 1], otherwise Error `SOURCE: …` with
/// label and value. Percentages are refused.
float toProbability(double value, const std::string& label, const std::string& source);

/// A label without blanks at its ends, control characters as \xNN. Throws Error when it is empty or too long.
std::string toLabel(std::string_view text, const std::string& source);

/// Maps labels to their index in the descriptor. The vocabulary is given, or open: then every new label gets
/// the next index, those of one answer by decreasing probability, then by name; zero probabilities have none.
///
/// A label may occur in several lines of a given vocabulary (ImageNet has two cranes): the first "crane" of
/// an answer then belongs to the first of them, the second to the second; more of them keep the largest.
class WordBook {
 public:
  /// Open vocabulary.
  WordBook() = default;
  /// Given vocabulary: other labels are dropped.
  explicit WordBook(Vocabulary vocabulary);

  bool discovers() const { return !given_; }
  std::size_t size() const { return discovers() ? labels_.size() : vocabulary_->size(); }
  /// Throws Error while no label is known yet.
  const Vocabulary& vocabulary() const;

  /// Indices, each once, with probabilities.
  using Places = std::vector<std::pair<std::uint32_t, float>>;
  /// At most the `best` labels of one answer, 0 = all. Throws Error `SOURCE: …` beyond 100,000 labels.
  Places place(std::vector<LabelProbability> words, std::size_t best, const std::string& source);

  /// size() probabilities, 0 for missing labels.
  LexicalDescriptor toDescriptor(const Places& places) const;

 private:
  bool given_ = false;
  std::map<std::string, std::vector<std::uint32_t>, std::less<>> places_;
  std::vector<std::string> labels_;               // labels of an open vocabulary
  mutable std::optional<Vocabulary> vocabulary_;  // made on request
};

}  // namespace estancia::io
