// Words with confidences, as programs, services and people give them, and their places in a descriptor.
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
#include "estancia/core/label_probability.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia::io {

/// How JSON says words: an object {LABEL: confidence, …}, or a list [{"label": …, "confidence": …}, …].
struct WordFormat {
  /// Where they are, a JSON pointer (RFC 6901: "/outputs/0/data"); "" takes the member `labels`, or a list
  /// that is the whole answer.
  std::string at;
  std::string label = "label", confidence = "confidence";  ///< the members' names in a list
  double scale = 1;                                        ///< the factor from confidences to probabilities
};

/// One image's answer in JSON.
struct Answer {
  std::string image;                    ///< its member `image`, "" where there is none
  std::string error;                    ///< its member `error`: why there are no words; "" when all is well
  std::vector<LabelProbability> words;  ///< in the order written (of an object: sorted by label)
};

/// Throws Error `SOURCE: …` when the text is no such answer.
Answer readAnswer(std::string_view json, const WordFormat& format, const std::string& source);

/// Throws Error unless `at` is a JSON pointer; `source` says where it stands.
void requireJsonPointer(const std::string& at, const std::string& source);

/// `value` as a probability: clamped when it is outside of [0, 1] by no more than rounding, otherwise Error
/// `SOURCE: …` naming label and value. Percentages are not guessed.
float toProbability(double value, const std::string& label, const std::string& source);

/// A label fit for a vocabulary: blanks at its ends dropped, control characters shown as \xNN. Throws Error
/// when nothing is left, or it is longer than a label can be.
std::string toLabel(std::string_view text, const std::string& source);

/// Finds the place of each word in the descriptor. The vocabulary is given, or discovered on the way: then
/// every new word gets the next place, those of one answer by falling probability, equal ones by name; a word
/// of probability 0 is as good as none.
///
/// A label may stand in several lines of a given vocabulary (ImageNet has two cranes): an answer's first
/// "crane" then belongs to the first of them, its second to the second. A word that comes more often than it
/// has places keeps its greatest probability.
class WordBook {
 public:
  WordBook() = default;                      ///< discovers
  explicit WordBook(Vocabulary vocabulary);  ///< given: other words are dropped

  bool discovers() const { return !given_; }
  std::size_t size() const { return discovers() ? labels_.size() : vocabulary_->size(); }
  /// Throws Error while no word is known yet.
  const Vocabulary& vocabulary() const;

  using Places = std::vector<std::pair<std::uint32_t, float>>;  ///< places, each once, with probabilities
  /// At most the `best` words of one answer, 0 = all. Throws Error `SOURCE: …` when there come more than
  /// 100,000 different words.
  Places place(std::vector<LabelProbability> words, std::size_t best, const std::string& source);

  /// size() probabilities, 0 where there is no word.
  LexicalDescriptor toDescriptor(const Places& places) const;

 private:
  bool given_ = false;
  std::map<std::string, std::vector<std::uint32_t>, std::less<>> places_;
  std::vector<std::string> labels_;               // when discovering
  mutable std::optional<Vocabulary> vocabulary_;  // made when asked for
};

}  // namespace estancia::io
