// The shape of things as numbers.
#pragma once

#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/io/object_views.hpp"

namespace estancia {

struct ShapeOptions {
  int samples = 5000;  ///< of the ensemble of shape functions (esf.hpp)
  bool size = false;   ///< also how large the thing is: three spreads and the radius [m]
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one a usable core; the numbers do not depend on it
};

/// ESF and, if asked for, size: what describeShape() gives.
std::vector<DescriptorPart> shapeParts(const ShapeOptions& options);

/// Throws Error as esf() does.
std::vector<float> describeShape(const PointCloud& cloud, const ShapeOptions& options);

/// Of all views, a frame each, called as it is; its `room` is the view's category. Views that cannot be
/// described are left out and told in `problems`. Throws Error when none is left, Interrupted.
Features sampleSegments(const ObjectViews& views, const ShapeOptions& options, Progress& progress,
                        std::vector<std::string>* problems = nullptr);

}  // namespace estancia
