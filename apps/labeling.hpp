// Labeling: the model of a command, how to run it, and the frames it labels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "common.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"

namespace estancia::apps {

struct ModelArguments {
  /// "" takes `byDefault`.
  std::string model;
  std::string byDefault = defaultModel;
  LabelerOptions options;
  LabelStreamOptions stream;
  bool noCache = false;

  /// Adds `--model`, always a network, explained by `what`, and how it labels: the groups "labeler" and
  /// "label-stream", `--engine`, `--threads`, `--strict`, `--no-cache`.
  void addTo(DeclaredOptions& declared, const std::string& what);
  /// Without `--model`.
  void addRunningTo(DeclaredOptions& declared);
  /// Only the group "labeler".
  void addLabelerTo(DeclaredOptions& declared);
  std::unique_ptr<Labeler> open() const;
};

/// The frames of a command and whatever gives them words: a model, or SEQ itself when it is a recording.
class Labeling {
 public:
  /// `words`: the vocabulary that is wanted, if any. Recordings, and labelers that discover their words, are
  /// put into it; where they discover them and none is wanted, all frames are labeled at once to know them.
  Labeling(const SequenceArguments& frames, const ModelArguments& model, const Vocabulary* words = nullptr);

  const Sequence& sequence() const { return *sequence_; }
  const Vocabulary& vocabulary() const { return labeler_->vocabulary(); }
  std::string identity() const { return labeler_->identity(); }
  /// For other images than the frames; not while a frame is being labeled.
  Labeler& labeler() { return *labeler_; }

  /// Labels the frames from `first` on with a progress bar (without one where `what` is ""), warns of frames
  /// that have no words and gives the others to `use`. Throws Interrupted on Ctrl-C, Error when no frame at
  /// all has words. Returns how many have none.
  std::size_t forEach(std::size_t first, const std::string& what,
                      const std::function<void(const LabeledFrame&)>& use);

  /// The words of one frame; empty, with a warning, when it has none.
  LexicalDescriptor words(std::size_t frame);

  /// Frames so far whose words were in the cache.
  std::size_t remembered() const { return remembered_; }

 private:
  std::unique_ptr<Sequence> sequence_;
  std::unique_ptr<Labeler> labeler_;
  std::unique_ptr<LabelCache> cache_;
  LabelStreamOptions stream_;
  std::size_t remembered_ = 0;
};

}  // namespace estancia::apps
