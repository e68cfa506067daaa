// Map run: the map file of one run, created at its first frame, replaced, or resumed. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "estancia/session/session.hpp"

namespace estancia {

/// One run of mapping a sequence into a file. begin() opens an existing map, start() or the first add()
/// creates a new one, finish() writes everything. Invariant: until then an older file is unchanged.
class MapRun {
 public:
  /// The numbers of MapSequenceOptions::Existing.
  enum class Existing { refuse, replace, resume };

  /// Throws Error (fileExists), before the long work begins, when a map is there and to be refused.
  MapRun(std::filesystem::path path, Existing existing);

  /// Changes the map's budget, before begin(): a resumed map keeps what `change` leaves alone.
  void changeBudget(std::function<void(MapBudget&)> change) { changeBudget_ = std::move(change); }

  /// The labels of the map that is resumed; nothing for a new one.
  std::optional<Vocabulary> vocabulary() const;

  /// Begins with labels that `model` gives to `sequence`. Returns the first frame to add: where the last run
  /// stopped in it, or the first one of another drive, whose poses are in the map's frame or in any other.
  /// `change` makes the options of a new map from the defaults; a resumed map keeps its own. Throws Error as
  /// MappingSession::resume() and firstUnmapped() do, and mismatch where `change` would alter kept options.
  std::size_t begin(const Sequence& sequence, const Vocabulary& vocabulary, const std::string& model,
                    const std::function<void(MapperOptions&)>& change, bool posesAreInMap = false);

  /// The session of the next frame; creates a new map. For who writes more into the map, before add().
  MappingSession& start();
  /// For who looks at frames before add(): begins another drive if the next frame is one's, and returns so.
  bool beginDrive();
  /// Whether beginDrive() is to begin one.
  bool beginsDrive() const { return beginsDrive_; }
  /// Maps the next frame. With the first one a new map is created, and only now an old one replaced.
  void add(const Frame& frame, DescriptorView descriptor, const MappingSession::Image& image = {});
  /// Writes everything.
  void finish() {
    if (session_) session_->finish();
  }

  /// Nothing before the first frame of a new map.
  const std::optional<MappingSession>& session() const { return session_; }
  /// Frames that were mapped by earlier runs.
  std::size_t framesBefore() const { return framesBefore_; }

 private:
  std::filesystem::path path_;
  Existing existing_;
  std::function<MappingSession()> create_;
  std::function<void(MapBudget&)> changeBudget_;
  std::optional<MappingSession> session_;
  std::size_t framesBefore_ = 0;
  bool beginsDrive_ = false;
  DriveStart start_;
};

}  // namespace estancia
