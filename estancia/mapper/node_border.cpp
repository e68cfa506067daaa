// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_border.hpp"

#include <algorithm>
#include <utility>

namespace estancia {

void NodeBorder::add(Image image, std::uint64_t before, std::size_t k,
                     const std::function<void(const Image&, double)>& change) {
  const auto share = [k](std::size_t i) { return static_cast<double>(i) / static_cast<double>(k); };
  const std::size_t whole = std::max<std::size_t>(2 * k, 3);  // one image at least weighs 1
  const bool hasEnds = images.size() != before;
  if (hasEnds)
    for (const Image& each : images) change(each, share(1));
  else if (before + 1 < whole)
    change(image, 1);
  images.push_back(std::move(image));
  if (!hasEnds && images.size() == whole) {
    for (std::size_t i = 0; i < k; ++i) change(images[i], share(i) - 1);
    for (std::size_t i = 1; i < k; ++i) change(images[whole - 1 - i], share(i) - 1);
  } else if (!hasEnds) {
    return;
  }
  const auto surplus = static_cast<std::ptrdiff_t>(images.size() - std::min(images.size(), k));
  images.erase(images.begin(), images.begin() + surplus);
}

}  // namespace estancia
