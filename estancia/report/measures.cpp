// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/measures.hpp"

#include <fmt/format.h>

#include "estancia/core/ascii.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/world_query/evaluate_world.hpp"
#include "estancia/zones/measure.hpp"

namespace estancia {

std::string Measure::text() const {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "unknown";
}

namespace {

double count(std::size_t n) {
  return static_cast<double>(n);
}

/// Reference of clusters: the rooms that the camera stood in, or those that the images see.
struct RoomKind {
  std::string key, name, rooms, room;
};
const RoomKind stoodIn{"", "", "rooms", "room"};
const RoomKind seen{"seen_", "Seen: ", "the rooms seen", "room seen"};

/// Adds the five measures of places or zones ("they": what the clusters are) beside rooms, and the number of
/// images they cover, if there are some.
void addRooms(std::vector<Measure>& measures, const std::optional<Agreement>& rooms,
              std::size_t framesWithRoom, const std::string& it, const std::string& they,
              const RoomKind& kind = stoodIn) {
  const auto value = [&rooms](double Agreement::*member) -> std::optional<double> {
    if (!rooms) return std::nullopt;
    return (*rooms).*member;
  };
  const auto name = [&kind](std::string text) {
    if (kind.name.empty()) text[0] = upperCase(text[0]);
    return kind.name + text;
  };
  if (framesWithRoom > 0)
    measures.push_back({"frames_with_" + (kind.key.empty() ? "room" : kind.key + "room"),
                        "Frames with a " + kind.room, count(framesWithRoom), 0,
                        "Images that the next five are about"});
  measures.insert(measures.end(),
                  {{kind.key + "v_measure", name("V-measure"), value(&Agreement::vMeasure), 3,
                    "Agreement of " + they + " and " + kind.rooms + ", 1 is best"},
                   {kind.key + "homogeneity", name("homogeneity"), value(&Agreement::homogeneity), 3,
                    "1: every " + it + " lies in one " + kind.room},
                   {kind.key + "completeness", name("completeness"), value(&Agreement::completeness), 3,
                    "1: every " + kind.room + " is one " + it},
                   {kind.key + "ari", name("adjusted Rand index"), value(&Agreement::adjustedRandIndex), 3,
                    "Pairs judged alike; 0 is chance"},
                   {kind.key + "purity", name("purity"), value(&Agreement::purity), 3,
                    "Share of images in the main " + kind.room + " of their " + it}});
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
    addRooms(measures, q.roomsSeen, q.framesWithRoomSeen, "place", "places", seen);
  if (q.predictedRoom) {
    measures.push_back({"predicted_room", "Predicted room, image", q.predictedRoom, 3,
                        "Share of images that the classifier takes for their true room"});
    measures.push_back({"predicted_node_room", "Predicted room, place", q.predictedNodeRoom, 3,
                        "Share of images whose place it takes for their true room"});
  }
  measures.insert(
      measures.end(),
      {
          {"spatial_spread", "Spatial spread [m]", q.spatialSpread, 2,
           "Mean distance of images to their place's center"},
          {"edge_precision", "Edge precision", q.edgePrecision, 3,
           "Share of links that the rooms really have"},
          {"edge_recall", "Edge recall", q.edgeRecall, 3, "Share of real room links that the map has"},
          {"original_a", "A room purity", q.original.roomPurity, 3,
           "Original program: rooms do not mix in places"},
          {"original_b", "B sparseness", q.original.sparseness, 3, "Original program: few links"},
          {"original_c", "C link closeness", q.original.linkCloseness, 3,
           "Original program: linked places are close"},
          {"original_d", "D compactness", q.original.compactness, 3,
           "Original program: a place's last image is near its middle"},
          {"original_e", "E spread", q.original.spread, 3, "Original program: the map is wide"},
          {"original_total", "20·(A+B+C+D+E)", q.original.total, 1, "Original program: 0 … 100"},
      });
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

std::vector<Measure> measuresOf(const LocalizationSummary& s) {
  return {
      {"believed_places", "Believed places", count(s.places.size()), 0, "Places that any image is taken for"},
      {"median_confidence", "Median confidence", s.medianConfidence, 3, "Probability of the believed place"},
      {"unmapped", "Unmapped views", s.unmapped, 3,
       "Share of images that no image of the map was taken near"},
  };
}

std::vector<Measure> measuresOf(const ZoneQuality& q) {
  std::vector<Measure> measures{
      {"frames", "Frames", count(q.frames), 0, "Images that were clustered"},
      {"zones", "Zones", count(q.zones), 0, "Areas that were found"},
  };
  addRooms(measures, q.rooms, q.framesWithRoom, "zone", "zones");
  if (q.framesWithRoomSeen > 0) addRooms(measures, q.roomsSeen, q.framesWithRoomSeen, "zone", "zones", seen);
  if (q.predictedRoom)
    measures.push_back({"predicted_zone_room", "Predicted room, zone", q.predictedRoom, 3,
                        "Share of images whose zone the classifier takes for their true room"});
  measures.push_back({"spatial_spread", "Spatial spread [m]", q.spatialSpread, 2,
                      "Mean distance of images to their zone's center"});
  return measures;
}

namespace {

/// Areas beside rooms: two measures of five.
void addAreas(std::vector<Measure>& measures, const std::optional<Agreement>& agreement,
              const RoomKind& kind) {
  if (!agreement) return;
  const std::string name = std::string(kind.key.empty() ? "Areas" : "Areas, seen") + ": ";
  measures.push_back({"area_" + kind.key + "v_measure", name + "V-measure", agreement->vMeasure, 3,
                      "Agreement of areas and " + kind.rooms + ", 1 is best"});
  measures.push_back({"area_" + kind.key + "ari", name + "Rand index", agreement->adjustedRandIndex, 3,
                      "Adjusted: pairs judged alike; 0 is chance"});
}

/// `key` ends the keys in JSON, `name` the names for people.
void addObjects(std::vector<Measure>& measures, const InstanceScore& score, const std::string& key,
                const std::string& name, const std::string& which) {
  const auto add = [&](const char* measure, const char* title, std::optional<double> value, int decimals,
                       const std::string& explanation) {
    if (value) measures.push_back({measure + key, title + name, value, decimals, explanation});
  };
  add("things", "Things", count(score.things), 0, which);
  add("object_recall", "Recall", score.recall(), 3, "Share of the things that an object is");
  // Objects that are no thing have no class.
  if (key.empty())
    add("object_precision", "Precision", score.precision(), 3, "Share of the objects that are a thing");
  add("object_error", "Error [m]", score.error, 3, "Median, between the middles of the boxes");
  add("nameable_things", "Nameable", score.nameable > 0 ? std::optional(count(score.nameable)) : std::nullopt,
      0, "Found things that the labels can name");
  add("object_names", "Right names", score.nameAccuracy(), 3, "Share of these whose best word is one");
}

}  // namespace

std::vector<Measure> measuresOf(const WorldAccuracy& a) {
  std::vector<Measure> measures;
  if (a.areas > 0)
    measures.push_back({"areas", "Areas", count(a.areas), 0, "Parts of the floor between walls and doors"});
  addAreas(measures, a.areasAndRooms, stoodIn);
  addAreas(measures, a.areasAndRoomsSeen, seen);
  if (a.trajectory) {
    measures.push_back({"trajectory_frames", "Frames with a true pose", count(a.trajectory->poses), 0,
                        "Those that have one in the map, too"});
    measures.push_back({"trajectory_rmse", "Trajectory error [m]", a.trajectory->rmse, 3,
                        "RMSE of the positions after alignment"});
  }
  if (!a.objects) return measures;
  const InstanceAccuracy& objects = *a.objects;
  const InstanceScore& all = objects.counted;
  addObjects(measures, all, "", "", "That enough frames show well, without fixtures");
  measures.push_back({"objects", "Objects", count(all.instances), 0, "Without fixtures and what hangs"});
  if (objects.split && objects.merged) {
    measures.push_back({"split_things", "Split things", count(*objects.split), 0,
                        "Several objects show mostly the same one"});
    measures.push_back({"merged_objects", "Merged objects", count(*objects.merged), 0,
                        "Another thing has a quarter of their pixels"});
  }
  std::size_t classes = 0;
  for (const auto& [name, score] : objects.ofClass) classes += name == "none" ? 0 : 1;
  for (const auto& [name, score] : objects.ofClass)
    if (classes > 1 && name != "none") addObjects(measures, score, "_" + name, ", " + name, "Of this class");
  return measures;
}

}  // namespace estancia
