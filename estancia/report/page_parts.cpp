// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/page_parts.hpp"

#include <algorithm>

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

}  // namespace estancia::report
