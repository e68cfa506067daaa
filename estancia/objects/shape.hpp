// Shape descriptor of objects: ESF and, optionally, metric size.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/readers/object_views.hpp"

namespace estancia {

/// Throws Error as esf().
std::vector<float> describeShape(const PointCloud& cloud, const ShapeOptions& options);

/// Features without frames: the parts ESF and, if chosen, size (three standard deviations, radius) [m].
Features noShapes(const ShapeOptions& options);

/// The shapes of all views: a frame each, of the same name; `room` is the category. Views that cannot be
/// described are left out, for `problems`. Throws Error (insufficientData) when none is left; Interrupted.
Features describeShapes(const ObjectViews& views, const ShapeOptions& options,
                        Progress& progress = Progress::none(), std::vector<std::string>* problems = nullptr);

}  // namespace estancia
