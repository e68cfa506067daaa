// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/voxel_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estancia/core/simd.hpp"

namespace estancia::describe {
namespace {

constexpr int gridSide = VoxelGrid::gridSide;
constexpr int wordCount = gridSide * gridSide * gridSide / 32;
constexpr std::size_t lineLanes = 16;

/// Voxels reach up to whole numbers above 0 and from them below, as in PCL; rounding must not lead outside.
int indexOf(float coordinate) {
  const float floor = std::floor(coordinate), ceil = std::ceil(coordinate);
  return std::clamp(static_cast<int>(coordinate < 0 ? floor : ceil - 1) + gridSide / 2, 0, gridSide - 1);
}

/// Marks the neighbors of all that is marked; a row is 64 voxels along z.
void spread(std::vector<std::uint64_t>& rows) {
  for (std::uint64_t& row : rows) row |= row << 1 | row >> 1;
  const auto along = [&](std::size_t stride, std::size_t across) {
    for (std::size_t line = 0; line < gridSide; ++line) {
      std::uint64_t before = 0;
      for (std::size_t i = 0; i < gridSide; ++i) {
        std::uint64_t& row = rows[line * across + i * stride];
        const std::uint64_t own = row;
        row |= before | (i + 1 < gridSide ? rows[line * across + (i + 1) * stride] : 0);
        before = own;
      }
    }
  };
  along(1, gridSide);
  along(gridSide, 1);
}

using Lane = std::array<std::int32_t, lineLanes>;

/// Bresenham's lines in three dimensions, lineLanes at a time and without a branch: in every step the longest
/// axis advances, and the others where their error is above 0.
ESTANCIA_MULTIVERSION void traceLanes(const std::uint32_t* bits, VoxelGrid::Line* lines) {
  Lane voxel, voxels, marked{}, error2, error3, step1, step2, step3, twice1, twice2, twice3;
  int longest = 0;
  for (std::size_t l = 0; l < lineLanes; ++l) {
    const int from = lines[l].from, to = lines[l].to;
    const int dx = (to >> 12) - (from >> 12), dy = (to >> 6 & 63) - (from >> 6 & 63),
              dz = (to & 63) - (from & 63);
    int n1 = std::abs(dx), n2 = std::abs(dy), n3 = std::abs(dz);
    int s1 = dx < 0 ? -gridSide * gridSide : gridSide * gridSide, s2 = dy < 0 ? -gridSide : gridSide,
        s3 = dz < 0 ? -1 : 1;
    const bool swap2 = n2 > n1;  // the longest first
    const int n = swap2 ? n2 : n1, s = swap2 ? s2 : s1;
    n2 = swap2 ? n1 : n2;
    s2 = swap2 ? s1 : s2;
    const bool swap3 = n3 > n;
    n1 = swap3 ? n3 : n;
    s1 = swap3 ? s3 : s;
    n3 = swap3 ? n : n3;
    s3 = swap3 ? s : s3;
    voxel[l] = from;
    voxels[l] = std::max(n1, 1);
    error2[l] = 2 * n2 - n1;
    error3[l] = 2 * n3 - n1;
    step1[l] = s1;
    step2[l] = s2;
    step3[l] = s3;
    twice1[l] = 2 * n1;
    twice2[l] = 2 * n2;
    twice3[l] = 2 * n3;
    longest = std::max(longest, voxels[l]);
  }
  for (int i = 0; i < longest; ++i) {
#pragma omp simd
    for (std::size_t l = 0; l < lineLanes; ++l) {
      // Finished lines may leave the grid; they read any voxel, which is not counted.
      const std::uint32_t word = bits[voxel[l] >> 5 & (wordCount - 1)];
      marked[l] += static_cast<std::int32_t>(word >> (voxel[l] & 31) & 1U) & (i < voxels[l] ? 1 : 0);
      const std::int32_t over2 = error2[l] > 0 ? -1 : 0, over3 = error3[l] > 0 ? -1 : 0;
      voxel[l] += step1[l] + (over2 & step2[l]) + (over3 & step3[l]);
      error2[l] += twice2[l] - (over2 & twice1[l]);
      error3[l] += twice3[l] - (over3 & twice1[l]);
    }
  }
  for (std::size_t l = 0; l < lineLanes; ++l) {
    lines[l].voxels = voxels[l];
    lines[l].marked = marked[l];
  }
}

}  // namespace

VoxelGrid::VoxelGrid(std::span<const cv::Point3f> points) : bits_(wordCount) {
  std::vector<std::uint64_t> rows(static_cast<std::size_t>(gridSide) * gridSide);
  voxels_.reserve(points.size());
  for (const cv::Point3f& p : points) {
    const int row = indexOf(p.x) * gridSide + indexOf(p.y), z = indexOf(p.z);
    rows[static_cast<std::size_t>(row)] |= 1ULL << z;
    voxels_.push_back(row * gridSide + z);
  }
  spread(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    bits_[2 * i] = static_cast<std::uint32_t>(rows[i]);
    bits_[2 * i + 1] = static_cast<std::uint32_t>(rows[i] >> 32);
  }
}

void VoxelGrid::trace(std::span<Line> lines) const {
  std::size_t done = 0;
  for (; done + lineLanes <= lines.size(); done += lineLanes) traceLanes(bits_.data(), &lines[done]);
  if (done == lines.size()) return;
  std::array<Line, lineLanes> last{};  // the rest are lines of one voxel
  std::copy(lines.begin() + static_cast<std::ptrdiff_t>(done), lines.end(), last.begin());
  traceLanes(bits_.data(), last.data());
  std::copy_n(last.begin(), lines.size() - done, lines.begin() + static_cast<std::ptrdiff_t>(done));
}

}  // namespace estancia::describe
