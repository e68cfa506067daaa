// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/page_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "estancia/core/frame.hpp"
#include "estancia/map_file/store.hpp"

namespace estancia {

PageImages imagesOf(const MapStore& map, const std::vector<Frame>& frames) {
  std::unordered_map<std::string, std::size_t> stored;
  const TopologicalMap content = map.load();
  for (const std::size_t frame : map.imageFrames())
    if (const auto index = content.findFrame(frame)) stored.emplace(content.frames[*index].name, frame);
  PageImages images;
  std::map<std::size_t, std::size_t> there;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (const auto found = stored.find(frames[i].name); found != stored.end()) {
      images.frames.push_back(i);
      there[i] = found->second;
    }
  images.read = [&map, there = std::move(there)](std::size_t frame) { return map.image(there.at(frame)); };
  return images;
}

}  // namespace estancia

namespace estancia::report {

Markup factList(const Facts& facts) {
  Markup list;
  list.open("dl", {{"class", "facts"}});
  for (const auto& [name, value] : facts)
    if (!value.empty()) list.open("div").element("dt", name).element("dd", value).close();
  return list.close();
}

Markup pageHeader(const std::string& title, const std::vector<std::pair<std::size_t, std::string>>& counts,
                  const Facts& facts) {
  Markup header;
  header.open("header", {{"class", "top"}}).element("h1", shorten(title, 160));
  header.open("dl", {{"class", "figures"}});
  for (const auto& [count, noun] : counts)
    header.open("div").element("dt", noun + (count == 1 ? "" : "s")).element("dd", grouped(count)).close();
  return header.close().add(factList(facts)).close();
}

Markup measuresSection(const std::vector<Measure>& measures) {
  Markup section;
  if (measures.empty()) return section;
  section.open("section", {{"id", "measures"}}).element("h2", "Measures").open("table").open("tbody");
  for (const Measure& measure : measures)
    section.open("tr")
        .element("th", {{"scope", "row"}}, shorten(measure.name, 120))
        .element("td", {{"class", "value"}}, shorten(measure.text(), 60))
        .element("td", shorten(measure.explanation, 400))
        .close();
  return section.close().close().close();
}

Markup placesSection(const std::string& heading, const std::string& before, const Cards& cards,
                     const std::string& after, const std::string& smaller) {
  Markup section;
  section.open("section", {{"id", "places"}}).element("h2", heading);
  std::string note = before;
  if (cards.withheld > 0) note += counted(cards.withheld, "image") + " left out to keep this page small. ";
  note += after;
  if (!note.empty()) section.element("p", {{"class", "note"}}, note);
  section.open("div", {{"class", "cards"}}).add(cards.cards).close();
  if (!cards.rows.empty())
    section.open("details", {{"id", "smaller"}}).element("summary", smaller).add(cards.rows).close();
  return section.close();
}

std::string abbreviate(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789abcdef", i), text.size());
    out += end - i > 16 ? text.substr(i, 12) + "…" : text.substr(i, end - i);
    if (end < text.size()) out += text[end];
    i = end + 1;
  }
  return shorten(out, 120);
}

namespace {

/// At most `count` of the frames that have images, evenly spread.
std::vector<std::size_t> choose(const std::vector<std::size_t>& frames,
                                const std::vector<std::size_t>& imaged, std::size_t count) {
  std::vector<std::size_t> candidates, chosen;
  std::ranges::set_intersection(frames, imaged, std::back_inserter(candidates));
  count = std::min(count, candidates.size());
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(candidates[(2 * i + 1) * candidates.size() / (2 * count)]);
  return chosen;
}

}  // namespace

LoadedImages loadImages(const std::vector<const std::vector<std::size_t>*>& places,
                        const PageImages& images) {
  LoadedImages loaded;
  if (!images.read) return loaded;
  std::vector<std::vector<std::size_t>> chosen;
  for (const auto* frames : places) chosen.push_back(choose(*frames, images.frames, images.each));
  std::size_t left = images.bytes;
  for (std::size_t round = 0; round < images.each; ++round)
    for (const auto& frames : chosen) {
      if (round >= frames.size()) continue;
      // the middle first, should there be room for one only
      const std::size_t frame = frames[(round + frames.size() / 2) % frames.size()];
      std::vector<unsigned char> bytes = left > 0 ? images.read(frame) : std::vector<unsigned char>{};
      if (left > 0 && bytes.empty()) continue;
      if (left == 0 || bytes.size() > left) {
        left = 0;
        ++loaded.withheld;
        continue;
      }
      left -= bytes.size();
      loaded.byFrame.emplace(frame, std::move(bytes));
    }
  return loaded;
}

Markup imageGrid(const LoadedImages& images, const std::vector<std::size_t>& frames, const std::string& what,
                 const std::function<std::string(std::size_t)>& nameOf) {
  std::vector<std::size_t> shown;
  for (const auto& [frame, bytes] : images.byFrame)
    if (std::binary_search(frames.begin(), frames.end(), frame)) shown.push_back(frame);
  Markup grid;
  if (shown.empty()) return grid;
  grid.open("div", {{"class", fmt::format("images p{}", std::min<std::size_t>(shown.size(), 4))}});
  for (const std::size_t frame : shown) {
    const std::string name = fmt::format("frame {}: {}", frame, shorten(nameOf(frame), 80));
    grid.leaf("img", {{"src", imageUri(images.byFrame.at(frame), "the image of " + name)},
                      {"alt", what + ", " + name},
                      {"title", name},
                      {"decoding", "async"}});
  }
  return grid.close();
}

}  // namespace estancia::report
