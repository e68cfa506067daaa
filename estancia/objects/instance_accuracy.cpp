// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_accuracy.hpp"

#include <algorithm>

namespace estancia {

std::vector<BoxMatch> matchBoxes(std::span<const OrientedBox> found, std::span<const OrientedBox> things,
                                 double least) {
  std::vector<BoxMatch> pairs;
  for (std::size_t f = 0; f < found.size(); ++f)
    for (std::size_t t = 0; t < things.size(); ++t)
      if (const double overlap = intersectionOverUnion(found[f], things[t]); overlap >= least)
        pairs.push_back({f, t, overlap});
  std::ranges::stable_sort(pairs, std::ranges::greater{}, &BoxMatch::overlap);
  std::vector<bool> used(found.size()), matched(things.size());
  std::vector<BoxMatch> matches;
  for (const BoxMatch& pair : pairs) {
    if (used[pair.found] || matched[pair.thing]) continue;
    used[pair.found] = matched[pair.thing] = true;
    matches.push_back(pair);
  }
  return matches;
}

}  // namespace estancia
