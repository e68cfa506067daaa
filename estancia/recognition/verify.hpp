// Is the model really there (thesis 2.4.7)?
#pragma once

#include <opencv2/core/affine.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/refine.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// What a scene says about a model in a pose, in numbers of the model's points.
struct Evidence {
  std::size_t points = 0;       ///< all of the model's
  std::size_t facing = 0;       ///< turned to the sensor: what could be seen
  std::size_t inliers = 0;      ///< of these, with a scene point near that is turned the same way
  std::size_t occluded = 0;     ///< of these, behind something, or where the sensor saw nothing
  std::size_t seenThrough = 0;  ///< of these, in front of what the sensor saw: there can be nothing

  /// The share of what should be seen (facing − occluded) that is, times the root of the share of all that
  /// faces the sensor: what little of a hidden model agrees may be chance. In [0, 1].
  double confidence() const;
};

/// Of the nearest points themselves, as isThere() counts them; scorePose() asks the scene more quickly.
Evidence examine(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                 const cv::Affine3d& pose, double tolerance);

/// The plain check: the confidence is at least `accept`, the scene does not look through a fifth of the
/// model, and not much more than half of the model is turned away, as no sensor would have seen it.
bool isThere(const Evidence& evidence, double accept);

/// Global hypothesis verification (Aldoma, Tombari, Di Stefano, Vincze 2012): the set of hypotheses that
/// together explains most of the scene with the fewest model points in the void, scene points explained
/// twice, and points left unexplained on a smooth part of the scene that is partly explained; by simulated
/// annealing. `smoothParts` is smoothPartsOf(scene). Points of model and scene should lie equally far apart.
/// `tolerance` [m] is that between a scene point and the model point that explains it. Returns whether each
/// pose belongs to it.
std::vector<bool> verifyGlobally(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                                 std::span<const int> smoothParts, std::span<const cv::Affine3d> poses,
                                 double tolerance);

/// Parts of a surface over which the normal changes slowly: for each point the number of its part, 0 for
/// those of small parts. Points of a part are linked by neighbors within `reach` [m] whose normals differ by
/// < 0.2 rad.
std::vector<int> smoothPartsOf(const Surface& surface, double reach, int threads = 1);

}  // namespace estancia
