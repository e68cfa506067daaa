#include "estancia/report/zone_cards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "estancia/report/label_bars.hpp"
#include "estancia/report/symbols.hpp"

namespace estancia::report {
namespace {

constexpr std::size_t mostRows = 500;

/// "kitchen 34, corridor 2, …": the rooms a zone's images are in, "" where none is known.
std::string roomsOf(const ZonesSummary& summary, const Zone& zone) {
  constexpr std::size_t shown = 4;
  std::map<std::string, std::size_t> counts;
  for (const std::size_t image : zone.images)
    if (const std::string& room = summary.zones->frames[image].room; !room.empty()) ++counts[room];
  std::vector<std::pair<std::string, std::size_t>> rooms(counts.begin(), counts.end());
  std::stable_sort(rooms.begin(), rooms.end(), [](auto& a, auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, rooms.size()); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", shorten(rooms[i].first, 32), grouped(rooms[i].second));
  if (rooms.size() > shown) text += fmt::format(" and {} more", rooms.size() - shown);
  return text;
}

std::string positionOf(const ZoneExtent& extent) {
  return fmt::format("Around ({}, {}, {}) m, its images {} m from there on average", number(extent.center[0]),
                     number(extent.center[1]), number(extent.center[2]), significant(extent.spread));
}

void addFacts(Markup& card, const ZonesSummary& summary, const ZoneSummary& entry) {
  card.element("p", describeVisits(entry.visits));
  const std::string rooms = roomsOf(summary, *entry.zone);
  if (!rooms.empty()) card.element("p", "Rooms: " + rooms);
  if (const std::string taken = describeRooms(entry.zone->predicted); !taken.empty())
    card.element("p", "Taken for " + shorten(taken, 90));
  if (entry.zone->extent) card.element("p", positionOf(*entry.zone->extent));
}

std::string sizeOf(const ZoneSummary& entry) {
  return fmt::format("Zone {} · {} · {:.1f} %", entry.zone->id, counted(entry.zone->images.size(), "image"),
                     100 * entry.share);
}

void addCard(Markup& out, const ZonesSummary& summary, const ZoneSummary& entry, const LoadedImages& images) {
  const Zone& zone = *entry.zone;
  out.open("article", {{"class", "card"}, {"id", fmt::format("zone-{}", zone.id)}, {"tabindex", "-1"}});
  out.open("header").add(badge(entry.style, std::to_string(zone.id))).open("div");
  out.element("h3", entry.name).element("p", sizeOf(entry)).close().close();
  const auto nameOf = [&summary](std::size_t frame) { return summary.zones->frames[frame].name; };
  out.add(imageGrid(images, zone.images, fmt::format("What zone {} looks like", zone.id), nameOf));
  out.add(labelBars(summary.zones->vocabulary, zone.mean, zone.sigma, 8));
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

}  // namespace

ZoneCards zoneCards(const ZonesSummary& summary, const PageImages& images, std::size_t cards) {
  ZoneCards result;
  result.carded = std::min(cards, summary.list.size());
  result.listed = std::min(mostRows, summary.list.size() - result.carded);
  std::vector<const std::vector<std::size_t>*> withCards;
  for (std::size_t i = 0; i < result.carded; ++i) withCards.push_back(&summary.list[i].zone->images);
  const LoadedImages loaded = loadImages(withCards, images);
  result.withheld = loaded.withheld;
  for (std::size_t i = 0; i < result.carded; ++i) addCard(result.cards, summary, summary.list[i], loaded);
  for (std::size_t i = result.carded; i < result.carded + result.listed; ++i)
    addRow(result.rows, summary, summary.list[i]);
  return result;
}

}  // namespace estancia::report
