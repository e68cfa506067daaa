#include "experiments/src/zones/zone_tables_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>

#include "estancia/zones/zones.hpp"
#include "experiments/src/zones/thesis_zones.hpp"
#include "experiments/src/zones/zone_tables.hpp"

namespace estancia::experiments {
namespace {

using Best = ResultTable::Best;
using Options = ZoneTablesOptions;
using Data = ZoneTablesResults::Data;
constexpr std::string_view withinPrefix = "within ";  ///< of the measures behind M
constexpr const char* thesisCut = "0.5";
constexpr std::size_t mostLines = 28;  ///< that a chart tells apart

std::optional<double> vOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : std::optional(reading->vMeasure);
}
std::optional<double> mOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : reading->m;
}
std::optional<double> zonesOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : std::optional(static_cast<double>(reading->zones));
}

/// What the automatic cut reached. Absent where it makes more zones than the best cut may have: V-measure
/// forgives zones of single images so much that the two could not be compared.
std::optional<double> automaticV(const ZoneCell* cell) {
  const ZoneReading* reading = cell == nullptr ? nullptr : cell->find(Options::automatic);
  return reading == nullptr || reading->zones > cell->vMeasures.size() ? std::nullopt : vOf(reading);
}

/// How much it loses against the best one.
std::optional<double> costOf(const ZoneCell* cell) {
  const auto v = automaticV(cell);
  return v ? std::optional(cell->bestV() - *v) : std::nullopt;
}

class Tables {
 public:
  explicit Tables(const ZoneTablesResults& results) : results_(results) {}

  const ZoneCell* usual(std::size_t data, std::size_t model) const {
    return results_.find(data, model, ZoneOptions{}.distance, ZoneOptions{}.linkage);
  }
  const ZoneCell* thesis(std::size_t data, std::size_t model) const {
    return results_.find(data, model, ZoneOptions::thesis().distance, ZoneOptions::thesis().linkage);
  }
  static const ZoneReading* reading(const ZoneCell* cell, const std::string& cut) {
    return cell == nullptr ? nullptr : cell->find(cut);
  }
  static std::string usualName() { return ZoneOptions{}.distance + ", " + ZoneOptions{}.linkage; }

  /// The default beside Eq. 5.1, model by model.
  ResultTable overview(std::size_t d) const {
    ResultTable table{
        results_.data[d].name + ": the default beside Eq. 5.1",
        fmt::format(
            "{} images of {} rooms, {} classes. Default: {}, automatic cut; 5.1: Eq. 5.1, "
            "average linkage, τ_d 0.5, then with the automatic and the best cut. V: V-measure of zones "
            "and rooms; best: the cut of the largest V, which only who knows the rooms can choose; cost: "
            "what the automatic cut loses against it. M (Eq. 5.2): how differently classes of "
            "one room spread over the zones, 0 is alike.",
            results_.data[d].images, results_.data[d].rooms.size(), results_.data[d].classes, usualName()),
        "model",
        {{"V", 3, Best::largest},
         {"zones", 0},
         {"ARI", 3, Best::largest},
         {"purity", 3},
         {"M", 3},
         {"best V", 3, Best::largest},
         {"cost", 3, Best::smallest},
         {"5.1: V", 3, Best::largest},
         {"5.1: zones", 0},
         {"5.1: M", 3},
         {"5.1: auto V", 3, Best::largest},
         {"5.1: best V", 3, Best::largest}},
        {}};
    for (std::size_t m = 0; m < results_.models.size(); ++m) {
      const ZoneCell *ours = usual(d, m), *theirs = thesis(d, m);
      const ZoneReading *automatic = reading(ours, Options::automatic), *half = reading(theirs, thesisCut);
      ResultTable::Row row{results_.models[m], {vOf(automatic), zonesOf(automatic)}};
      row.values.push_back(automatic == nullptr ? std::nullopt : std::optional(automatic->adjustedRandIndex));
      row.values.push_back(automatic == nullptr ? std::nullopt : std::optional(automatic->purity));
      row.values.push_back(mOf(automatic));
      row.values.push_back(ours == nullptr ? std::nullopt : std::optional(ours->bestV()));
      row.values.push_back(costOf(ours));
      for (const auto& value : {vOf(half), zonesOf(half), mOf(half), automaticV(theirs)})
        row.values.push_back(value);
      row.values.push_back(theirs == nullptr ? std::nullopt : std::optional(theirs->bestV()));
      table.rows.push_back(std::move(row));
    }
    return table;
  }

