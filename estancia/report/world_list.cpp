// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/world_list.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/figures/color.hpp"
#include "estancia/figures/symbols.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia::report {
namespace {

std::vector<const WorldObject*> objectsIn(const WorldMap& world, int area) {
  std::vector<const WorldObject*> objects;
  for (const WorldObject& object : world.objects)
    if (object.area == area) objects.push_back(&object);
  std::ranges::stable_sort(objects, [](auto* a, auto* b) {
    return a->givenName.empty() != b->givenName.empty() ? b->givenName.empty()
                                                        : a->probability() > b->probability();
  });
  return objects;
}

/// The best words with their probabilities, for the pointer that rests on it.
std::string wordsText(const WorldObject& object) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, object.words.size()); ++i)
    text += fmt::format("{}{} {:.0f} %", i == 0 ? "" : ", ", shorten(firstSynonym(object.words[i].label), 32),
                        100 * static_cast<double>(object.words[i].probability));
  return text;
}

void addItem(Markup& out, const WorldView& view, const WorldObject& object) {
  out.open("li").open("a", {{"class", "item"},
                            {"id", fmt::format("object-{}", object.id)},
                            {"href", "#world"},
                            {"data-object", object.id},
                            {"title", wordsText(object)}});
  if (view.images.contains(object.id)) {
    out.open("svg", {{"viewBox", "0 0 1 1"}, {"aria-hidden", "true"}});
    out.leaf("use", {{"href", fmt::format("#image-{}", object.id)}, {"width", 1}, {"height", 1}}).close();
  } else {
    const auto& [red, green, blue] = object.color;
    out.element("i", {{"style", "background:" + Color{red, green, blue}.hex()}}, "");
  }
  out.open("span").element("b", shorten(object.displayName(), 40));
  const std::string on = supportText(object, view.world);
  for (const std::string& more : {probabilityText(object), shorten(shapeText(object), 60), shorten(on, 60)})
    if (!more.empty()) out.element("small", more);
  out.close().close().close();
}

void addArea(Markup& out, const WorldView& view, const WorldArea* area) {
  const std::vector<const WorldObject*> objects = objectsIn(view.world, area == nullptr ? -1 : area->id);
  if (area == nullptr && objects.empty()) return;
  out.open("article",
           {{"class", "card inside"},
            {"id", area == nullptr ? std::string("area-none") : fmt::format("area-{}", area->id)}});
  out.open("header");
  if (area != nullptr) out.add(badge({areaColor(area->id)}, std::to_string(area->id)));
  out.open("div").element("h3", area == nullptr ? "In no area" : shorten(area->describedName(), 80));
  out.element("p", (area == nullptr ? ""
                                    : fmt::format("{:.1f} m² · {} · ", area->size,
                                                  area->frames == 0 ? "only looked into"
                                                                    : counted(area->frames, "frame"))) +
                       counted(objects.size(), "object"));
  out.close().close();
  if (!objects.empty()) {
    out.open("ul", {{"class", "items"}});
    for (const WorldObject* object : objects) addItem(out, view, *object);
    out.close();
  }
  out.close();
}

}  // namespace

Markup worldList(const WorldView& view) {
  Markup section;
  if (view.world.areas.empty() && view.world.objects.empty()) return section;
  section.open("section", {{"id", "areas"}});
  section.element("h2", view.world.areas.empty() ? "Objects" : "Areas and the objects in them");
  if (view.withheld > 0)
    section.element("p", {{"class", "note"}},
                    counted(view.withheld, "image") + " left out to keep this page small.");
  const bool alone = view.world.areas.size() + (objectsIn(view.world, -1).empty() ? 0 : 1) == 1;
  section.open("div", {{"class", alone ? "insides alone" : "insides"}});
  for (const WorldArea& area : view.world.areas) addArea(section, view, &area);
  addArea(section, view, nullptr);
  return section.close().close();
}

}  // namespace estancia::report
