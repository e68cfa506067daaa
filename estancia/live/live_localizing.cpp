// Live frames in a map that is there.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/live/edits.hpp"
#include "estancia/live/live_map.hpp"
#include "estancia/live/map_file_view.hpp"

namespace estancia {
namespace {

class LocalizingLiveMap final : public LiveMap {
 public:
  LocalizingLiveMap(Labeler& labeler, std::filesystem::path path, const LocalizerOptions& options)
      : path_(std::move(path)), localizer_(path_, options) {
    const TopologicalMap& map = localizer_.map();
    requireSameVocabulary(map.vocabulary, labeler.vocabulary(), path_.string());
    if (map.model != labeler.identity())
      fail(ErrorCode::mismatch,
           "{} was made with the model {}, not {}; use that one (--model, --precision, --reduced-images)",
           path_.string(), map.model, labeler.identity());
  }

  void take(const LiveFrame& live, DescriptorView words, const std::shared_ptr<const WorldMap>& world,
            const std::function<void(const LivePlace&)>& placed, const Deadline& /*deadline*/) override {
    if (world && std::exchange(world_, world) != world &&
        world->areaOfFrame.size() == localizer_.map().frames.size())
      localizer_.setZones(world->areaOfFrame);
    for (const Localization& found : localizer_.add(words, live.frame.pose)) {
      const MappedFrame& view = localizer_.map().frames[found.beliefImage];
      LivePlace place{view.pose, {{found.beliefNode, found.confidence}}};
      place.area = found.beliefZone.value_or(-1);
      place.areaProbability = place.area < 0 ? 0 : found.zoneConfidence;
      place.unmapped = found.unmapped;
      place.decision = fmt::format(
          "By all frames so far it is in place {} ({:.0f} %), where {} was taken; by itself it would be "
          "place {}.",
          found.beliefNode, 100 * found.confidence, view.name, found.node);
      placed(place);
    }
  }
  /// Another program may correct the map.
  bool refresh() override {
    constexpr auto between = std::chrono::seconds(1);
    const auto now = std::chrono::steady_clock::now();
    if (now < lookAt_) return false;
    lookAt_ = now + between;
    const std::string stamp = fileStamp(path_);
    return std::exchange(stamp_, stamp) != stamp;
  }
  void edit(const MapEdit& edit, const WorldMap& /*world*/) override { editMapFile(path_, edit); }

 private:
  std::filesystem::path path_;
  Localizer localizer_;
  std::string stamp_ = fileStamp(path_);
  std::chrono::steady_clock::time_point lookAt_;
  std::shared_ptr<const WorldMap> world_;  // whose areas the localizer has
};

}  // namespace

std::unique_ptr<LiveMap> makeLocalizingLiveMap(Labeler& labeler, const std::filesystem::path& path,
                                               const LiveOptions& options) {
  LocalizerOptions now = options.localizer;
  now.lookahead = 0;  // a robot asks where it is now
  return std::make_unique<LocalizingLiveMap>(labeler, path, now);
}

}  // namespace estancia
