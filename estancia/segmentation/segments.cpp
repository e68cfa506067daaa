// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segments.hpp"

#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

constexpr double minCreaseArea = 25, minSeedArea = 60;  // [square pixels]
constexpr double opening = 2.5;                         // distance of seeds from creases [pixels]
constexpr double minCreasedShare = 0.45;  // share of creases in a border that separates its segments
constexpr int rounds = 3;                 // rounds of merging neighbors

/// The rows of an image of bytes over the mask's, as OpenCV sees them; shares the memory.
cv::Mat rowsOf(const InverseDepth& grid, const Mask& mask, std::vector<std::uint8_t>& image) {
  const auto isEmpty = [](const Mask::Span& row) { return row.first == row.last; };
  const auto top = std::ranges::find_if_not(mask.rows, isEmpty) - mask.rows.begin();
  auto bottom = std::ssize(mask.rows);
  while (bottom > top && isEmpty(mask.rows[static_cast<std::size_t>(bottom - 1)])) --bottom;
  return {static_cast<int>(bottom - top), static_cast<int>(grid.stride), CV_8U,
          &image[grid.at(-grid.margin, static_cast<int>(top))]};
}

/// Clears small blobs of marked pixels; sets the remaining marks to 2.
void dropSmallBlobs(const InverseDepth& grid, const Mask& mask, std::vector<std::uint8_t>& marked) {
  const std::ptrdiff_t s = grid.stride, around[] = {1, -1, s, -s, s + 1, s - 1, -s - 1, -s + 1};
  std::vector<std::uint32_t> blob;
  mask.eachPixel([&](std::size_t first) {
    if (marked[first] != 1) return;
    blob.assign(1, static_cast<std::uint32_t>(first));
    marked[first] = 2;
    for (std::size_t k = 0; k < blob.size(); ++k)
      for (const std::ptrdiff_t step : around) {
        const auto i = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(blob[k]) + step);
        if (marked[i] != 1) continue;
        marked[i] = 2;
        blob.push_back(static_cast<std::uint32_t>(i));
      }
    if (static_cast<double>(blob.size()) < grid.area(minCreaseArea))
      for (const std::uint32_t i : blob) marked[i] = 0;
  });
}

/// Dilates the marked pixels by a disc.
void widen(const InverseDepth& grid, const cv::Mat& mask, double radius, cv::Mat wide) {
  const int r = static_cast<int>(radius * grid.scale);
  cv::Mat circle(2 * r + 1, 2 * r + 1, CV_8U);
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x)
      circle.at<std::uint8_t>(y + r, x + r) = std::hypot(x, y) <= radius * grid.scale;
  cv::dilate(mask, wide, circle);
}

/// Connected components: labels the connected surfaces of those pixels of the mask that have no label and are
/// `wanted`, from segments.sizes.size() on, in the order of their first pixels. Components of less than
/// `minPixels` stay 0.
template <class Wanted>
void labelSurfaces(const InverseDepth& grid, const Mask& mask, const Wanted& wanted, double minPixels,
                   Segmentation& segments) {
  const auto base =
      static_cast<std::uint32_t>(segments.sizes.size());  // labels from here on are sets' for now
  DisjointSets sets(0);
  std::vector<std::uint32_t>& labels = segments.labels;
  const auto setOf = [&](float w, std::size_t neighbor) {
    return labels[neighbor] >= base && isContinuous(w, grid.raw[neighbor]) ? labels[neighbor] : 0;
  };
  mask.eachPixel([&](std::size_t i) {
    if (labels[i] != 0 || !wanted(i)) return;
    const float w = grid.raw[i];
    const std::uint32_t left = setOf(w, i - 1), above = setOf(w, i - static_cast<std::size_t>(grid.stride));
    if (left != 0 && above != 0 && left != above) sets.join(left - base, above - base);
    labels[i] = left != 0 ? left : above != 0 ? above : base + sets.add();
  });
  std::vector<std::uint32_t> sizes(sets.size()), number(sets.size());
  mask.eachPixel([&](std::size_t i) {
    if (labels[i] < base) return;
    labels[i] = base + sets.find(labels[i] - base);
    ++sizes[labels[i] - base];
  });
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] == 0 || sizes[i] < minPixels) continue;
    number[i] = static_cast<std::uint32_t>(segments.sizes.size());
    segments.sizes.push_back(sizes[i]);
  }
  mask.eachPixel([&](std::size_t i) {
    if (labels[i] >= base) labels[i] = number[labels[i] - base];
  });
}

