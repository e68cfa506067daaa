// GIST: filter energies of an image by scale, orientation and position (spatial envelope).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/describe/descriptor.hpp"

namespace estancia {

/// 512 numbers ≥ 0: for each of 4 scales (the finest first) and 8 orientations the mean magnitude of a Gabor
/// filter's response in 4 × 4 blocks, row by row. `image` is BGR or gray, 8 bits, of any size: its central
/// square is resized to 256 × 256 pixels, and its local contrast normalized. All 0 for an image without
/// contrast. Throws Error (invalidInput) on other images.
///
/// Oliva, Torralba: Modeling the shape of the scene, IJCV 42(3), 2001, with all parameters, sizes and borders
/// of the authors' own program, so that its numbers compare with published ones. Block means are taken over
/// a regular pattern of samples of the responses instead of all pixels: within 0.3 % (tests/describe).
std::vector<float> gist(const cv::Mat& image);

/// gist() of the view's image.
class Gist final : public Descriptor {
 public:
  std::vector<DescriptorPart> parts() const override;
  std::vector<float> describe(const View& view) const override { return gist(view.image); }
};

}  // namespace estancia
