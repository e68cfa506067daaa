#include "estancia/recognition/nearest_field.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

using Triple = std::array<std::int32_t, 3>;

}  // namespace

NearestField::NearestField(std::span<const cv::Point3f> points, double cell, double reach, int threads)
    : inverse_(static_cast<float>(1 / cell)) {
  const auto far = static_cast<float>(reach / cell);
  // Which blocks each point has a say in.
  std::vector<std::pair<Triple, std::uint32_t>> says;
  std::vector<cv::Point3f> scaled(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const cv::Point3f p = scaled[i] = points[i] * inverse_;
    if (!(std::abs(p.x) + far < furthest && std::abs(p.y) + far < furthest && std::abs(p.z) + far < furthest))
      continue;
    const auto block = [](float v) { return static_cast<std::int32_t>(std::floor(v)) >> bits; };
    for (std::int32_t x = block(p.x - far); x <= block(p.x + far); ++x)
      for (std::int32_t y = block(p.y - far); y <= block(p.y + far); ++y)
        for (std::int32_t z = block(p.z - far); z <= block(p.z + far); ++z) says.push_back({{x, y, z}, i});
  }
  std::sort(says.begin(), says.end());
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < says.size(); ++i)
    if (i == 0 || says[i].first != says[i - 1].first) starts.push_back(i);
  slots_.resize(std::bit_ceil(2 * starts.size() + 2));
  for (std::size_t b = 0; b < starts.size(); ++b) {
    std::size_t s = slotOf(says[starts[b]].first);
    while (slots_[s].number != none) s = (s + 1) & (slots_.size() - 1);
    slots_[s] = {says[starts[b]].first, static_cast<std::int32_t>(b)};
  }
  constexpr std::size_t side = 1U << bits, size = side * side * side;
  cells_.assign(starts.size() * size, none);
  constexpr std::size_t together = 32;
  Progress silent;
  inParallel((starts.size() + together - 1) / together, threads, silent, "stopped while a surface was spread",
             [&](std::size_t chunk) {
               std::vector<float> best(size);
               for (std::size_t b = chunk * together; b < std::min(starts.size(), (chunk + 1) * together);
                    ++b) {
                 std::ranges::fill(best, far * far);
                 const Triple& block = says[starts[b]].first;
                 std::int32_t* cells = cells_.data() + b * size;
                 const std::size_t end = b + 1 < starts.size() ? starts[b + 1] : says.size();
                 for (std::size_t n = starts[b]; n < end; ++n) {
                   const std::uint32_t i = says[n].second;
                   // The place in the block's cells, whose middles are at 0, 1, …
                   const float px = scaled[i].x - static_cast<float>(block[0] * 8) - 0.5F;
                   const float py = scaled[i].y - static_cast<float>(block[1] * 8) - 0.5F;
                   const float pz = scaled[i].z - static_cast<float>(block[2] * 8) - 0.5F;
                   for (std::size_t x = 0; x < side; ++x) {
                     const float dx = static_cast<float>(x) - px;
                     if (std::abs(dx) > far) continue;
                     for (std::size_t y = 0; y < side; ++y) {
                       const float dy = static_cast<float>(y) - py, across = dx * dx + dy * dy;
                       if (across > far * far) continue;
                       for (std::size_t z = 0; z < side; ++z) {
                         const std::size_t c = (x * side + y) * side + z;
                         const float dz = static_cast<float>(z) - pz, squared = across + dz * dz;
                         if (squared < best[c]) best[c] = squared, cells[c] = static_cast<std::int32_t>(i);
                       }
                     }
                   }
                 }
               }
             });
}

}  // namespace estancia
