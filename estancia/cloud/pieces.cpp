#include "estancia/cloud/pieces.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

constexpr double kLeastCrease = 25, kLeastSeed = 60;  // [square pixels]
constexpr double kOpening = 2.5;                      // how far seeds stay away from creases [pixels]
constexpr double kCreased = 0.45;                     // share of creases in a border that parts its pieces
constexpr int kRounds = 3;                            // of joining neighbours

void dropSmallBlobs(const InverseDepth& grid, std::vector<std::uint8_t>& mask) {
  cv::Mat labels, statistics, centroids, picture = asPicture(grid, mask);
  const int blobs = cv::connectedComponentsWithStats(picture, labels, statistics, centroids, 8, CV_32S);
  std::vector<std::uint8_t> stays(static_cast<std::size_t>(blobs));
  for (int i = 1; i < blobs; ++i)
    stays[static_cast<std::size_t>(i)] = statistics.at<int>(i, cv::CC_STAT_AREA) >= grid.area(kLeastCrease);
  const auto* label = labels.ptr<int>();
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = stays[static_cast<std::size_t>(label[i])];
}

/// Everything within a circle around what is marked.
std::vector<std::uint8_t> widened(const InverseDepth& grid, std::vector<std::uint8_t>& mask, double radius) {
  const int r = static_cast<int>(radius * grid.scale);
  cv::Mat circle(2 * r + 1, 2 * r + 1, CV_8U);
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x)
      circle.at<std::uint8_t>(y + r, x + r) = std::hypot(x, y) <= radius * grid.scale;
  std::vector<std::uint8_t> wide(mask.size());
  cv::dilate(asPicture(grid, mask), asPicture(grid, wide), circle);
  return wide;
}

/// Numbers the connected surfaces of what `wanted(pixel)` says, from labels' highest number on, in the order
/// of their first pixels. Those of less than `least` pixels stay 0.
template <class Wanted>
void labelSurfaces(const InverseDepth& grid, const Wanted& wanted, double least, Pieces& pieces) {
  DisjointSets sets(1);
  std::vector<std::uint32_t> provisional(grid.size());
  const auto stride = static_cast<std::size_t>(grid.stride);
  for (int v = 0; v < grid.camera.height; ++v) {
    const std::size_t end = grid.at(grid.camera.width, v);
    for (std::size_t i = grid.at(0, v); i < end; ++i) {
      if (!wanted(i)) continue;
      const float w = grid.raw[i];
      const std::uint32_t left = isContinuous(w, grid.raw[i - 1]) ? provisional[i - 1] : 0;
      const std::uint32_t above = isContinuous(w, grid.raw[i - stride]) ? provisional[i - stride] : 0;
      if (left != 0 && above != 0 && left != above) sets.join(left, above);
      provisional[i] = left != 0 ? left : above != 0 ? above : sets.add();
    }
  }
  std::vector<std::uint32_t> sizes(sets.size()), number(sets.size());
  for (std::uint32_t& label : provisional)
    if (label != 0) ++sizes[label = sets.find(label)];
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    if (sizes[i] == 0 || sizes[i] < least) continue;
    number[i] = static_cast<std::uint32_t>(pieces.sizes.size());
    pieces.sizes.push_back(sizes[i]);
  }
  for (std::size_t i = 0; i < provisional.size(); ++i)
    if (provisional[i] != 0 && number[provisional[i]] != 0) pieces.labels[i] = number[provisional[i]];
}

/// Pieces take the pixels around them, all at the same pace, never over an edge in depth.
void grow(const InverseDepth& grid, const std::vector<std::uint8_t>& mask, Pieces& pieces) {
  const std::ptrdiff_t around[] = {1, -1, grid.stride, -grid.stride};
  std::vector<std::uint32_t> front, next;
  const auto spread = [&](std::size_t i) {
    for (const std::ptrdiff_t step : around) {
      const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step);
      if (mask[j] == 0 || pieces.labels[j] != 0 || !isContinuous(grid.raw[i], grid.raw[j])) continue;
      pieces.labels[j] = pieces.labels[i];
      ++pieces.sizes[pieces.labels[i]];
      next.push_back(static_cast<std::uint32_t>(j));
    }
  };
  for (int v = 0; v < grid.camera.height; ++v) {
    const std::size_t end = grid.at(grid.camera.width, v);
    for (std::size_t i = grid.at(0, v); i < end; ++i) {
      if (pieces.labels[i] == 0) continue;
      for (const std::ptrdiff_t step : around) {
        const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step);
        if (mask[j] == 0 || pieces.labels[j] != 0) continue;
        front.push_back(static_cast<std::uint32_t>(i));
        break;
      }
    }
  }
  while (!front.empty()) {
    next.clear();
    for (const std::uint32_t i : front) spread(i);
    front.swap(next);
  }
}

std::vector<Border> bordersOf(const InverseDepth& grid, const Pieces& pieces,
                              const std::vector<std::uint8_t>& creases) {
  std::vector<std::uint64_t> pairs;
  const auto look = [&](std::size_t i, std::size_t j) {
    const std::uint32_t a = pieces.labels[i], b = pieces.labels[j];
    if (b == 0 || a == b || !isContinuous(grid.raw[i], grid.raw[j])) return;
    pairs.push_back(pairOf(a, b, (creases[i] | creases[j]) != 0));
  };
  for (int v = 0; v < grid.camera.height; ++v) {
    const std::size_t end = grid.at(grid.camera.width, v);
    for (std::size_t i = grid.at(0, v); i < end; ++i) {
      if (pieces.labels[i] == 0) continue;
      look(i, i + 1);
      look(i, i + static_cast<std::size_t>(grid.stride));
    }
  }
  return estancia::bordersOf(std::move(pairs));
}