  /// Distances down, linkages across.
  ResultTable byPair(
      std::size_t d, const std::string& title, const std::string& caption, Best best,
      const std::function<std::optional<double>(const std::string&, const std::string&)>& value) const {
    ResultTable table{results_.data[d].name + ": " + title, caption, "distance", {}, {}};
    for (const std::string& linkage : results_.linkages) table.columns.push_back({linkage, 3, best});
    for (const std::string& distance : results_.distances) {
      ResultTable::Row row{distance, {}};
      for (const std::string& linkage : results_.linkages) row.values.push_back(value(distance, linkage));
      table.rows.push_back(std::move(row));
    }
    return table;
  }

  void addPairs(std::size_t d, Findings& findings) const {
    const std::string& model = results_.models[0];
    const auto cell = [&](const std::string& distance, const std::string& linkage) {
      return results_.find(d, 0, distance, linkage);
    };
    findings.sections.emplace_back(byPair(
        d, fmt::format("V-measure of {}, automatic cut", model),
        "–: the two do not go together, or the cut makes so many zones that V-measure says little.",
        Best::largest,
        [&](const auto& distance, const auto& linkage) { return automaticV(cell(distance, linkage)); }));
    findings.sections.emplace_back(
        byPair(d, fmt::format("V-measure of {}, best cut", model), "With the truth in view.", Best::largest,
               [&](const auto& distance, const auto& linkage) -> std::optional<double> {
                 const ZoneCell* found = cell(distance, linkage);
                 return found == nullptr ? std::nullopt : std::optional(found->bestV());
               }));
    findings.sections.emplace_back(
        byPair(d, fmt::format("cost of the automatic cut for {}", model),
               "How much V-measure it loses against the best one.", Best::smallest,
               [&](const auto& distance, const auto& linkage) { return costOf(cell(distance, linkage)); }));
  }

  /// Table 5.2.
  std::optional<ResultTable> clusters(std::size_t d) const {
    if (thesis(d, 0) == nullptr) return std::nullopt;
    ResultTable table{
        results_.data[d].name + ": zones by τ_d, Eq. 5.1 with average linkage (Table 5.2)",
        "The rows of the thesis are of its own data, the sequences 1 and 2 of ViDRILO: other rooms and "
        "more images, to be compared in their course only.",
        "model",
        {},
        {}};
    std::vector<std::string> cuts;
    for (const std::string& cut : results_.cuts)
      if (cut != Options::automatic && cut != Options::best) cuts.push_back(cut);
    if (cuts.empty()) return std::nullopt;
    for (const std::string& cut : cuts) table.columns.push_back({"τ_d " + cut, 0});
    for (std::size_t m = 0; m < results_.models.size(); ++m) {
      ResultTable::Row row{results_.models[m], {}};
      for (const std::string& cut : cuts) row.values.push_back(zonesOf(reading(thesis(d, m), cut)));
      table.rows.push_back(std::move(row));
    }
    for (const auto& counts : thesisZoneCounts()) {
      ResultTable::Row row{counts.name, {}};
      for (const std::string& cut : cuts) {
        const auto found = std::find(thesisCuts().begin(), thesisCuts().end(), cut);
        row.values.push_back(
            found == thesisCuts().end()
                ? std::nullopt
                : std::optional(counts.zones[static_cast<std::size_t>(found - thesisCuts().begin())]));
      }
      table.rows.push_back(std::move(row));
    }
    return table;
  }

