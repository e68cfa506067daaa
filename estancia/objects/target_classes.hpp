// The words of a study, and what labelers and data sets call them (thesis 6.3).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Invariant: at least one word; names differ; no category belongs to two words.
struct TargetClasses {
  struct Word {
    std::string name;
    std::vector<std::string> labels;      ///< what labelers call it, as in a question: "coffee mug"
    std::vector<std::string> categories;  ///< what data sets call it
  };
  std::vector<Word> words;

  /// TOML: a table `[words.NAME]` a word with `labels` and `categories`, both its name where they are
  /// missing. Throws Error `file:line: …`.
  static TargetClasses fromFile(const std::filesystem::path& file);

  /// Each category is a word by its own name.
  static TargetClasses ofCategories(const std::vector<std::string>& categories);

  std::vector<std::string> names() const;

  /// The word of a category; −1 where it is none of the study's.
  int wordOf(const std::string& category) const;
};

/// What breaks the invariant of Study, as a sentence; "" where nothing does.
std::string flawOf(const TargetClasses& study);

/// What a labeler says of N samples in the W words of a study.
struct ClassProbabilities {
  DescriptorMatrix shares;  ///< N×W; a row adds up to 1, or is all 0 where nothing was said of the words
  std::vector<float> mass;  ///< N; what the words had together of the labeler's whole answer, 0 … 1
};

/// A sentence for each label that the vocabulary has not, with its nearest spellings, of words that have
/// others there: they are looked for by these alone.
std::vector<std::string> unknownLabels(const TargetClasses& study, const Vocabulary& vocabulary);

/// The labels of each word in the vocabulary of a labeler, found once for all that it will say.
class VocabularyMapping {
 public:
  /// Labels are found by findLabels(); one that fits two words counts for the first. Throws Error when the
  /// vocabulary has no label of some word, naming all of them with their nearest spellings, or none that does
  /// not count for another already.
  VocabularyMapping(const TargetClasses& study, const Vocabulary& vocabulary);

  /// Adds up the labels of each word, then scales the words to a whole: the thesis' restriction of the labels
  /// to those of the study. Throws Error when a descriptor is no row of probabilities over the vocabulary.
  ClassProbabilities apply(const DescriptorMatrix& descriptors) const;

 private:
  std::size_t words_;
  std::vector<std::size_t> wordOf_;  ///< of each label
};

/// The same for one time.
ClassProbabilities restrictTo(const TargetClasses& study, const Vocabulary& vocabulary,
                              const DescriptorMatrix& descriptors);

/// How often the labeler says each word: the mean of the rows that say anything; even where none does. W
/// numbers that add up to 1.
std::vector<float> priorOf(const ClassProbabilities& shares);

/// The same shares for words that are equally frequent: each divided by its `prior`, then scaled to a whole,
/// as the labeler knows more labels for some words, and likes some better (Saerens, Latinne, Decaestecker,
/// Neural Computation 14, 2002). No prior counts as below 0.001. Throws Error on a prior of other words.
ClassProbabilities corrected(const ClassProbabilities& shares, std::span<const float> prior);

}  // namespace estancia
