// Label stream: labels the frames of a sequence in order; decoding runs ahead, cached labels are reused.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

/// Descriptors on disk, one file a model: a log of records (key, checksum, value), to which several
/// processes may append at once. What is cut off or damaged is not found, and labeled again. Safe to use
/// from several threads.
class LabelCache {
 public:
  /// The default folder: $ESTANCIA_CACHE, else $XDG_CACHE_HOME/estancia/labels, else
  /// ~/.cache/estancia/labels.
  static std::filesystem::path defaultFolder();
  /// $ESTANCIA_CACHE_MB megabytes, else 2 GB. Throws Error when that variable is no number.
  static std::uint64_t defaultLimit();

  /// Nothing is created before the first put(). When all files together exceed `limit` [bytes], the models
  /// used longest ago go first, then the older half of what is left.
  explicit LabelCache(std::filesystem::path folder = defaultFolder(), std::uint64_t limit = defaultLimit());
  ~LabelCache();
  LabelCache(const LabelCache&) = delete;
  LabelCache& operator=(const LabelCache&) = delete;

  /// `model` is Labeler::cacheKey(), `image` Sequence::fingerprint().
  std::optional<std::string> find(const std::string& model, const std::string& image);

  /// Remembers `value`. Never throws: what cannot be written is not cached, see problem().
  void put(const std::string& model, const std::string& image, std::string_view value);

  /// Why nothing is being written (disk full, read-only …), one sentence; "" when all is well.
  std::string problem() const;

  struct Usage {
    /// Its cacheKey().
    std::string model;
    std::uint64_t images = 0;
    std::uint64_t bytes = 0;
  };
  /// Content of the folder, the model used last first.
  std::vector<Usage> usage() const;
  const std::filesystem::path& folder() const { return folder_; }
  std::uint64_t limit() const { return limit_; }

  /// Removes everything. Returns how many bytes that frees.
  std::uint64_t clear();

 private:
  class File;
  File& fileOf(const std::string& model);
  void makeRoom(File& current);

  std::filesystem::path folder_;
  std::uint64_t limit_;
  mutable std::mutex mutex_;
  /// By model.
  std::map<std::string, std::unique_ptr<File>> files_;
  /// Bytes to write before the limit is looked at again.
  std::uint64_t untilCheck_ = 0;
  std::string problem_;
};

class OptionGroup;

struct LabelStreamOptions {
  /// The first frame to label.
  std::size_t first = 0;
  /// Throw Error at an unreadable frame instead of reporting it.
  bool strict = false;
  /// Frames prepared ahead; each holds its image, so memory stays bounded.
  std::size_t ahead = 16;
  /// Threads that decode and prepare.
  std::size_t readers = 2;
  /// Looked into first and added to; must outlive the stream.
  LabelCache* cache = nullptr;
};

OptionGroup declare(LabelStreamOptions& options);

/// A frame with its labels, or the reason why it has none.
struct LabeledFrame {
  /// In the sequence.
  std::size_t index = 0;
  /// Empty when the frame has no words.
  LexicalDescriptor descriptor;
  /// Image from Sequence::image(); empty when it was not needed (also when the network saw it reduced) or
  /// cannot be read.
  cv::Mat image;
  /// Why the frame has no words, one sentence; "" when all is well.
  std::string problem;

  /// Its words were in the cache: the image was not labeled.
  bool remembered = false;

  bool labeled() const { return problem.empty(); }
};

/// Labels the frames of a sequence in order. Background threads decode and prepare the next frames while
/// the caller's thread infers, so that the stream runs at the network's speed. Sequence and labeler must
/// outlive the stream.
class LabelStream {
 public:
  LabelStream(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {});

  /// Stops the background threads; at any time.
  ~LabelStream();
  LabelStream(const LabelStream&) = delete;
  LabelStream& operator=(const LabelStream&) = delete;

  /// The next frame, or nothing after the last. Throws what inference throws, and what the sequence throws
  /// that is not one frame's failure (see frameFailure(); with `strict`: that too); after an exception the
  /// stream is at its end. When the labeler discovers words, earlier descriptors are shorter than later ones.
  std::optional<LabeledFrame> next();

 private:
  class Reader;
  class Inference;
  std::unique_ptr<Inference> inference_;
  std::unique_ptr<Reader> reader_;  // last: its threads use the labeler
};

/// Labels every frame; frames without labels are left out. Where the labeler discovers its vocabulary, all
/// descriptors have the labels known at the end. `watch` sees each frame as it comes (for progress; throw to
/// stop). Throws Error when no frame at all has labels, and what the stream throws.
DescriptorSequence record(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {},
                          const std::function<void(const LabeledFrame&)>& watch = {});

/// record() with progress, shown as `what`. Throws Interrupted when the user asks to stop.
DescriptorSequence labelAll(const Sequence& sequence, Labeler& labeler, const std::string& what,
                            const LabelStreamOptions& options = {}, Progress& progress = Progress::none(),
                            const std::function<void(const LabeledFrame&)>& watch = {});

}  // namespace estancia
