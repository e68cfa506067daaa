// Word map: where on the floor the things are that words name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// A value for each cell of the floor.
struct FloorHeat {
  FloorCells cells;
  /// CV_32F, rows × columns of `cells`; 0 where nothing was seen.
  cv::Mat values;
};

/// A word is evidence for what its image shows, not for where the camera stood: each descriptor is pooled
/// into the cells of the floor above which its pixels lie, weighted by their share of the image. What several
/// images from different sides have in common stands where they cross.
///
/// Bounded: a cell keeps its most frequent words; the others count as not seen. Words no more probable than
/// by chance (1/L) are left out. O(cells in view · words) an image.
class WordMap {
 public:
  /// `labels`: the number of labels of a descriptor.
  WordMap(const Floor& floor, std::size_t labels);

  /// Adds an image with depth (along the optical axis [m], CV_32F, 0: unknown), its camera and where it
  /// stood. Throws Error: mismatch unless there is one probability a label; tooLarge for too many cells.
  void add(DescriptorView descriptor, const cv::Mat& depth, const CameraIntrinsics& camera, const Pose& pose);
  /// Adds an image without depth: its words belong to the field of view [rad, horizontal] up to a few meters.
  void add(DescriptorView descriptor, double fieldOfView, const Pose& pose);

  const Floor& floor() const { return floor_; }
  const FloorCells& cells() const { return cells_; }

  /// How surely one of `labels` is in each cell: their mean probability in the images that saw the cell, less
  /// its standard error, smoothed over neighboring cells. Throws Error (invalidInput) for unknown labels.
  FloorHeat heat(std::span<const std::size_t> labels) const;

  /// The mean probability of each label over the cells that are not 0 in `mask` (CV_8U, rows × columns of
  /// cells()), weighted by how much was seen of them; all 0 where nothing was.
  std::vector<float> mean(const cv::Mat& mask) const;

 private:
  struct Word {
    std::uint32_t label = 0;
    float sum = 0, squares = 0;  // Σ w p, Σ w p²
  };
  struct Cell {
    double weight = 0, squaredWeight = 0;  // Σ w, Σ w²
    std::vector<Word> words;               // by label
  };
  using Shares = std::unordered_map<std::uint64_t, double>;

  void pool(DescriptorView descriptor, const Shares& shares);
  void keepBest(Cell& cell) const;
  cv::Point cellOf(std::uint64_t key) const;

  Floor floor_;
  std::size_t labels_;
  FloorCells cells_;
  std::unordered_map<std::uint64_t, Cell> seen_;  // by the cell's place on the floor
};

}  // namespace estancia
