// Label cache: descriptors by image content and model, kept on disk between runs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

}  // namespace estancia
