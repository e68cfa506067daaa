// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/instance_views.hpp"

#include <algorithm>
#include <map>

namespace estancia {

double viewQuality(const Observation::Segment& segment) {
  return segment.box.area() / (segment.atBorder ? 4.0 : 1.0);
}

std::vector<std::vector<InstanceView>> bestViews(
    const WorldStore& observations, std::span<const ObjectInstance> instances, const FramePoses& poses,
    std::size_t most, const std::function<bool(std::size_t instance, const Observation::Segment&)>& wanted) {
  std::map<SegmentPlace, std::size_t> instanceOf;
  for (std::size_t i = 0; i < instances.size(); ++i)
    for (const SegmentPlace& place : instances[i].segments) instanceOf[place] = i;
  std::vector<std::vector<InstanceView>> views(instances.size());
  observations.forEachObservation([&](std::size_t frame, const Observation& seen) {
    if (!poses[frame]) return true;
    for (std::size_t s = 1; s <= seen.info.size(); ++s) {
      const auto instance = instanceOf.find({frame, s});
      const Observation::Segment& segment = seen.info[s - 1];
      if (instance == instanceOf.end() || !wanted(instance->second, segment)) continue;
      std::vector<InstanceView>& best = views[instance->second];
      const InstanceView view{{frame, s}, viewQuality(segment)};
      best.insert(
          std::ranges::upper_bound(best, view.quality, std::ranges::greater{}, &InstanceView::quality), view);
      if (best.size() > most) best.pop_back();
    }
    return true;
  });
  return views;
}

}  // namespace estancia