  /// Table 5.3.
  std::optional<ResultTable> within(std::size_t d, const std::string& how, const std::string& cut,
                                    const std::function<const ZoneCell*(std::size_t)>& cellOf) const {
    const ZoneReading* first = reading(cellOf(0), cut);
    if (first == nullptr || first->within.empty()) return std::nullopt;
    ResultTable table{
        fmt::format("{}: distances within categories, {} (Table 5.3)", results_.data[d].name, how),
        "How differently two classes of one room spread over the zones: 0 alike, 1 nothing in common. "
        "M weighs all pairs of classes alike.",
        "classes",
        {},
        {}};
    for (const auto& [pair, distance] : first->within) table.rows.push_back({pair, {}});
    table.rows.push_back({"M", {}});
    for (std::size_t m = 0; m < results_.models.size(); ++m) {
      const ZoneReading* here = reading(cellOf(m), cut);
      if (here == nullptr || here->within.size() != first->within.size())
        continue;  // another model saw fewer images
      table.columns.push_back({results_.models[m], 2});
      for (std::size_t r = 0; r < here->within.size(); ++r)
        table.rows[r].values.emplace_back(here->within[r].second);
      table.rows.back().values.push_back(here->m);
    }
    return table;
  }

  /// V over the number of zones.
  LineChart curves(std::size_t d, const std::string& title,
                   const std::vector<std::pair<std::string, const ZoneCell*>>& cells) const {
    LineChart chart{results_.data[d].name + ": " + title,
                    "The dot is where the automatic cut lies.",
                    "number of zones",
                    "V-measure",
                    false,
                    {},
                    {}};
    for (const auto& [name, cell] : cells) {
      if (cell == nullptr || chart.lines.size() == mostLines) continue;
      LineChart::Line line{name, cell->vMeasures, zonesOf(cell->find(Options::automatic))};
      for (std::size_t k = chart.x.size() + 1; k <= line.y.size(); ++k)
        chart.x.push_back(static_cast<double>(k));
      chart.lines.push_back(std::move(line));
    }
    return chart;
  }

  void addCurves(std::size_t d, Findings& findings) const {
    std::vector<std::pair<std::string, const ZoneCell*>> ways{{"default: " + usualName(), usual(d, 0)},
                                                              {"Eq. 5.1, average", thesis(d, 0)}};
    for (const std::string& linkage : results_.linkages)
      if (linkage != ZoneOptions{}.linkage)
        ways.emplace_back(ZoneOptions{}.distance + ", " + linkage,
                          results_.find(d, 0, ZoneOptions{}.distance, linkage));
    const auto add = [&](LineChart chart) {
      if (!chart.lines.empty()) findings.sections.emplace_back(std::move(chart));
    };
    add(curves(d, fmt::format("V-measure of {}, by distance and linkage", results_.models[0]), ways));
    if (results_.models.size() < 2) return;
    std::vector<std::pair<std::string, const ZoneCell*>> models;
    for (std::size_t m = 0; m < results_.models.size(); ++m)
      models.emplace_back(results_.models[m], usual(d, m));
    add(curves(d, "V-measure of the default, model by model", models));
  }

  std::string sentence(std::size_t d) const {
    const ZoneReading* automatic = reading(usual(d, 0), Options::automatic);
    std::string text = results_.data[d].name + ": ";
    if (automatic == nullptr) return text + "the default was not among what was compared.";
    text += fmt::format("V-measure {:.3f} with {} zones by the default (best cut {:.3f}", automatic->vMeasure,
                        automatic->zones, usual(d, 0)->bestV());
    if (const ZoneCell* theirs = thesis(d, 0))
      text += fmt::format(", Eq. 5.1 at its best {:.3f}", theirs->bestV());
    return text + ").";
  }

 private:
  const ZoneTablesResults& results_;
};

void addMatrices(const Data& data, Findings& findings) {
  for (const ClassMatrix& matrix : data.matrices)
    findings.sections.emplace_back(
        HeatTable{fmt::format("{}: distances between {}, by {} (Fig. 5.4)", data.name,
                              data.matrixNames == data.rooms ? "rooms" : "classes", matrix.distance),
                  "The mean distance of an image of the one and an image of the other, mean over the models.",
                  data.matrixNames, matrix.mean, 2});
}

}  // namespace