/// Region growing: all segments take the pixels around them at the same pace, never across a depth edge.
void grow(const InverseDepth& grid, const Mask& mask, Segmentation& segments) {
  const std::ptrdiff_t around[] = {1, -1, grid.stride, -grid.stride};
  std::vector<std::uint32_t> front, next;
  const auto isFree = [&](std::size_t j) { return mask.in[j] != 0 && segments.labels[j] == 0; };
  mask.eachPixel([&](std::size_t i) {
    if (segments.labels[i] != 0 && std::ranges::any_of(around, [&](std::ptrdiff_t step) {
          return isFree(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step));
        }))
      front.push_back(static_cast<std::uint32_t>(i));
  });
  for (; !front.empty(); front.swap(next)) {
    next.clear();
    for (const std::uint32_t i : front)
      for (const std::ptrdiff_t step : around) {
        const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step);
        if (!isFree(j) || !isContinuous(grid.raw[i], grid.raw[j])) continue;
        segments.labels[j] = segments.labels[i];
        ++segments.sizes[segments.labels[i]];
        next.push_back(static_cast<std::uint32_t>(j));
      }
  }
}

std::vector<SegmentBorder> pixelBorders(const InverseDepth& grid, const Mask& mask,
                                        const Segmentation& segments,
                                        const std::vector<std::uint8_t>& creases) {
  std::vector<std::uint64_t> pairs;
  const auto look = [&](std::size_t i, std::size_t j) {
    const std::uint32_t a = segments.labels[i], b = segments.labels[j];
    if (b == 0 || a == b || !isContinuous(grid.raw[i], grid.raw[j])) return;
    pairs.push_back(pairOf(a, b, (creases[i] | creases[j]) != 0));
  };
  mask.eachPixel([&](std::size_t i) {
    look(i, i + 1);
    look(i, i + static_cast<std::size_t>(grid.stride));
  });
  return bordersOf(std::move(pairs));
}

/// The borders between the sets.
std::vector<SegmentBorder> mergedBorders(std::vector<SegmentBorder> borders, DisjointSets& sets) {
  for (SegmentBorder& border : borders) {
    border.a = sets.find(border.a);
    border.b = sets.find(border.b);
    if (border.a > border.b) std::swap(border.a, border.b);
  }
  std::ranges::sort(borders, {}, [](const SegmentBorder& b) { return std::pair(b.a, b.b); });
  std::vector<SegmentBorder> merged;
  for (const SegmentBorder& border : borders) {
    if (border.a == border.b) continue;
    if (merged.empty() || merged.back().a != border.a || merged.back().b != border.b) {
      merged.push_back(border);
    } else {
      merged.back().pairs += border.pairs;
      merged.back().creased += border.creased;
    }
  }
  return merged;
}

void mergeSmooth(std::vector<SegmentBorder>& borders, DisjointSets& sets) {
  for (int round = 0; round < rounds; ++round) {
    bool changed = false;
    for (const SegmentBorder& border : borders) {
      if (border.pairs < minBorderPairs ||
          static_cast<double>(border.creased) >= minCreasedShare * static_cast<double>(border.pairs))
        continue;
      sets.join(border.a, border.b);
      changed = true;
    }
    if (!changed) return;
    borders = mergedBorders(std::move(borders), sets);
  }
}

