// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/figures/svg.hpp"

namespace estancia {

using namespace report;
namespace {

constexpr double fontSize = 14, smallSize = 12;  // see tables.css and the style below
constexpr double widest = 340;                   // widest name [pixels]
constexpr double wider = 1.22;                   // than Helvetica are the widest of usual fonts
constexpr double minAxis = 420, minWidth = 1000;
constexpr double rowHeight = 24, barStep = 9, edge = 12, inset = 12, gap = 6;

double drawnWidth(const std::string& text, double size) {
  return wider * size * textWidth(text);
}

/// report::shortenToWidth() at the middle, as the ends of names distinguish them; at least "…" stays.
std::string shortenMiddleToWidth(std::string_view text, double width) {
  const std::string clean = cleanText(text);
  if (textWidth(clean) <= width) return clean;
  std::vector<std::size_t> starts;  // starts of the code points, and the end
  for (std::size_t i = 0; i < clean.size(); ++i)
    if ((static_cast<unsigned char>(clean[i]) & 0xC0) != 0x80) starts.push_back(i);
  starts.push_back(clean.size());
  for (std::size_t kept = starts.size() - 2;; --kept) {
    const std::size_t head = (kept + 1) / 2;
    const std::string shortened =
        clean.substr(0, starts[head]) + "…" + clean.substr(starts[starts.size() - 1 - (kept - head)]);
    if (kept <= 1 || textWidth(shortened) <= width) return shortened;
  }
}

std::string rankText(double rank) {
  return fmt::format("{:.2f}", rank);
}

/// The names; where one of them is too wide, all without what they have in common at their ends, up to a
/// separator, as only the rest distinguishes them.
std::vector<std::string> drawnNames(const RankDiagram& diagram) {
  constexpr std::string_view separators = "+/-_ ";
  std::vector<std::string> names;
  for (const auto& method : diagram.methods) names.push_back(cleanText(method.name));
  const auto tooWide = [](const std::string& name) { return drawnWidth(name, fontSize) > widest; };
  if (names.size() < 2 || std::none_of(names.begin(), names.end(), tooWide)) return names;
  std::size_t front = names[0].size(), back = front;
  for (const std::string& name : names) {
    const auto start = std::mismatch(name.begin(), name.end(), names[0].begin(), names[0].end()).first;
    const auto end = std::mismatch(name.rbegin(), name.rend(), names[0].rbegin(), names[0].rend()).first;
    front = std::min(front, static_cast<std::size_t>(start - name.begin()));
    back = std::min(back, static_cast<std::size_t>(end - name.rbegin()));
  }
  while (front > 0 && separators.find(names[0][front - 1]) == std::string_view::npos) --front;
  while (back > 0 && separators.find(names[0][names[0].size() - back]) == std::string_view::npos) --back;
  for (std::string& name : names)
    if (front + back < name.size())
      name = (front > 0 ? "…" : "") + name.substr(front, name.size() - front - back) + (back > 0 ? "…" : "");
  return names;
}

/// Where everything lies. Methods are given best first; the first half has its names at the left.
struct Geometry {
  std::vector<std::string> names;  // names as drawn
  std::size_t count = 0, atLeft = 0;
  double left = 0, right = 0, width = 0;  // ends of the stems, and of the image
  double axis = 0, bars = 0, rows = 0, height = 0;
  std::vector<std::size_t> levels;  // one a group, from the axis down