/// The same once the pieces of each set are one.
std::vector<Border> joined(std::vector<Border> borders, DisjointSets& sets) {
  for (Border& border : borders) {
    border.a = sets.find(border.a);
    border.b = sets.find(border.b);
    if (border.a > border.b) std::swap(border.a, border.b);
  }
  std::ranges::sort(borders, {}, [](const Border& b) { return std::pair(b.a, b.b); });
  std::vector<Border> merged;
  for (const Border& border : borders) {
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

void joinSmooth(std::vector<Border>& borders, DisjointSets& sets) {
  for (int round = 0; round < kRounds; ++round) {
    bool changed = false;
    for (const Border& border : borders) {
      if (border.pairs < kLeastBorder ||
          static_cast<double>(border.creased) >= kCreased * static_cast<double>(border.pairs))
        continue;
      sets.join(border.a, border.b);
      changed = true;
    }
    if (!changed) return;
    borders = joined(std::move(borders), sets);
  }
}

void joinSmall(std::vector<Border>& borders, DisjointSets& sets, const std::vector<std::uint32_t>& sizes,
               double least) {
  struct Closest {
    std::size_t pairs = 0;
    std::uint32_t piece = 0;
  };
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::uint32_t> whole(sizes.size());
    for (std::uint32_t i = 0; i < sizes.size(); ++i) whole[sets.find(i)] += sizes[i];
    std::vector<Closest> closest(sizes.size());
    const auto offer = [&](std::uint32_t small, std::uint32_t other, std::size_t pairs) {
      if (whole[small] < least && pairs > closest[small].pairs) closest[small] = {pairs, other};
    };
    for (const Border& border : borders) {
      offer(border.a, border.b, border.pairs);
      offer(border.b, border.a, border.pairs);
    }
    bool changed = false;
    for (std::uint32_t i = 1; i < sizes.size(); ++i) {
      if (closest[i].pairs == 0) continue;
      sets.join(i, closest[i].piece);
      changed = true;
    }
    if (!changed) return;
    borders = joined(std::move(borders), sets);
  }
}

}  // namespace

std::vector<Border> bordersOf(std::vector<std::uint64_t> pairs) {
  std::ranges::sort(pairs);
  std::vector<Border> borders;
  for (const std::uint64_t pair : pairs) {
    const auto a = static_cast<std::uint32_t>(pair >> 32),
               b = static_cast<std::uint32_t>(pair & 0xFFFFFFFFU) >> 1;
    if (borders.empty() || borders.back().a != a || borders.back().b != b) borders.push_back({a, b});
    ++borders.back().pairs;
    borders.back().creased += pair & 1;
  }
  return borders;
}

void joinNeighbours(std::vector<Border>& borders, DisjointSets& sets, const std::vector<std::uint32_t>& sizes,
                    double least) {
  joinSmooth(borders, sets);
  joinSmall(borders, sets, sizes, least);
}

void renumber(Pieces& pieces, DisjointSets& sets) {
  std::vector<std::uint32_t> number(pieces.sizes.size()), sizes(1);
  for (std::uint32_t i = 1; i < number.size(); ++i) {
    const std::uint32_t set = sets.find(i);
    if (set == i) {  // the lowest of its set, so seen before the others
      number[i] = static_cast<std::uint32_t>(sizes.size());
      sizes.push_back(0);
    }
    number[i] = number[set];
    sizes[number[i]] += pieces.sizes[i];
  }
  for (std::uint32_t& label : pieces.labels) label = number[label];
  pieces.sizes = std::move(sizes);
  for (auto& [a, b] : pieces.touching) {
    a = number[a];
    b = number[b];
    if (a > b) std::swap(a, b);
  }
  std::ranges::sort(pieces.touching);
  const auto same = std::ranges::unique(pieces.touching);
  pieces.touching.erase(same.begin(), same.end());
  std::erase_if(pieces.touching, [](const auto& pair) { return pair.first == pair.second; });
}

Pieces cutPieces(const InverseDepth& grid, std::vector<std::uint8_t>& mask,
                 std::vector<std::uint8_t> creases) {
  dropSmallBlobs(grid, creases);
  const std::vector<std::uint8_t> nearCrease = widened(grid, creases, kOpening);
  Pieces pieces;
  pieces.labels.resize(grid.size());
  pieces.sizes.resize(1);
  labelSurfaces(
      grid, [&](std::size_t i) { return mask[i] > nearCrease[i]; }, grid.area(kLeastSeed), pieces);
  grow(grid, mask, pieces);
  labelSurfaces(
      grid, [&](std::size_t i) { return mask[i] != 0 && pieces.labels[i] == 0; }, 1, pieces);
  std::vector<Border> borders = bordersOf(grid, pieces, creases);
  DisjointSets sets(pieces.sizes.size());
  joinNeighbours(borders, sets, pieces.sizes, grid.area(kLeastPiece));
  for (const Border& border : borders)
    if (border.pairs >= kLeastBorder) pieces.touching.emplace_back(border.a, border.b);
  renumber(pieces, sets);
  return pieces;
}

}  // namespace estancia
