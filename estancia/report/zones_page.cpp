// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zones_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/output_file.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"
#include "estancia/report/zone_figures.hpp"

namespace estancia {
namespace {

using namespace report;

Markup entries(const ZonesSummary& summary, std::size_t begin, std::size_t end) {
  Markup list;
  list.open("ol", {{"class", "zones"}, {"start", begin}});
  for (std::size_t zone = begin; zone < end; ++zone) {
    const ZoneSummary& entry = summary.list[zone];
    list.open("li").open("a", {{"href", fmt::format("#zone-{}", zone)}, {"data-zone", zone}});
    list.add(symbol(entry.style)).element("b", std::to_string(zone)).element("span", entry.name);
    list.element("span", {{"class", "p"}}, fmt::format("{:.1f} %", 100 * entry.share));
    list.add(bar(100 * (entry.share / summary.list.front().share), &entry.style.fill)).close().close();
  }
  return list.close();
}

/// Every zone with a style of its own as a link to `#zone-<id>`, the largest first; many are folded away.
Markup zoneLegend(const ZonesSummary& summary) {
  constexpr std::size_t open = 30;
  const std::size_t shown = summary.styled <= open + 5 ? summary.styled : open;  // a few are not worth a fold
  Markup legend = entries(summary, 0, shown);
  if (shown < summary.styled) {
    legend.open("details").element("summary", counted(summary.styled - shown, "smaller zone"));
    legend.add(entries(summary, shown, summary.styled)).close();
  }
  if (summary.styled < summary.list.size()) {
    std::size_t images = 0;
    for (std::size_t zone = summary.styled; zone < summary.list.size(); ++zone)
      images += summary.list[zone].zone->images.size();
    legend.open("p", {{"class", "rest"}}).add(symbol(plainStyle()));
    legend.text(fmt::format(
        "{} still smaller, {:.1f} % of the images", counted(summary.list.size() - summary.styled, "zone"),
        100.0 * static_cast<double>(images) / static_cast<double>(summary.zones->frames.size())));
    legend.close();
  }
  return legend;
}

constexpr std::size_t maxRows = 500;

/// "kitchen 34, corridor 2, …": the rooms a zone's images are in, "" where none is known.
std::string roomsOf(const ZonesSummary& summary, const Zone& zone) {
  constexpr std::size_t shown = 4;
  std::map<std::string, std::size_t> counts;
  for (const std::size_t image : zone.images)
    if (const std::string& room = summary.zones->frames[image].room; !room.empty()) ++counts[room];
  std::vector<std::pair<std::string, std::size_t>> rooms(counts.begin(), counts.end());
  std::ranges::stable_sort(rooms, [](auto& a, auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, rooms.size()); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", shorten(rooms[i].first, 32), grouped(rooms[i].second));
  if (rooms.size() > shown) text += fmt::format(" and {} more", rooms.size() - shown);
  return text;
}

void addFacts(Markup& card, const ZonesSummary& summary, const ZoneSummary& entry) {
  card.element("p", describeVisits(entry.visits));
  const std::string rooms = roomsOf(summary, *entry.zone);
  if (!rooms.empty()) card.element("p", "Rooms: " + rooms);
  if (const std::string taken = describeRooms(entry.zone->predicted); !taken.empty())
    card.element("p", "Taken for " + shorten(taken, 90));
  if (const auto& extent = entry.zone->extent)
    card.element("p", fmt::format("Around ({}, {}, {}) m, its images {} m from there on average",
                                  number(extent->center[0]), number(extent->center[1]),
                                  number(extent->center[2]), significant(extent->spread)));
}

std::string sizeOf(const ZoneSummary& entry) {
  return fmt::format("Zone {} · {} · {:.1f} %", entry.zone->id, counted(entry.zone->images.size(), "image"),
                     100 * entry.share);
}

void addCard(Markup& out, const ZonesSummary& summary, const ZoneSummary& entry,
             const LabelConcepts& concepts, const LoadedImages& images) {
  const Zone& zone = *entry.zone;
  out.open("article", {{"class", "card"}, {"id", fmt::format("zone-{}", zone.id)}, {"tabindex", "-1"}});
  out.open("header").add(badge(entry.style, std::to_string(zone.id))).open("div");
  out.element("h3", entry.name).element("p", sizeOf(entry)).close().close();
  const auto nameOf = [&summary](std::size_t frame) { return summary.zones->frames[frame].name; };
  out.add(imageGrid(images, zone.images, fmt::format("What zone {} looks like", zone.id), nameOf));
  out.add(labelBars(summary.zones->vocabulary, concepts, zone.mean, zone.sigma, 8));
  out.open("footer").add(visitStrip(entry.visits, summary.zones->frames.size()));
  addFacts(out, summary, entry);
  out.close().close();
}

void addRow(Markup& out, const ZonesSummary& summary, const ZoneSummary& entry) {
  out.open("article", {{"class", "row"}, {"id", fmt::format("zone-{}", entry.zone->id)}, {"tabindex", "-1"}});
  out.element("h3", fmt::format("{}: {}", sizeOf(entry), entry.name));
  addFacts(out, summary, entry);
  out.close();
}

Cards zoneCards(const ZonesSummary& summary, const ZonesPage& page) {
  const LabelConcepts none, &concepts = page.concepts == nullptr ? none : *page.concepts;
  Cards result;
  result.carded = std::min(page.cards, summary.list.size());
  result.listed = std::min(maxRows, summary.list.size() - result.carded);
  std::vector<const std::vector<std::size_t>*> withCards;
  for (std::size_t i = 0; i < result.carded; ++i) withCards.push_back(&summary.list[i].zone->images);
  const LoadedImages loaded = loadImages(withCards, page.images);
  result.withheld = loaded.withheld;
  for (std::size_t i = 0; i < result.carded; ++i)
    addCard(result.cards, summary, summary.list[i], concepts, loaded);
  for (std::size_t i = result.carded; i < result.carded + result.listed; ++i)
    addRow(result.rows, summary, summary.list[i]);
  return result;
}

Markup headerOf(const ZonesPage& page) {
  const Zones& zones = page.zones;
  std::vector<std::pair<std::size_t, std::string>> counts{{zones.frames.size(), "image"},
                                                          {zones.zones.size(), "zone"}};
  if (!zones.rooms.empty()) counts.emplace_back(zones.rooms.size(), "room");
  Facts facts{{"Model", abbreviate(zones.model)},
              {"Distance", shorten(zones.distance, 120)},
              {"Linkage", shorten(zones.linkage, 120)},
              {"Cut", significant(zones.cut)},
              {"Vocabulary", counted(zones.vocabulary.size(), "label")}};
  for (const Measure& measure : page.measures)
    if (measure.value && (measure.key == "v_measure" || measure.key == "ari" || measure.key == "purity"))
      facts.emplace_back(measure.name, measure.text());
  facts.emplace_back("Date", shorten(page.date, 60));
  return pageHeader(page.title, counts, facts);
}

/// A drawing for wide screens and one for narrow ones; the style sheet shows the one that fits.
template <typename Draw>
void addFigure(Markup& body, const char* area, const char* title, const char* caption, double height,
               double narrowHeight, Draw draw) {
  body.open("figure", {{"class", fmt::format("figure {}", area)}}).element("h2", title);
  body.add(draw(FigureStyle{780, height, 12.5, true, "wide"}));
  body.add(draw(FigureStyle{358, narrowHeight, 11, false, "narrow"}));
  body.element("figcaption", caption).close();
}

void addExplorer(Markup& body, const ZonesPage& page, const ZonesSummary& summary) {
  std::vector<std::optional<Pose>> poses;
  for (const Frame& frame : page.zones.frames) poses.push_back(frame.pose);
  const FloorPlan* plan = page.floorPlan ? &*page.floorPlan : nullptr;
  const DrivenPath path = projectPath(poses, /*fromAbove=*/plan != nullptr);
  if (plan != nullptr) requireFitting(*plan, path.points);

  body.open("section",
            {{"class", path.empty ? "explore flat" : "explore"}, {"id", "map"}, {"aria-label", "Zones"}});
  if (!path.empty)
    addFigure(
        body, "image", "From above",
        "Every symbol is an image, where it was taken; images from one place stand round it. The dotted "
        "line is the driven path.",
        580, 440, [&](const FigureStyle& style) { return zoneFigure(summary, path, style, plan); });
  addFigure(body, "when", "Over the run", "Which zone each image is in, from the first image to the last.",
            62, 58, [&](const FigureStyle& style) { return timeStrip(summary, style); });
  body.open("div", {{"class", "side"}}).open("div", {{"class", "panel"}});
  body.element("h2", "Zones").add(zoneLegend(summary)).close();
  body.open("div", {{"class", "panel guide"}}).element("h2", "How to read this page");
  body.element(
      "p",
      "A zone holds images whose words are alike, wherever and whenever they were taken: positions and "
      "rooms were not used to find it. It is named by the room that it is taken for, if any, and the words "
      "that tell most about it. Select a zone "
      "to see it alone.");
  body.element("p", fmt::format("Zones were merged up to a distance of {}: {}.", significant(page.zones.cut),
                                shorten(page.zones.cutReason, 300)));
  if (path.empty) body.element("p", "No positions are known, so there is no view from above.");
  body.close().close();
  if (page.zones.dendrogram && page.zones.frames.size() > 1)
    addFigure(
        body, "merging", "How images became zones",
        "The two nearest become one, again and again, from right to left; what is joined left of the cut "
        "stays apart as zones. A wedge is a bundle of images whose merges are not drawn.",
        0, 0, [&](const FigureStyle& style) { return dendrogramFigure(summary, style); });
  body.close();
}

void addRooms(Markup& body, const ZonesSummary& summary) {
  constexpr std::size_t columns = 40;
  const RoomCounts counts = countRooms(*summary.zones, columns);
  if (counts.rooms.empty()) return;
  body.open("section", {{"id", "rooms"}}).element("h2", "Rooms and zones").add(roomTable(summary, counts));
  body.element(
      "p", {{"class", "note"}},
      "How many images of each room are in each zone; the darker, the more of the room. The rooms are "
      "known beforehand and only compared with the zones.");
  body.close();
}

Markup cardsOf(const ZonesPage& page, const ZonesSummary& summary) {
  const Cards cards = zoneCards(summary, page);
  std::string unlisted;
  if (const std::size_t told = cards.carded + cards.listed; told < summary.list.size())
    unlisted = counted(summary.list.size() - told, "zone") + " of the smallest are not listed.";
  std::string bars =
      "Bars are the mean probability of a word over the zone's images, ± its standard deviation";
  if (page.concepts != nullptr && !page.concepts->empty())
    bars += " where it stands for one label; the pointer on a word shows its labels";
  return placesSection("Zone by zone", bars + ". ", cards, unlisted, counted(cards.listed, "smaller zone"));
}

}  // namespace

std::string renderZonesPage(const ZonesPage& page) {
  const ZonesSummary summary = summarize(page.zones);
  Markup body;
  body.element("a", {{"class", "skip"}, {"href", "#places"}}, "Skip to the zones");
  body.open("main").add(headerOf(page));
  if (summary.list.empty()) {
    body.element("p", {{"class", "note"}}, "There are no zones yet.");
  } else {
    addExplorer(body, page, summary);
    addRooms(body, summary);
    body.add(cardsOf(page, summary));
  }
  body.add(measuresSection(page.measures)).close();
  return htmlDocument(page.title, mapPageCss + tablesCss + zonesPageCss, body, "", zonesPageScript);
}

void writeZonesPage(const std::filesystem::path& path, const ZonesPage& page) {
  writeWhole(path, renderZonesPage(page));
}

}  // namespace estancia