  explicit Geometry(const RankDiagram& diagram) : count(diagram.methods.size()), atLeft((count + 1) / 2) {
    double names1 = 0, names2 = 0;
    names = drawnNames(diagram);
    for (std::size_t m = 0; m < count; ++m) {
      const double bold = diagram.control == m ? 1.12 : 1;  // so much wider
      names[m] = shortenMiddleToWidth(names[m], widest / (wider * fontSize * bold));
      double& side = m < atLeft ? names1 : names2;
      side = std::max(side, bold * drawnWidth(names[m], fontSize) + gap +
                                drawnWidth(rankText(diagram.methods[m].meanRank), smallSize));
    }
    left = edge + names1 + gap;
    right = left + std::max(minAxis, minWidth - left - names2 - gap - edge);
    width = right + gap + names2 + edge;
    axis = diagram.criticalDifference ? 76 : 36;
    bars = axis + 16;
    levels = levelsOf(diagram);
    const std::size_t used = levels.empty() ? 0 : 1 + *std::max_element(levels.begin(), levels.end());
    rows = bars + static_cast<double>(used) * barStep + 12;
    height = rows + static_cast<double>(std::max<std::size_t>(atLeft, 1) - 1) * rowHeight + 18;
  }

  /// Across; a rank may be off the axis by rounding only.
  double x(double rank) const {
    const double share = count < 2 ? 0.5 : (rank - 1) / (static_cast<double>(count) - 1);
    return left + inset + std::clamp(share, 0.0, 1.0) * (right - left - 2 * inset);
  }
  /// Down, of a method's name: the outermost stem is the shortest, so that none cross.
  double y(std::size_t method) const {
    return rows + static_cast<double>(method < atLeft ? method : count - 1 - method) * rowHeight;
  }

