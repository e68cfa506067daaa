// Thumbnails: room for small images in a drawing, so that none hides another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "estancia/figures/svg.hpp"

namespace estancia::report {

class Thumbnails {
 public:
  /// Images stay in `frame`; `size`: their width and height [CSS pixels].
  Thumbnails(const Box& frame, double size) : frame_(frame), size_(size) {}

  /// Nothing may cover this.
  void block(const Box& box) { taken_.push_back(box); }
  /// A square at the point, else beside it, else a smaller one there; nothing where there is no room.
  std::optional<Box> take(const Point& at);

 private:
  bool isFree(const Box& box) const;

  Box frame_;
  double size_;
  std::vector<Box> taken_;
};

}  // namespace estancia::report
