// Room in a drawing: places for labels and small images that cover nothing that is already there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "estancia/figures/svg.hpp"

namespace estancia::report {

/// Where a label stands beside its point, and the side its text is written from.
struct LabelPlace {
  Box box;
  double x = 0;        ///< position of the text's anchor
  std::string anchor;  ///< "start", "middle", "end"
};

/// Places for labels.
class LabelPlaces {
 public:
  /// Labels stand beside discs and stay in a frame of this size; few cross the lines (pairs of discs). What
  /// is handed in must outlive this object.
  LabelPlaces(double width, double height, const std::vector<Point>& centers,
              const std::vector<double>& radii, std::vector<std::pair<std::size_t, std::size_t>> lines = {});

  /// The best of eight places round a disc for a label of this size, touching no disc and no other label, and
  /// as few lines as can be; nothing when there is none. It stays in the frame in a wider font, too.
  std::optional<LabelPlace> take(std::size_t disc, double width, double height);

  void block(const Box& box) { taken_.push_back(box); }

 private:
  bool isInside(const LabelPlace& place) const;
  bool isFree(const Box& box) const;

  Box frame_;
  const std::vector<Point>& centers_;
  const std::vector<double>& radii_;
  std::vector<std::pair<std::size_t, std::size_t>> lines_;
  std::vector<Box> taken_;
};

/// Places for images.
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
