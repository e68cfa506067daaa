// Frame sample: which frames of each place a map of bounded size keeps. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/bytes.hpp"

namespace estancia {

/// A weighted sample of each place's frames, without replacement, as the frames come: a frame has a random
/// key that is exponential with its information as rate (Efraimidis & Spirakis, Information Processing
/// Letters 2006), and the k smallest keys of a place stay, whichever came first. All places have the same k,
/// so that a robot that waits somewhere for a day takes no room from the others. Deterministic: a key follows
/// from the frame's number.
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
  void merge(int absorbed);
  /// Nodes with this id or a higher one are new.
  void forgetFrom(int node) { bounds_.erase(bounds_.lower_bound(node), bounds_.end()); }

  std::string state() const;
  void restore(ByteReader& in);

 private:
  /// The largest key that a place with more frames than k keeps.
  std::map<int, double> bounds_;
};

}  // namespace estancia
