// Reference room segmentation: methods by which others split a floor plan, to compare areas with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::experiments {

/// Splits free space into rooms: 1, 2 … (CV_32S), 0 where nothing is free. `distance`: to the nearest wall
/// [m], CV_32F, 0 where nothing is free. `cell`: the width of a cell [m].
using RoomMethod = cv::Mat (*)(const cv::Mat& distance, double cell);

/// Morphological segmentation (Bormann et al. 2016, "Room segmentation: survey, implementation, and
/// analysis", III-A): free space is eroded step by step; what falls off with the size of a room is one, and
/// rooms grow back over free space. Rooms of 0.8 to 25 m²: the authors' 47 m² is a whole flat.
cv::Mat morphologicalRooms(const cv::Mat& distance, double cell);

/// Distance transform segmentation (ibid., III-B): the threshold of the distance that leaves the most parts.
/// Parts of 0.1 m² or more: the authors' 0.35 m² is more than is left of a furnished bathroom.
cv::Mat distanceTransformRooms(const cv::Mat& distance, double cell);

/// The room that each labeled frame's camera stood in, by a method on the floor plan that depth and poses
/// show (OccupancyGrid), as findAreas() has it. Frames without a pose are where the last one was. Throws
/// Error (insufficientData) without a camera or a pose.
std::vector<int> referenceAreas(const Sequence& sequence, const DescriptorSequence& labeled,
                                RoomMethod method);

}  // namespace estancia::experiments