const ZoneReading* ZoneCell::find(const std::string& cut) const {
  const auto found =
      std::find_if(readings.begin(), readings.end(), [&](const auto& r) { return r.cut == cut; });
  return found == readings.end() ? nullptr : &*found;
}

double ZoneCell::bestV() const {
  return vMeasures.empty() ? 0 : *std::max_element(vMeasures.begin(), vMeasures.end());
}

std::vector<std::string> ZoneCell::measures() {
  return {"zones", "v_measure", "ari", "purity", "m"};
}

CellResults ZoneCell::toResults() const {
  CellResults results;
  for (const ZoneReading& reading : readings) {
    results.push_back({"zones", reading.cut, static_cast<double>(reading.zones)});
    results.push_back({"v_measure", reading.cut, reading.vMeasure});
    results.push_back({"ari", reading.cut, reading.adjustedRandIndex});
    results.push_back({"purity", reading.cut, reading.purity});
    if (reading.m) results.push_back({"m", reading.cut, *reading.m});
    for (const auto& [pair, distance] : reading.within)
      results.push_back({std::string(withinPrefix) + pair, reading.cut, distance});
  }
  for (std::size_t k = 1; k <= vMeasures.size(); ++k)
    results.push_back({"curve", std::to_string(k), vMeasures[k - 1]});
  return results;
}

ZoneCell ZoneCell::fromResults(const CellResults& results) {
  ZoneCell cell;
  for (const CellResult& result : results) {
    if (result.measure == "curve") {
      cell.vMeasures.push_back(result.value);
      continue;
    }
    if (result.measure == "zones") {
      cell.readings.emplace_back();
      cell.readings.back().cut = result.at;
    }
    if (cell.readings.empty()) continue;
    ZoneReading& reading = cell.readings.back();
    if (result.measure == "zones") reading.zones = static_cast<std::size_t>(result.value);
    if (result.measure == "v_measure") reading.vMeasure = result.value;
    if (result.measure == "ari") reading.adjustedRandIndex = result.value;
    if (result.measure == "purity") reading.purity = result.value;
    if (result.measure == "m") reading.m = result.value;
    if (result.measure.starts_with(withinPrefix))
      reading.within.emplace_back(result.measure.substr(withinPrefix.size()), result.value);
  }
  return cell;
}

const ZoneCell* ZoneTablesResults::find(std::size_t d, std::size_t model, const std::string& distance,
                                        const std::string& linkage) const {
  const auto row = std::find(distances.begin(), distances.end(), distance);
  const auto column = std::find(linkages.begin(), linkages.end(), linkage);
  if (row == distances.end() || column == linkages.end()) return nullptr;
  const auto& cell = cells[((d * models.size() + model) * distances.size() +
                            static_cast<std::size_t>(row - distances.begin())) *
                               linkages.size() +
                           static_cast<std::size_t>(column - linkages.begin())];
  return cell ? &*cell : nullptr;
}

Findings findingsOf(const ZoneTablesResults& results) {
  const Tables tables(results);
  Findings findings;
  findings.title = "Zones against rooms";
  for (std::size_t d = 0; d < results.data.size(); ++d) {
    findings.summary += (d > 0 ? " " : "") + tables.sentence(d);
    findings.facts.emplace_back(
        "Data", fmt::format("{}: {} images of {} rooms, {} classes", results.data[d].name,
                            results.data[d].images, results.data[d].rooms.size(), results.data[d].classes));
    findings.sections.emplace_back(tables.overview(d));
    tables.addCurves(d, findings);
    tables.addPairs(d, findings);
    if (auto table = tables.clusters(d)) findings.sections.emplace_back(std::move(*table));
    if (auto table = tables.within(d, "default, automatic cut", Options::automatic,
                                   [&](std::size_t m) { return tables.usual(d, m); }))
      findings.sections.emplace_back(std::move(*table));
    if (auto table = tables.within(d, "Eq. 5.1, τ_d 0.5", thesisCut,
                                   [&](std::size_t m) { return tables.thesis(d, m); }))
      findings.sections.emplace_back(std::move(*table));
    addMatrices(results.data[d], findings);
  }
  findings.sections.emplace_back(thesisWithin());
  return findings;
}

}  // namespace estancia::experiments
