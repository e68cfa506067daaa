// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr double minOwned = 0.1, mostlyOwnedShare = 0.5;  // share of its border that a thing stands before
constexpr double maxRaggedFill = 0.75;                    // share of its bounding box that a segment fills
constexpr double fewPixels = 1000;                        // [square pixels]
constexpr double wallEndWidth = 0.3;                      // with the frame of a door [m]
constexpr double minAlignment = 0.966;                    // cosine of 15°
constexpr double mostlyAligned = 0.7;                     // share of normals

/// Features that distinguish a thing from remains of structure.
struct Outline {
  double border = 0;                ///< sides of its pixels at other segments or none
  double owned = 0;                 ///< sides before what is farther, or on a level surface
  bool atFloor = false;             ///< touches a level surface
  double normals = 0, aligned = 0;  ///< pixels with a normal; those that face as the walls or across
  double depth = 0;                 ///< mean [m]
  cv::Rect box;
};

/// The directions of the walls: the normal of the largest one, and the level direction in it. Zeros where no
/// wall is seen.
struct WallDirections {
  cv::Vec3d across, along;
  WallDirections(const std::vector<Plane>& planes, const cv::Vec3d& up) {
    constexpr double upright = 0.14;  // sine of 8°
    double largest = 0;
    for (const Plane& plane : planes) {
      if (!plane.structural || std::abs(plane.normal.dot(up)) > upright || plane.area <= largest) continue;
      largest = plane.area;
      across = plane.normal;
      along = up.cross(across);
    }
  }
  bool fit(const cv::Vec3d& normal) const {
    return std::max(std::abs(normal.dot(across)), std::abs(normal.dot(along))) > minAlignment;
  }
};

/// Outline of each segment, in one pass over the image. Invariant: `outlines_` has one entry a segment, entry
/// 0 unused; image, planes and segments outlive it. Immutable after its constructor.
class Outlines {
 public:
  Outlines(const InverseDepth& grid, const PlaneRemoval& removal, const cv::Vec3d& up, const Mask& mask,
           const Segmentation& segments)
      : grid_(grid),
        removal_(removal),
        walls_(removal.planes, up),
        isLevel_(removal.planes.size() + 1),
        labels_(segments.labels),
        outlines_(segments.sizes.size()) {
    for (std::size_t k = 0; k < removal.planes.size(); ++k)
      isLevel_[k + 1] = removal.planes[k].normal.dot(up) > 0.5 ? 1 : 0;
    mask.eachPixel([&](std::size_t i) {
      if (labels_[i] != 0) addPixel(i);
    });
    for (std::size_t i = 1; i < outlines_.size(); ++i) outlines_[i].depth /= segments.sizes[i];
  }
  const Outline& operator[](std::size_t segment) const { return outlines_[segment]; }

 private:
  void addPixel(std::size_t i) {
    Outline& outline = outlines_[labels_[i]];
    const int u = grid_.column(i), v = grid_.row(i);
    outline.box |= cv::Rect(u, v, 1, 1);
    outline.depth += 1 / grid_.raw[i];
    if (const cv::Vec3d normal = removal_.half.normal(u, v); normal != cv::Vec3d()) {
      ++outline.normals;
      outline.aligned += walls_.fit(normal) ? 1 : 0;
    }
    if (u > 0) addSide(i, i - 1, outline);
    if (v > 0) addSide(i, i - static_cast<std::size_t>(grid_.stride), outline);
    if (u + 1 < grid_.camera.width) addSide(i, i + 1, outline);
    if (v + 1 < grid_.camera.height) addSide(i, i + static_cast<std::size_t>(grid_.stride), outline);
  }
  void addSide(std::size_t i, std::size_t j, Outline& outline) const {
    if (labels_[j] == labels_[i]) return;
    ++outline.border;
    const float step = grid_.raw[i] - grid_.raw[j];  // no depth: the shadow beside what is near
    const bool inFront = step >= depthStep * grid_.raw[j];
    const bool onLevel = labels_[j] == 0 && isLevel_[removal_.of[j]] != 0 && -step < depthStep * grid_.raw[i];
    outline.owned += inFront || onLevel ? 1 : 0;
    outline.atFloor |= onLevel && !inFront;
  }

  const InverseDepth& grid_;
  const PlaneRemoval& removal_;
  WallDirections walls_;
  std::vector<std::uint8_t> isLevel_;  // one value a plane, numbered from 1 on
  const std::vector<std::uint32_t>& labels_;
  std::vector<Outline> outlines_;
};

