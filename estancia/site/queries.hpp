// Live queries: where, ask, route, areas, objects, places and the map as JSON, shared by the API and agents.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstddef>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/live/live_view.hpp"

namespace estancia {

/// Goal of a route, in the form that routeInWorld() takes.
struct RouteQuestion {
  std::string to;           ///< the number of a place, the name of an area or an object, or words
  std::optional<int> from;  ///< the place to start from; where the robot is when absent
  std::vector<std::string> avoid = {}, prefer = {};
};

/// Answers of a LiveView. Lengths are meters, angles radians, positions [x, y] along the floor's two axes
/// (Floor) unless stated otherwise; what is not known is null. All but status() and where() throw Error
/// (insufficientData) before there is a map. Thread-safe.
class LiveQueries {
 public:
  using Json = nlohmann::ordered_json;

  /// The view must outlive it.
  explicit LiveQueries(const LiveView& view) : view_(view) {}

  /// All of LiveStatus; "where" is where().
  Json status() const;
  Json status(const LiveStatus& status) const;
  /// {"state", "frame", "time", "place": {"node", "name", "probability"}, "area": {"id", "name",
  /// "probability"}, "room", "pose": {"x", "y", "yaw"}, "unmapped", "belief": [{"node", "probability"}],
  /// "sentence"}.
  Json where() const;
  Json where(const LiveStatus& status) const;
  /// The output of `estancia ask --json` with at most `count` places and as many objects each; or
  /// "near_spellings" alone if nothing matches.
  Json ask(const std::string& words, std::size_t count) const;
  /// The output of `estancia route --json`. Throws Error as routeInWorld() does, and insufficientData if the
  /// robot's position is unknown.
  Json route(const RouteQuestion& question) const;
  /// {"objects": […]}, each in the form of toJson().
  Json objects() const;
  /// {"areas": […]}, each in the form of toJson(), with "objects": [{"id", "name"}] that are in them.
  Json areas() const;
  /// {"since", "objects": […], "places": […]}, in the form of toJson(); changes of objects have "from_at" and
  /// "to_at", [x, y], too. Throws Error as findChanges() does.
  Json changes(const std::optional<std::size_t>& since) const;
  /// {"node", "name", "room", "area", "position", "frames", "words": [{"label", "probability"}],
  /// "neighbors": [{"node", "name", "distance"}], "objects": [{"id", "name"}] that are seen best from there}.
  /// Throws Error (unknownName).
  Json place(int node) const;
  /// Data for drawing the map: {"map_revision", "metric", "drives" (how many), "areas": [{…, "outlines":
  /// [[[x, y]]], "color"}], "walls": [[[x, y]]], "path": [[[x, y]]], "places": [{"node", "name", "position",
  /// "frames", "area"}], "links": [[node, node]], "objects": [{…, "where", "node" that it is seen best from,
  /// "color", "at": [x, y], "box": [[x, y]]}]}. An odd number of outlines surrounds what is inside. Without
  /// poses "metric" is false, and places lie so that their distances follow the number of transitions between
  /// them. The text is constant until the map changes.
  std::shared_ptr<const std::string> map() const;

 private:
  /// A world, and what is computed from it once.
  struct Known {
    std::shared_ptr<const WorldMap> world;
    Floor floor;
    std::vector<std::string> placeNames;
    std::mutex drawing;
    std::shared_ptr<const std::string> map;
  };
  /// nullptr before there is a map.
  std::shared_ptr<Known> find() const;
  std::shared_ptr<Known> get() const;

  const LiveView& view_;
  mutable std::mutex computing_;
  mutable std::mutex mutex_;  // guards the members below
  mutable std::shared_ptr<Known> known_;
};

/// LiveQueries::map() without its revision. `placeNames`: one a node, "" where none is known.
nlohmann::ordered_json drawMap(const WorldMap& world, const Floor& floor,
                               const std::vector<std::string>& placeNames);

/// Serializes JSON. Bytes that are no UTF-8 become U+FFFD.
std::string textOf(const nlohmann::ordered_json& json);

/// The whole text as a number; nothing for any other text.
template <class Number>
std::optional<Number> wholeNumber(std::string_view text) {
  Number number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  return problem == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace estancia
