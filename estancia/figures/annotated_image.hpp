// Annotated image: an image with the objects that were found in it, and a floor plan with its names, in
// pixels. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/areas/areas.hpp"
#include "estancia/objects/predict.hpp"

namespace estancia::report {

/// The image (BGR) with a box around each object, its number, and what it is believed to be: green where
/// image and shape agree, blue by the shape, orange by the image, gray where neither is believed. Throws
/// Error on an image that is none, and on a word without a name.
cv::Mat drawObjects(const cv::Mat& image, std::span<const PredictedObject> objects,
                    const std::vector<std::string>& words);

/// The areas tinted and named, walls dark, the path dotted; the floor's first axis to the right, the second
/// up. Where `heat` is given, cells glow by it instead. BGR, 8 bits, about `width` pixels wide.
cv::Mat drawFloorPlan(const Areas& areas, const FloorHeat* heat = nullptr, int width = 1000);

}  // namespace estancia::report
