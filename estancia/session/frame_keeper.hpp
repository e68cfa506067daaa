// Frame keeper: keeps a map file within its budget while it is written, by samples of its places. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/map_file/store.hpp"

namespace estancia {

/// A weighted sample of each place's frames, without replacement, as the frames come: a frame has a random
/// key that is exponential with its information as rate (Efraimidis & Spirakis, Information Processing
/// Letters 2006), and the k smallest keys of a place stay. All places have the same k, so that a robot that
/// waits somewhere for a day takes no room from the others. A key follows from the frame's number.
class FrameSample {
 public:
  struct Entry {
    std::size_t frame = 0;
    int node = 0;
    double key = 0;
    /// In the file.
    std::uint64_t bytes = 0;
    /// Stays whatever its key.
    bool isNeeded = false;
  };

  /// `information`: above 0; of two frames the one with twice the information stays twice as likely.
  static double keyOf(std::size_t frame, double information);

  /// Whether the next frame of that key is in the sample.
  bool takes(int node, double key) const;
  /// The frames to leave out so that the others have at most `bytes`, and later ones of these places may
  /// take their places; nothing where the needed ones and one of each other place have more.
  std::optional<std::vector<std::size_t>> thin(const std::vector<Entry>& entries, std::uint64_t bytes);
  /// Bytes of the needed frames and of one of each other place.
  static std::uint64_t minBytes(const std::vector<Entry>& entries);
  void merge(int absorbed) { bounds_.erase(absorbed); }
  /// Nodes with this id or a higher one are new.
  void forgetFrom(int node) { bounds_.erase(bounds_.lower_bound(node), bounds_.end()); }

  std::string state() const;
  void restore(ByteReader& in);

 private:
  /// The largest key that a place with more frames than k keeps.
  std::map<int, double> bounds_;
};

/// A frame that the sample of its place does not take waits until the next writing: where the mapper needs
/// it then to go on later, it is in the file as long as that lasts; else it is left out. When the file has
/// grown to its budget, the samples are made smaller. Needed frames are given as sorted numbers.
///
/// Invariant: waiting_ frames are in memory only, borrowed_ ones are in the file as long as they are needed,
/// leftOut_ ones were dropped since the last endWriting(). A writing is takeNeeded(), endWriting(), the
/// commit, fit().
class FrameKeeper {
 public:
  /// A row, its decision, its pose, and what points at them [bytes].
  static constexpr std::uint64_t rowBytes = 250;

  /// `bytes`: of the file. `store` must outlive it, and is open for writing.
  FrameKeeper(MapStore& store, std::uint64_t bytes) : store_(&store), budget_(bytes) {}

  struct Waiting {
    MappedFrame frame;
    LexicalDescriptor descriptor;
    /// Pose as it was given, where that is to be kept.
    std::optional<Pose> given;
  };
  bool takes(const Decision& decision) const;
  void wait(Waiting frame) { waiting_.push_back(std::move(frame)); }
  /// A frame has been put into the file.
  void count(std::uint64_t bytes) { written_ += bytes; }
  /// True when waiting or written bytes exceed the threshold at which everything is written.
  bool isDue() const;

  /// Takes the needed frames out of the waiting ones, to be written now; the others are left out.
  std::vector<Waiting> takeNeeded(const std::vector<std::size_t>& needed);
  /// Since the last endWriting().
  bool isLeftOut(std::size_t frame) const { return leftOut_.contains(frame); }
  void merge(int absorbed) { sample_.merge(absorbed); }
  /// Nodes with this id or a higher one are new.
  void forgetFrom(int node) { sample_.forgetFrom(node); }
  /// Frames that were only in the file because they were needed, and are no longer, are left out.
  void endWriting(const std::vector<std::size_t>& needed);
  /// Whether fit() would leave something out.
  bool isFull() const;
  /// After a commit. Throws Error (tooLarge) where what must stay is larger than the budget.
  void fit(const std::vector<std::size_t>& needed);

  std::string state() const { return sample_.state(); }
  void restore(ByteReader& in) { sample_.restore(in); }

 private:
  std::vector<FrameSample::Entry> entries(const std::vector<std::size_t>& needed) const;

  MapStore* store_;
  std::uint64_t budget_, written_ = 0;
  FrameSample sample_;
  std::vector<Waiting> waiting_;
  std::set<std::size_t> leftOut_, borrowed_;
};

/// Frames that any budget keeps, in order: the first ones of drives, the newest, those observed in space.
std::vector<std::size_t> framesThatStay(MapStore& store);

}  // namespace estancia
