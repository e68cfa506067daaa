// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/measures.hpp"

#include "estancia/topology/accuracy.hpp"
#include "estancia/topology/quality.hpp"
#include "estancia/zones/measure.hpp"

#include <fmt/format.h>

namespace estancia {

std::string Measure::text() const {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "unknown";
}

namespace {

double count(std::size_t n) {
  return static_cast<double>(n);
}

/// What clusters are compared with: the rooms that the camera stood in, or those that the images see.
struct RoomKind {
  std::string key, name, rooms, room;
};
const RoomKind kStoodIn{"", "", "rooms", "room"};
const RoomKind kSeen{"seen_", "Seen: ", "the rooms seen", "room seen"};

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// Adds the five measures of places or zones ("they": what the clusters are) beside rooms, and of how many
/// images they tell, where there are some.
void addRooms(std::vector<Measure>& measures, const std::optional<Agreement>& rooms,
              std::size_t framesWithRoom, const std::string& it, const std::string& they,
              const RoomKind& kind = kStoodIn) {
  const auto value = [&rooms](double Agreement::*member) -> std::optional<double> {
    if (!rooms) return std::nullopt;
    return (*rooms).*member;
  };
  const auto name = [&kind](const std::string& text) {
    return kind.name.empty() ? capital(text) : kind.name + text;
  };
  if (framesWithRoom > 0)
    measures.push_back({"frames_with_" + (kind.key.empty() ? "room" : kind.key + "room"),
                        "Frames with a " + kind.room, count(framesWithRoom), 0,
                        "Images that the next five are about"});
  const std::vector<Measure> five{
      {kind.key + "v_measure", name("V-measure"), value(&Agreement::vMeasure), 3,
       "Agreement of " + they + " and " + kind.rooms + ", 1 is best"},
      {kind.key + "homogeneity", name("homogeneity"), value(&Agreement::homogeneity), 3,
       "1: every " + it + " lies in one " + kind.room},
      {kind.key + "completeness", name("completeness"), value(&Agreement::completeness), 3,
       "1: every " + kind.room + " is one " + it},
      {kind.key + "ari", name("adjusted Rand index"), value(&Agreement::adjustedRandIndex), 3,
       "Pairs judged alike; 0 is chance"},
      {kind.key + "purity", name("purity"), value(&Agreement::purity), 3,
       "Share of images in the main " + kind.room + " of their " + it}};
  measures.insert(measures.end(), five.begin(), five.end());
}

}  // namespace

std::vector<Measure> measuresOf(const MapQuality& q) {
  std::vector<Measure> measures{
      {"frames", "Frames", count(q.frames), 0, "Images in the map"},
      {"nodes", "Places", count(q.nodes), 0, "Nodes of the map"},
      {"transitions", "Transitions", count(q.transitions), 0, "Ways driven, each direction of its own"},
  };
  addRooms(measures, q.rooms, q.framesWithRoom, "place", "places");
  if (q.framesWithRoomSeen > 0)
    addRooms(measures, q.roomsSeen, q.framesWithRoomSeen, "place", "places", kSeen);
  if (q.predictedRoom) {
    measures.push_back({"predicted_room", "Predicted room, image", q.predictedRoom, 3,
                        "Share of images that the classifier takes for their true room"});
    measures.push_back({"predicted_node_room", "Predicted room, place", q.predictedNodeRoom, 3,
                        "Share of images whose place it takes for their true room"});
  }
  const std::vector<Measure> more{
      {"spatial_spread", "Spatial spread [m]", q.spatialSpread, 2,
       "Mean distance of images to their place's center"},
      {"edge_precision", "Edge precision", q.edgePrecision, 3, "Share of links that the rooms really have"},
      {"edge_recall", "Edge recall", q.edgeRecall, 3, "Share of real room links that the map has"},
      {"original_a", "A room purity", q.original.roomPurity, 3,
       "Original program: rooms do not mix in places"},
      {"original_b", "B sparseness", q.original.sparseness, 3, "Original program: few links"},
      {"original_c", "C link closeness", q.original.linkCloseness, 3,
       "Original program: linked places are close"},
      {"original_d", "D compactness", q.original.compactness, 3, "Original program: places are small"},
      {"original_e", "E spread", q.original.spread, 3, "Original program: the map is wide"},
      {"original_total", "20·(A+B+C+D+E)", q.original.total, 1, "Original program: 0 … 100"},
  };
  measures.insert(measures.end(), more.begin(), more.end());
  return measures;
}

std::vector<Measure> measuresOf(const LocalizationAccuracy& a) {
  return {
      {"localized_frames", "Localized frames", static_cast<double>(a.frames), 0,
       "Images that were looked for"},
      {"node_room", "Right room, nearest place", a.nodeRoom, 3, "Each image alone"},
      {"image_room", "Right room, nearest image", a.nearestImage.room, 3, "Each image alone"},
      {"belief_node_room", "Right room, believed place", a.beliefNodeRoom, 3, "All images so far"},
      {"belief_zone_room", "Right room, believed zone", a.beliefZoneRoom, 3, "All images so far; --zones"},
      {"belief_room", "Right room, believed image", a.belief.room, 3, "All images so far"},
      {"judged_frames", "Frames with an admissible image",
       a.judgedFrames > 0 ? std::optional(count(a.judgedFrames)) : std::nullopt, 0,
       "Images that both recalls are about"},
      {"recall", "Recall@1, nearest image", a.nearestImage.recall, 3,
       "Share of admissible answers, each image alone"},
      {"belief_recall", "Recall@1, believed image", a.belief.recall, 3,
       "Share of admissible answers, all images so far"},
      {"median_error", "Median error [m]", a.nearestImage.medianError, 2, "To the nearest image's position"},
      {"belief_median_error", "Median error, belief [m]", a.belief.medianError, 2,
       "To the believed image's position"},
  };
}

std::vector<Measure> measuresOf(const ZoneQuality& q) {
  std::vector<Measure> measures{
      {"frames", "Frames", count(q.frames), 0, "Images that were clustered"},
      {"zones", "Zones", count(q.zones), 0, "Areas that were found"},
  };
  addRooms(measures, q.rooms, q.framesWithRoom, "zone", "zones");
  if (q.framesWithRoomSeen > 0) addRooms(measures, q.roomsSeen, q.framesWithRoomSeen, "zone", "zones", kSeen);
  if (q.predictedRoom)
    measures.push_back({"predicted_zone_room", "Predicted room, zone", q.predictedRoom, 3,
                        "Share of images whose zone the classifier takes for their true room"});
  measures.push_back({"spatial_spread", "Spatial spread [m]", q.spatialSpread, 2,
                      "Mean distance of images to their zone's center"});
  return measures;
}

}  // namespace estancia
