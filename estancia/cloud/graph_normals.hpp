// Normals of a neural gas, out of its graph.
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/cloud/growing_neural_gas.hpp"

namespace estancia {

/// A unit normal for every neuron: that of the plane (principal components) through the neuron, its
/// neighbors and theirs, turned to `viewpoint`. No radius is needed, since the graph joins what lies on one
/// surface. (NaN, NaN, NaN) where these points do not span a plane. O(neurons). Throws Error when an edge
/// names a neuron that is not there.
std::vector<cv::Point3f> normalsFromGraph(const NeuralGas& gas, const cv::Point3f& viewpoint = {0, 0, 0});

}  // namespace estancia
