#include "estancia/report/zones_page.hpp"

#include <fmt/format.h>

#include <optional>

#include "estancia/core/output_file.hpp"
#include "estancia/report/count_table.hpp"
#include "estancia/report/dendrogram_figure.hpp"
#include "estancia/report/driven_path.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"
#include "estancia/report/plane.hpp"
#include "estancia/report/time_strip.hpp"
#include "estancia/report/zone_cards.hpp"
#include "estancia/report/zone_figure.hpp"
#include "estancia/report/zone_legend.hpp"

namespace estancia {
namespace {

using namespace report;

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
  const DrivenPath path = projectPath(poses);

  body.open("section",
            {{"class", path.empty ? "explore flat" : "explore"}, {"id", "map"}, {"aria-label", "Zones"}});
  if (!path.empty)
    addFigure(
        body, "image", "From above",
        "Every symbol is an image, where it was taken; images from one place stand round it. The dotted "
        "line is the driven path.",
        580, 440, [&](const FigureStyle& style) { return zoneFigure(summary, path, style); });
  addFigure(body, "when", "Over the run", "Which zone each image is in, from the first image to the last.",
            62, 58, [&](const FigureStyle& style) { return timeStrip(summary, style); });
  body.open("div", {{"class", "side"}}).open("div", {{"class", "panel"}});
  body.element("h2", "Zones").add(zoneLegend(summary)).close();
  body.open("div", {{"class", "panel guide"}}).element("h2", "How to read this page");
  body.element(
      "p",
      "A zone holds images whose words are alike, wherever and whenever they were taken: positions and "
      "rooms were not used to find it. It is named by the words that tell most about it. Select a zone "
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

void addCards(Markup& body, const ZonesPage& page, const ZonesSummary& summary) {
  const ZoneCards cards = zoneCards(summary, page.images, page.cards);
  body.open("section", {{"id", "places"}}).element("h2", "Zone by zone");
  std::string limits =
      "Bars are the mean probability of a word over the zone's images, ± its standard deviation. ";
  if (cards.withheld > 0) limits += counted(cards.withheld, "image") + " left out to keep this page small. ";
  if (const std::size_t told = cards.carded + cards.listed; told < summary.list.size())
    limits += counted(summary.list.size() - told, "zone") + " of the smallest are not listed.";
  body.element("p", {{"class", "note"}}, limits).open("div", {{"class", "cards"}}).add(cards.cards).close();
  if (!cards.rows.empty()) {
    body.open("details", {{"id", "smaller"}});
    body.element("summary", counted(cards.listed, "smaller zone")).add(cards.rows).close();
  }
  body.close();
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
    addCards(body, page, summary);
  }
  body.add(measuresSection(page.measures)).close();
  return htmlDocument(page.title, mapPageCss + tablesCss + zonesPageCss, body, "", zonesPageScript);
}

void writeZonesPage(const std::filesystem::path& path, const ZonesPage& page) {
  writeWhole(path, renderZonesPage(page));
}

}  // namespace estancia