 private:
  /// The lowest level where a bar meets no other.
  std::vector<std::size_t> levelsOf(const RankDiagram& diagram) const {
    std::vector<double> ends;  // ends of the last bar of each level
    std::vector<std::size_t> found;
    for (const auto& [first, last] : diagram.groups) {
      const double from = x(diagram.methods.at(first).meanRank), to = x(diagram.methods.at(last).meanRank);
      const auto free = std::find_if(ends.begin(), ends.end(), [&](double end) { return end + 14 < from; });
      found.push_back(static_cast<std::size_t>(free - ends.begin()));
      free == ends.end() ? ends.push_back(to) : void(*free = to);
    }
    return found;
  }
};

void drawAxis(const Geometry& at, Markup& svg) {
  const double most = static_cast<double>(at.count);
  svg.leaf("path", {{"class", "line"}, {"d", Path().move(at.x(1), at.axis).line(at.x(most), at.axis).str()}});
  const double perRank = at.count < 2 ? 1e9 : at.x(2) - at.x(1);
  const double step = std::max(1.0, niceStep(34 / perRank, 1));  // so that numbers keep apart
  const auto tick = [&](double rank, bool named) {
    svg.leaf("path",
             {{"class", "line"},
              {"d", Path().move(at.x(rank), at.axis).line(at.x(rank), at.axis - (named ? 8 : 4)).str()}});
    if (named)
      svg.element("text",
                  {{"class", "rank"}, {"x", at.x(rank)}, {"y", at.axis - 12}, {"text-anchor", "middle"}},
                  number(rank));
  };
  for (double rank = 1; rank <= most; ++rank) {
    const bool even = std::fmod(rank, step) == 0;
    const bool nearEnd = rank != 1 && rank != most && (rank - 1 < 0.7 * step || most - rank < 0.7 * step);
    const bool named = rank == 1 || rank == most || (even && !nearEnd);
    if (named || perRank >= 5) tick(rank, named);
  }
}

void drawMethod(const RankDiagram& diagram, std::size_t m, const Geometry& at, Markup& svg) {
  const bool left = m < at.atLeft, isControl = diagram.control == m;
  const double x = at.x(diagram.methods[m].meanRank), y = at.y(m), end = left ? at.left : at.right;
  svg.leaf("path", {{"class", isControl ? "stem control" : "stem"},
                    {"d", Path().move(x, at.axis).line(x, y).line(end, y).str()}});
  const std::string rank = rankText(diagram.methods[m].meanRank);
  const double beside = end + (left ? -gap : gap),
               name = beside + (left ? -1 : 1) * (gap + drawnWidth(rank, smallSize));
  const char* anchor = left ? "end" : "start";
  svg.element("text", {{"class", "rank"}, {"x", beside}, {"y", y + 4.5}, {"text-anchor", anchor}}, rank);
  svg.open(
      "text",
      {{"class", isControl ? "name control" : "name"}, {"x", name}, {"y", y + 4.5}, {"text-anchor", anchor}});
  svg.text(at.names[m]).element("title", diagram.methods[m].name + ": " + rank).close();
}

/// The drawing inside an <svg> of the given attributes.
Markup drawing(const RankDiagram& diagram, Attributes attributes, const std::string& style) {
  const Geometry at(diagram);
  const Attributes more{{"viewBox", fmt::format("0 0 {} {}", number(at.width), number(at.height))},
                        {"width", number(at.width)},
                        {"height", number(at.height)},
                        {"role", "img"},
                        {"aria-label", fmt::format("{}: mean ranks of {}", shorten(diagram.title, 160),
                                                   counted(diagram.methods.size(), "method"))}};
  attributes.insert(attributes.end(), more.begin(), more.end());
  Markup svg;
  svg.open("svg", attributes);
  if (!style.empty()) {
    svg.element("style", style);
    svg.leaf("rect", {{"class", "ground"}, {"width", "100%"}, {"height", "100%"}});
  }
  if (at.count > 0) drawAxis(at, svg);
  if (diagram.criticalDifference && at.count > 1) {
    const double from = at.x(1), to = at.x(1 + *diagram.criticalDifference), y = 32;
    Path whole;
    whole.move(from, y - 4).line(from, y + 4).move(from, y).line(to, y).move(to, y - 4).line(to, y + 4);
    svg.leaf("path", {{"class", "line"}, {"d", whole.str()}});
    svg.element("text", {{"class", "rank"}, {"x", from}, {"y", y - 10}},
                "critical difference " + rankText(*diagram.criticalDifference));
  }
  for (std::size_t m = 0; m < at.count; ++m) drawMethod(diagram, m, at, svg);
  for (std::size_t g = 0; g < diagram.groups.size(); ++g) {
    const double y = at.bars + static_cast<double>(at.levels[g]) * barStep;
    const auto x = [&](std::size_t method) { return at.x(diagram.methods.at(method).meanRank); };
    svg.leaf(
        "path",
        {{"class", "group"},
         {"d",
          Path().move(x(diagram.groups[g].first) - 4, y).line(x(diagram.groups[g].second) + 4, y).str()}});
  }
  return svg.close();
}

}  // namespace

Markup section(const RankDiagram& diagram) {
  Markup figure;
  figure.open("figure", {{"class", "chart"}}).element("h3", shorten(diagram.title, 160));
  figure.open("div", {{"class", "ranks"}, {"tabindex", "0"}}).add(drawing(diagram, {}, "")).close();
  if (!diagram.caption.empty()) figure.element("figcaption", shorten(diagram.caption, 600));
  return figure.close();
}

std::string renderRankDiagram(const RankDiagram& diagram) {
  // The colors are those of map_page.css.
  const std::string style =
      ".ground{fill:#fff}.name{font:14px Helvetica,Arial,sans-serif;fill:#1b222c}"
      ".rank{font:12px Helvetica,Arial,sans-serif;fill:#56606d}.line,.stem,.group{fill:none;stroke:#1b222c}"
      ".line,.stem{stroke-width:1.2}.stem{stroke:#56606d}.group{stroke-width:5}.name.control{fill:#0b6b68;"
      "font-weight:700}.stem.control{stroke:#0b6b68;stroke-width:2}"
      "@media (prefers-color-scheme:dark){.ground{fill:#191f26}.name{fill:#e9edf1}.rank{fill:#a0abb7}"
      ".line,.group{stroke:#e9edf1}.stem{stroke:#a0abb7}.name.control{fill:#62cfc4}"
      ".stem.control{stroke:#62cfc4}}";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" +
         drawing(diagram, {{"xmlns", "http://www.w3.org/2000/svg"}}, style).str() + "\n";
}

}  // namespace estancia