/// A column as narrow as a wall is thick, from the floor or the image's lower edge to its upper one, with the
/// walls' directions: the end of a wall, or the frame of a door.
bool isWallEnd(const InverseDepth& grid, const Outline& outline, double pixels) {
  const double rows = outline.box.height;
  const double width = pixels / rows * outline.depth / grid.camera.fx;
  const double height = rows * outline.depth / grid.camera.fy;
  return outline.box.y <= 1 && (outline.box.br().y >= grid.camera.height - 1 || outline.atFloor) &&
         width < wallEndWidth && height > 2 * width && outline.aligned > mostlyAligned * outline.normals;
}

/// A segment that stands before nothing is a relief of its surroundings; of a small ragged piece, most of the
/// border must be its own.
bool isFragment(const InverseDepth& grid, const Outline& outline, double pixels) {
  const bool ragged =
      pixels < grid.area(fewPixels) && pixels < maxRaggedFill * outline.box.width * outline.box.height;
  return outline.owned < (ragged ? mostlyOwnedShare : minOwned) * outline.border;
}

/// Takes the pixels from segments without size.
void clearDropped(const Mask& mask, Segmentation& segments) {
  mask.eachPixel([&](std::size_t i) {
    if (segments.sizes[segments.labels[i]] == 0) segments.labels[i] = 0;
  });
}

/// Mean width of a segment whose gaps narrower than `gap` are closed, as those between leaves [pixels]: no
/// more than the shorter side of its box, or 2.
double widthWithGaps(const InverseDepth& grid, const std::vector<std::uint32_t>& labels, const cv::Rect& box,
                     std::size_t segment, int gap) {
  cv::Mat closed(box.height + 2 * gap, box.width + 2 * gap, CV_8U, cv::Scalar(0)), inner;
  for (int v = 0; v < box.height; ++v)
    for (int u = 0; u < box.width; ++u)
      if (labels[grid.at(box.x + u, box.y + v)] == segment) closed.at<std::uint8_t>(v + gap, u + gap) = 1;
  cv::morphologyEx(closed, closed, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_ELLIPSE, {gap, gap}));
  cv::erode(closed, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  const int area = cv::countNonZero(closed);
  return 2. * area / std::max(1, area - cv::countNonZero(inner));
}

}  // namespace

void dropFragments(const InverseDepth& grid, const PlaneRemoval& removal, const cv::Vec3d& up,
                   const Mask& mask, Segmentation& segments) {
  const Outlines outlines(grid, removal, up, mask, segments);
  for (std::size_t i = 1; i < segments.sizes.size(); ++i)
    if (const double pixels = segments.sizes[i];
        isWallEnd(grid, outlines[i], pixels) || isFragment(grid, outlines[i], pixels))
      segments.sizes[i] = 0;
  clearDropped(mask, segments);
}

void dropNarrow(const InverseDepth& grid, const Mask& mask, Segmentation& segments) {
  constexpr double minWidth = 8;  // [pixels]
  const double narrowest = minWidth * grid.scale;
  const std::ptrdiff_t around[] = {1, -1, grid.stride, -grid.stride};
  const std::vector<std::uint32_t>& labels = segments.labels;
  std::vector<std::size_t> border(segments.sizes.size());
  std::vector<cv::Rect> boxes(segments.sizes.size());
  mask.eachPixel([&](std::size_t i) {
    border[labels[i]] += std::ranges::any_of(around, [&](std::ptrdiff_t step) {  // holes are no border
      const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step);
      return labels[j] != labels[i] && grid.raw[j] > 0;
    });
    boxes[labels[i]] |= cv::Rect(grid.column(i), grid.row(i), 1, 1);
  });
  // Settles noise, a million segments of a pixel each, without an image for every one of them.
  const auto shortSide = [](const cv::Rect& box) { return std::max(2, std::min(box.width, box.height)); };
  for (std::size_t i = 1; i < border.size(); ++i)
    if (2. * segments.sizes[i] < narrowest * static_cast<double>(border[i]) &&
        (shortSide(boxes[i]) < narrowest ||
         widthWithGaps(grid, labels, boxes[i], i, grid.pixels(minWidth)) < narrowest))
      segments.sizes[i] = 0;
  clearDropped(mask, segments);
}

}  // namespace estancia
