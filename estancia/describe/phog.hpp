// Pyramid histogram of oriented gradients: which way edges run, in ever smaller parts of the image.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/describe/descriptor.hpp"

namespace estancia {

struct PhogOptions {
  int bins = 30;    ///< of orientation, in every cell
  int levels = 2;   ///< the last level; level v has 2^v × 2^v cells
  int range = 360;  ///< 180: a change from dark to light counts as one from light to dark does
  /// Larger images are reduced to this side: edges then mean the same in all sizes [pixels].
  int longestSide = 640;
};

/// Σ 4^v · bins numbers (630): level by level, cells row by row. Only edges count (Canny's), each by the
/// magnitude of its gradient; the sum is 1, or 0 where there is no edge at all. `image` is BGR or gray, 8
/// bits, of any size. Throws Error on other images and on options out of range.
/// Bosch, Zisserman, Muñoz: Representing shape with a spatial pyramid kernel, CIVR 2007.
std::vector<float> phog(const cv::Mat& image, const PhogOptions& options = {});

/// phog() of the view's image.
class Phog final : public Descriptor {
 public:
  explicit Phog(const PhogOptions& options = {});
  std::vector<DescriptorPart> parts() const override;
  std::vector<float> describe(const View& view) const override { return phog(view.image, options_); }

 private:
  PhogOptions options_;
};

}  // namespace estancia
