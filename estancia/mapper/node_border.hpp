// Border of a node: its first and last images weigh less in its mean, since they may show the next place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace estancia {

/// The weights of the thesis author's program: i/k for the first and last k images of a node, i from 0 at its
/// ends, and 1 between. A node of fewer than 2k images has no ends yet: all weigh 1.
///
/// Invariant: `images` are all of the node's until it has ends, then the last k at most, oldest first. Empty
/// after the node has taken in another one: the weights stay as they were then, and only its end is still to
/// come.
struct NodeBorder {
  struct Image {
    std::size_t frame = 0;
    std::vector<float> probabilities, embedded;
  };
  std::vector<Image> images;

  /// Adds the node's next image, of `before` so far. `change` is called for each image whose weight changes,
  /// with the difference; what it takes away never exceeds what it has given.
  void add(Image image, std::uint64_t before, std::size_t k,
           const std::function<void(const Image&, double)>& change);
};

}  // namespace estancia
