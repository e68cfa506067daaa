// SPDX-License-Identifier: Apache-2.0
#include "labeling.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

/// All words of a labeler that discovers them, for the frames of the command.
class Recorder {
 public:
  Recorder(const Sequence& sequence, LabelStreamOptions options) : sequence_(sequence), options_(options) {}

  DescriptorSequence run(Labeler& labeler) {
    Skipped skipped;
    progress_->begin("labeling", sequence_.size());
    DescriptorSequence recording = record(sequence_, labeler, options_, [&](const LabeledFrame& frame) {
      if (!frame.labeled()) skipped.add(frame.problem);
      if (frame.remembered) ++remembered;
      progress_->advance();
      if (interrupted())
        throw Interrupted(
            fmt::format("stopped after {} of {} frames{}", frame.index + 1, sequence_.size(),
                        options_.cache != nullptr ? "; their labels are kept in the cache" : ""));
    });
    progress_->end();
    return recording;
  }
  std::size_t remembered = 0;

 private:
  const Sequence& sequence_;
  LabelStreamOptions options_;
  std::unique_ptr<Progress> progress_ = makeStderrProgress();
};

/// One frame of another sequence.
class OneFrame : public Sequence {
 public:
  OneFrame(const Sequence& sequence, std::size_t frame) : sequence_(sequence), frame_(frame) {}
  std::string name() const override { return sequence_.name(); }
  std::size_t size() const override { return 1; }
  const Frame& frame(std::size_t /*i*/) const override { return sequence_.frame(frame_); }
  cv::Mat image(std::size_t /*i*/) const override { return sequence_.image(frame_); }
  cv::Mat reducedImage(std::size_t /*i*/, int side) const override {
    return sequence_.reducedImage(frame_, side);
  }
  std::string fingerprint(std::size_t /*i*/) const override { return sequence_.fingerprint(frame_); }

 private:
  const Sequence& sequence_;
  std::size_t frame_;
};

}  // namespace

void ModelArguments::addTo(DeclaredOptions& declared, const std::string& what) {
  declared.command().add_option(
      "--model", model,
      fmt::format("{}: a name of `models list`, a folder, or several joined by +\nDefault: {}", what,
                  byDefault));
  addRunningTo(declared);
}

void ModelArguments::addRunningTo(DeclaredOptions& declared) {
  addLabelerTo(declared);
  declared.add(declare(stream), {"strict"});
  declared.command().add_flag("--no-cache", noCache, "Label every image again; leave the label cache alone");
}

void ModelArguments::addLabelerTo(DeclaredOptions& declared) {
  declared.add(declare(options), {"engine", "precision", "reduced-images"});
}

std::unique_ptr<Labeler> ModelArguments::open() const {
  LabelerOptions how = options;
  how.onDemand = how.onDemand || !noCache;
  return loadModel(model.empty() ? byDefault : model, how);
}

Labeling::Labeling(const SequenceArguments& frames, const ModelArguments& model, const Vocabulary* words)
    : sequence_(frames.open()),
      cache_(model.noCache ? nullptr : std::make_unique<LabelCache>()),
      stream_(model.stream) {
  stream_.cache = cache_.get();
  if (isDescriptorFile(frames.path)) {
    if (!model.model.empty())
      throw Error(ErrorCode::invalidOption,
                  fmt::format("{} holds words already; leave out --model", frames.path));
    DescriptorSequence recording = readDescriptors(frames.path);
    if (words != nullptr && !(recording.vocabulary == *words)) recording = toVocabulary(recording, *words);
    labeler_ = std::make_unique<RecordedLabeler>(std::move(recording));
    return;
  }
  labeler_ = model.open();
  if (!labeler_->discovers()) return;
  Recorder recorder(*sequence_, stream_);
  DescriptorSequence recording = recorder.run(*labeler_);
  remembered_ = recorder.remembered;
  if (words != nullptr) recording = toVocabulary(recording, *words);
  labeler_ = std::make_unique<RecordedLabeler>(std::move(recording));
}

std::size_t Labeling::forEach(std::size_t first, const std::string& what,
                              const std::function<void(const LabeledFrame&)>& use) {
  const auto progress = makeStderrProgress();
  LabelStreamOptions options = stream_;
  first = options.first = std::max(first, stream_.first);
  LabelStream stream(*sequence_, *labeler_, options);
  std::size_t used = 0;
  Skipped skipped;
  if (!what.empty()) progress->begin(what, sequence_->size(), first);
  while (const auto frame = stream.next()) {
    if (frame->labeled()) {
      use(*frame);
      ++used;
      if (frame->remembered) ++remembered_;
    } else {
      skipped.add(frame->problem);
    }
    progress->advance();
    if (interrupted())
      throw Interrupted(fmt::format("stopped after {} of {} frames", frame->index + 1, sequence_->size()));
  }
  progress->end();
  if (cache_ && !cache_->problem().empty()) spdlog::warn("{}", cache_->problem());
  if (used == 0 && first < sequence_->size())
    throw Error(ErrorCode::fileUnreadable, fmt::format("{}: none of the {} frames can be read",
                                                       sequence_->name(), sequence_->size() - first));
  return skipped.count();
}

LexicalDescriptor Labeling::words(std::size_t frame) {
  const OneFrame one(*sequence_, frame);
  LabelStream stream(one, *labeler_,
                     {.strict = stream_.strict, .ahead = 1, .readers = 1, .cache = stream_.cache});
  const LabeledFrame labeled = *stream.next();
  if (labeled.remembered) ++remembered_;
  if (!labeled.labeled()) spdlog::warn("no words: {}", labeled.problem);
  return labeled.descriptor;
}

}  // namespace estancia::apps
