// PHOG (pyramid histogram of oriented gradients): directions of edges in ever smaller cells of the image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/describe/descriptor.hpp"

namespace estancia {

struct PhogOptions {
  int bins = 30;
  int levels = 2;
  int range = 360;
  int maxSide = 640;
};
OptionGroup declare(PhogOptions& options);
/// Also throws Error (invalidOption) unless the range is 180 or 360.
void validate(const PhogOptions& options);

/// Σ 4^v · bins numbers (630): level by level, cells row by row. Only edges count (Canny's), each by the
/// magnitude of its gradient; the sum is 1, or 0 where there is no edge at all. `image` is BGR or gray, 8
/// bits, of any size. Throws Error on other images (invalidInput) and on invalid options.
/// Bosch, Zisserman, Muñoz: Representing shape with a spatial pyramid kernel, CIVR 2007.
std::vector<float> phog(const cv::Mat& image, const PhogOptions& options = {});

/// phog() of the view's image.
class Phog final : public Descriptor {
 public:
  explicit Phog(const PhogOptions& options = {}) : options_(options) { validate(options); }
  std::vector<DescriptorPart> parts() const override;
  std::vector<float> describe(const View& view) const override { return phog(view.image, options_); }

 private:
  PhogOptions options_;
};

}  // namespace estancia