void mergeSmall(std::vector<SegmentBorder>& borders, DisjointSets& sets,
                const std::vector<std::uint32_t>& sizes, double minSize) {
  struct Closest {
    std::size_t pairs = 0;
    std::uint32_t segment = 0;
  };
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint32_t> whole(sizes.size());
    for (std::uint32_t i = 0; i < sizes.size(); ++i) whole[sets.find(i)] += sizes[i];
    std::vector<Closest> closest(sizes.size());
    const auto offer = [&](std::uint32_t small, std::uint32_t other, std::size_t pairs) {
      if (whole[small] < minSize && pairs > closest[small].pairs) closest[small] = {pairs, other};
    };
    for (const SegmentBorder& border : borders) {
      offer(border.a, border.b, border.pairs);
      offer(border.b, border.a, border.pairs);
    }
    bool changed = false;
    for (std::uint32_t i = 1; i < sizes.size(); ++i) {
      if (closest[i].pairs == 0) continue;
      sets.join(i, closest[i].segment);
      changed = true;
    }
    if (!changed) return;
    borders = mergedBorders(std::move(borders), sets);
  }
}

}  // namespace

std::vector<SegmentBorder> bordersOf(std::vector<std::uint64_t> pairs) {
  std::ranges::sort(pairs);
  std::vector<SegmentBorder> borders;
  for (const std::uint64_t pair : pairs) {
    const auto a = static_cast<std::uint32_t>(pair >> 32),
               b = static_cast<std::uint32_t>(pair & 0xFFFFFFFFU) >> 1;
    if (borders.empty() || borders.back().a != a || borders.back().b != b) borders.push_back({a, b});
    ++borders.back().pairs;
    borders.back().creased += pair & 1;
  }
  return borders;
}

void mergeNeighbors(std::vector<SegmentBorder>& borders, DisjointSets& sets,
                    const std::vector<std::uint32_t>& sizes, double minSize) {
  mergeSmooth(borders, sets);
  mergeSmall(borders, sets, sizes, minSize);
}

void renumber(const Mask& mask, Segmentation& segments, DisjointSets& sets) {
  std::vector<std::uint32_t> number(segments.sizes.size()), sizes(1);
  for (std::uint32_t i = 1; i < number.size(); ++i) {
    const std::uint32_t set = sets.find(i);
    if (set == i) {  // the lowest of its set, so seen before the others
      number[i] = static_cast<std::uint32_t>(sizes.size());
      sizes.push_back(0);
    }
    number[i] = number[set];
    sizes[number[i]] += segments.sizes[i];
  }
  mask.eachPixel([&](std::size_t i) { segments.labels[i] = number[segments.labels[i]]; });
  segments.sizes = std::move(sizes);
  for (auto& [a, b] : segments.touching) {
    a = number[a];
    b = number[b];
    if (a > b) std::swap(a, b);
  }
  std::ranges::sort(segments.touching);
  segments.touching.erase(std::unique(segments.touching.begin(), segments.touching.end()),
                          segments.touching.end());
  std::erase_if(segments.touching, [](const auto& pair) { return pair.first == pair.second; });
}

Segmentation oversegment(const InverseDepth& grid, const Mask& mask, std::vector<std::uint8_t> creases) {
  Segmentation segments;
  segments.labels.resize(grid.size());
  segments.sizes.resize(1);
  std::vector<std::uint8_t> nearCrease(grid.size());
  const cv::Mat creased = rowsOf(grid, mask, creases);
  if (creased.empty()) return segments;
  dropSmallBlobs(grid, mask, creases);
  widen(grid, creased, opening, rowsOf(grid, mask, nearCrease));
  labelSurfaces(
      grid, mask, [&](std::size_t i) { return nearCrease[i] == 0; }, grid.area(minSeedArea), segments);
  grow(grid, mask, segments);
  labelSurfaces(
      grid, mask, [](std::size_t) { return true; }, 1, segments);
  std::vector<SegmentBorder> borders = pixelBorders(grid, mask, segments, creases);
  DisjointSets sets(segments.sizes.size());
  mergeNeighbors(borders, sets, segments.sizes, grid.area(minSegmentArea));
  for (const SegmentBorder& border : borders)
    if (border.pairs >= minBorderPairs) segments.touching.emplace_back(border.a, border.b);
  renumber(mask, segments, sets);
  return segments;
}

}  // namespace estancia
