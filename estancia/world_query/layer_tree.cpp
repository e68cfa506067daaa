// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/layer_tree.hpp"

#include <limits>

#include "estancia/world_query/ask_world.hpp"

namespace estancia {

LayerTree::LayerTree(const WorldMap& world)
    : places(placesOf(world.places)), areaOfNode(areasOfNodes(world)) {
  for (const WorldObject& object : world.objects) {
    areaOfObject.push_back(object.area);
    std::size_t nearest = places.size();
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < places.size() && object.area >= 0; ++i) {
      if (areaOfNode[i] != object.area) continue;
      const double here =
          places[i].position
              ? distanceBetween(*places[i].position, {object.center.x, object.center.y, object.center.z})
              : std::numeric_limits<double>::max();
      if (here < distance) nearest = i, distance = here;
    }
    if (object.area < 0) nearest = indexOf(world.places, world.places.frames.at(object.bestFrame).node);
    nodeOfObject.push_back(nearest);
  }
}

std::vector<int> LayerTree::objectsOf(std::size_t node) const {
  std::vector<int> objects;
  for (std::size_t i = 0; i < nodeOfObject.size(); ++i)
    if (nodeOfObject[i] == node) objects.push_back(static_cast<int>(i));
  return objects;
}

std::vector<int> LayerTree::objectsBesidePlaces(int area) const {
  std::vector<int> objects;
  for (std::size_t i = 0; i < nodeOfObject.size(); ++i)
    if (nodeOfObject[i] == places.size() && areaOfObject[i] == area) objects.push_back(static_cast<int>(i));
  return objects;
}

cv::Matx33d axesOf(const Floor& floor) {
  cv::Matx33d axes;
  for (int i = 0; i < 3; ++i) {
    cv::Vec3d unit;
    unit[i] = 1;
    const cv::Point2d at = floor.position(unit);
    axes(i, 0) = at.x, axes(i, 1) = at.y, axes(i, 2) = floor.up()[i];
  }
  return axes;
}

}  // namespace estancia
