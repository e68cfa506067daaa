// SPDX-License-Identifier: Apache-2.0
#include "zones/zone_tables_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "estancia/stats/linkage.hpp"
#include "estancia/zones/zones.hpp"
#include "findings/pivot.hpp"
#include "findings/thesis.hpp"
#include "zones/zone_tables.hpp"

namespace estancia::experiments {
namespace {

using Best = ResultTable::Best;
constexpr std::string_view withinPrefix = "within ";  // prefix of the measures after M
constexpr const char* thesisCut = "0.5";
constexpr std::size_t maxLines = 28;  // lines that a chart can distinguish

using Value = CellValue;

Value vOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : Value(reading->vMeasure);
}
Value zonesOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : Value(static_cast<double>(reading->zones));
}
Value mOf(const ZoneReading* reading) {
  return reading == nullptr ? std::nullopt : reading->m;
}
Value bestVOf(const ZoneCell* cell) {
  return cell == nullptr ? std::nullopt : Value(cell->bestV());
}
const ZoneReading* readingOf(const ZoneCell* cell, const std::string& cut) {
  return cell == nullptr ? nullptr : cell->find(cut);
}

/// What the automatic cut reached. Absent where it makes more zones than the best cut may have: V-measure
/// forgives zones of single images so much that the two could not be compared.
Value automaticV(const ZoneCell* cell) {
  const ZoneReading* reading = readingOf(cell, ZoneTablesOptions::automatic);
  return reading == nullptr || reading->zones > cell->vMeasures.size() ? std::nullopt : vOf(reading);
}

/// How much it loses against the best one.
Value costOf(const ZoneCell* cell) {
  const auto v = automaticV(cell);
  return v ? Value(cell->bestV() - *v) : std::nullopt;
}

std::string defaultName() {
  return ZoneOptions{}.distance + ", " + ZoneOptions{}.linkage;
}

/// The tables and charts of some data.
class Tables {
 public:
  Tables(const ZoneTablesResults& results, std::size_t data)
      : results_(results), d_(data), data_(results.data[data]) {}

  const ZoneCell* usual(std::size_t model) const {
    return results_.find(d_, model, ZoneOptions{}.distance, ZoneOptions{}.linkage);
  }
  const ZoneCell* thesis(std::size_t model) const {
    return results_.find(d_, model, ZoneOptions::thesis().distance, ZoneOptions::thesis().linkage);
  }

  /// The default beside Eq. 5.1, model by model.
  ResultTable overview() const {
    struct Model {
      const ZoneCell *ours, *theirs;
      const ZoneReading* automatic() const { return readingOf(ours, ZoneTablesOptions::automatic); }
      const ZoneReading* half() const { return readingOf(theirs, thesisCut); }
    };
    std::vector<std::pair<std::string, Model>> models;
    for (std::size_t m = 0; m < results_.models.size(); ++m)
      models.emplace_back(results_.models[m], Model{usual(m), thesis(m)});
    const auto ofAutomatic = [](double ZoneReading::*value) {
      return [value](const Model& model) -> Value {
        return model.automatic() == nullptr ? std::nullopt : Value(model.automatic()->*value);
      };
    };
    return pivot<Model>(
        {data_.name + ": the default beside Eq. 5.1",
         fmt::format(
             "{} images of {} rooms, {} classes. Default: {}, automatic cut; 5.1: Eq. 5.1, "
             "average linkage, τ_d 0.5, then with the automatic and the best cut. V: V-measure of zones "
             "and rooms; best: the cut of the largest V, which only who knows the rooms can choose; cost: "
             "what the automatic cut loses against it. M (Eq. 5.2): how differently classes of "
             "one room spread over the zones, 0 is alike.",
             data_.images, data_.rooms.size(), data_.classes, defaultName()),
         "model",
         {},
         {}},
        models,
        {{{"V", 3, Best::largest}, [](auto& model) { return vOf(model.automatic()); }},
         {{"zones", 0}, [](auto& model) { return zonesOf(model.automatic()); }},
         {{"ARI", 3, Best::largest}, ofAutomatic(&ZoneReading::adjustedRandIndex)},
         {{"purity", 3}, ofAutomatic(&ZoneReading::purity)},
         {{"M", 3}, [](auto& model) { return mOf(model.automatic()); }},
         {{"best V", 3, Best::largest}, [](auto& model) { return bestVOf(model.ours); }},
         {{"cost", 3, Best::smallest}, [](auto& model) { return costOf(model.ours); }},
         {{"5.1: V", 3, Best::largest}, [](auto& model) { return vOf(model.half()); }},
         {{"5.1: zones", 0}, [](auto& model) { return zonesOf(model.half()); }},
         {{"5.1: M", 3}, [](auto& model) { return mOf(model.half()); }},
         {{"5.1: auto V", 3, Best::largest}, [](auto& model) { return automaticV(model.theirs); }},
         {{"5.1: best V", 3, Best::largest}, [](auto& model) { return bestVOf(model.theirs); }}});
  }

  /// Pairs of the first model: distances down, linkages across.
  void addPairs(Findings& findings) const {
    const auto add = [&](const std::string& title, const std::string& caption, Best best,
                         Value (*value)(const ZoneCell*)) {
      findings.sections.emplace_back(pivot(
          {data_.name + ": " + title, caption, "distance", columnsOf(results_.linkages, 3, best), {}},
          results_.distances, [&](std::size_t distance, std::size_t linkage) {
            return value(results_.find(d_, 0, results_.distances[distance], results_.linkages[linkage]));
          }));
    };
    const std::string& model = results_.models[0];
    add(fmt::format("V-measure of {}, automatic cut", model),
        "–: the two do not go together, or the cut makes so many zones that V-measure says little.",
        Best::largest, automaticV);
    add(fmt::format("V-measure of {}, best cut", model), "With the truth in view.", Best::largest, bestVOf);
    add(fmt::format("cost of the automatic cut for {}", model),
        "How much V-measure it loses against the best one.", Best::smallest, costOf);
  }

  /// Table 5.2.
  void addCounts(Findings& findings) const {
    std::vector<std::string> cuts, names;
    for (const std::string& cut : results_.cuts)
      if (cut != ZoneTablesOptions::automatic && cut != ZoneTablesOptions::best) cuts.push_back(cut);
    if (cuts.empty() || thesis(0) == nullptr) return;
    for (const std::string& cut : cuts) names.push_back("τ_d " + cut);
    ResultTable table = pivot(
        {data_.name + ": zones by τ_d, Eq. 5.1 with average linkage (Table 5.2)",
         results_.thesisTables ? "The rows of the thesis are of its own data, the sequences 1 and 2 of "
                                 "ViDRILO: other rooms and more images, to be compared in their course only."
                               : "",
         "model",
         columnsOf(names, 0),
         {}},
        results_.models,
        [&](std::size_t model, std::size_t cut) { return zonesOf(readingOf(thesis(model), cuts[cut])); });
    if (!results_.thesisTables) {
      findings.sections.emplace_back(std::move(table));
      return;
    }
    const ThesisTable printed = readThesisTable(thesisZonesCountsCsv, 2);
    std::vector<std::string> rows;
    for (const auto& row : printed.rows)
      rows.push_back(fmt::format("(thesis, {}: {})", row.keys[0], row.keys[1]));
    findings.sections.emplace_back(pivot(std::move(table), rows, [&](std::size_t row, std::size_t cut) {
      return printed.find(printed.rows[row].keys, cuts[cut]);
    }));
  }

  /// Table 5.3; `cellOf` chooses the cell of a model.
  void addWithin(const std::string& how, const std::string& cut,
                 const ZoneCell* (Tables::*cellOf)(std::size_t) const, Findings& findings) const {
    const ZoneReading* first = readingOf((this->*cellOf)(0), cut);
    if (first == nullptr || first->within.empty()) return;
    std::vector<std::string> models, rows;
    std::vector<const ZoneReading*> readings;
    for (std::size_t m = 0; m < results_.models.size(); ++m) {
      const ZoneReading* here = readingOf((this->*cellOf)(m), cut);
      if (here == nullptr || here->within.size() != first->within.size())
        continue;  // another model saw fewer images
      models.push_back(results_.models[m]);
      readings.push_back(here);
    }
    for (const auto& [pair, distance] : first->within) rows.push_back(pair);
    rows.emplace_back("M");
    findings.sections.emplace_back(
        pivot({fmt::format("{}: distances within categories, {} (Table 5.3)", data_.name, how),
               "How differently two classes of one room spread over the zones: 0 alike, 1 nothing in common. "
               "M weighs all pairs of classes alike.",
               "classes",
               columnsOf(models, 2),
               {}},
              rows, [&](std::size_t row, std::size_t column) {
                const ZoneReading& reading = *readings[column];
                return row < reading.within.size() ? Value(reading.within[row].second) : reading.m;
              }));
  }

  void addCurves(Findings& findings) const {
    const ZoneOptions common;
    std::vector<std::pair<std::string, const ZoneCell*>> ways{{"default: " + defaultName(), usual(0)},
                                                              {"Eq. 5.1, average", thesis(0)}};
    for (const std::string& linkage : results_.linkages)
      if (linkage != common.linkage)
        ways.emplace_back(common.distance + ", " + linkage, results_.find(d_, 0, common.distance, linkage));
    addCurve(fmt::format("V-measure of {}, by distance and linkage", results_.models[0]), ways, findings);
    if (results_.models.size() < 2) return;
    std::vector<std::pair<std::string, const ZoneCell*>> models;
    for (std::size_t m = 0; m < results_.models.size(); ++m)
      models.emplace_back(results_.models[m], usual(m));
    addCurve("V-measure of the default, model by model", models, findings);
  }

  std::string sentence() const {
    const ZoneReading* automatic = readingOf(usual(0), ZoneTablesOptions::automatic);
    std::string text = data_.name + ": ";
    if (automatic == nullptr) {
      double best = 0;
      for (const std::string& distance : results_.distances)
        for (const std::string& linkage : results_.linkages)
          best = std::max(best, bestVOf(results_.find(d_, 0, distance, linkage)).value_or(0));
      return text + fmt::format("V-measure {:.3f} at its best.", best);
    }
    text += fmt::format("V-measure {:.3f} with {} zones by the default (best cut {:.3f}", automatic->vMeasure,
                        automatic->zones, usual(0)->bestV());
    if (const ZoneCell* theirs = thesis(0))
      text += fmt::format(", Eq. 5.1 at its best {:.3f}", theirs->bestV());
    return text + ").";
  }

 private:
  /// V over the number of zones.
  void addCurve(const std::string& title, const std::vector<std::pair<std::string, const ZoneCell*>>& cells,
                Findings& findings) const {
    LineChart chart{data_.name + ": " + title,
                    "The dot is where the automatic cut lies.",
                    "number of zones",
                    "V-measure",
                    false,
                    {},
                    {}};
    for (const auto& [name, cell] : cells) {
      if (cell == nullptr || chart.lines.size() == maxLines) continue;
      LineChart::Line line{name, cell->vMeasures, zonesOf(cell->find(ZoneTablesOptions::automatic))};
      for (std::size_t k = chart.x.size() + 1; k <= line.y.size(); ++k)
        chart.x.push_back(static_cast<double>(k));
      chart.lines.push_back(std::move(line));
    }
    if (!chart.lines.empty()) findings.sections.emplace_back(std::move(chart));
  }

  const ZoneTablesResults& results_;
  std::size_t d_;
  const ZoneTablesResults::Data& data_;
};

/// `rows`: what stands in the rows, "classes".
void addMatrices(const std::string& title, const std::string& rows, const std::vector<std::string>& names,
                 const std::vector<ClassMatrix>& matrices, Findings& findings) {
  for (const ClassMatrix& matrix : matrices)
    findings.sections.emplace_back(HeatTable{
        matrix.ofMeans
            ? fmt::format("{}: distances between mean descriptors of {}, by {} (Fig. 5.4)", title, rows,
                          matrix.distance)
            : fmt::format("{}: mean distances between images of {}, by {}", title, rows, matrix.distance),
        matrix.ofMeans ? "Mean over the models."
                       : "Of an image of the one and an image of the other; mean over the models.",
        names, matrix.values, 2});
}

/// A row each cell, a column each cut; data are not compared, so that no cell is the best one.
void addEachCut(const ZoneTablesResults& results, const std::string& title, int decimals,
                Value (*value)(const ZoneReading*), Findings& findings) {
  std::vector<std::string> rows;
  std::vector<const ZoneCell*> cells;
  for (std::size_t d = 0; d < results.data.size(); ++d)
    for (const std::string& model : results.models)
      for (const std::string& distance : results.distances)
        for (const std::string& linkage : results.linkages) {
          const auto m = static_cast<std::size_t>(&model - results.models.data());
          const ZoneCell* cell = results.find(d, m, distance, linkage);
          if (cell == nullptr) continue;
          rows.push_back(fmt::format("{}{}: {}, {}", results.data[d].name,
                                     results.models.size() == 1 ? "" : ", " + model, distance, linkage));
          cells.push_back(cell);
        }
  std::vector<std::string> cuts;
  for (const std::string& cut : results.cuts)
    cuts.push_back(cut == ZoneTablesOptions::automatic || cut == ZoneTablesOptions::best ? cut
                                                                                         : "τ_d " + cut);
  findings.sections.emplace_back(
      pivot({title, "", "data", columnsOf(cuts, decimals), {}}, rows,
            [&](std::size_t row, std::size_t cut) { return value(cells[row]->find(results.cuts[cut])); }));
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
  Findings findings;
  findings.title = "Zones against rooms";
  for (std::size_t d = 0; d < results.data.size(); ++d) {
    const Tables tables(results, d);
    const ZoneTablesResults::Data& data = results.data[d];
    findings.summary += (d > 0 ? " " : "") + tables.sentence();
    findings.facts.emplace_back("Data", fmt::format("{}: {} images of {} rooms, {} classes", data.name,
                                                    data.images, data.rooms.size(), data.classes));
    if (tables.usual(0) != nullptr || tables.thesis(0) != nullptr)
      findings.sections.emplace_back(tables.overview());
    tables.addCurves(findings);
    if (!results.eachCut) tables.addPairs(findings);
    tables.addCounts(findings);
    tables.addWithin("default, automatic cut", ZoneTablesOptions::automatic, &Tables::usual, findings);
    tables.addWithin("Eq. 5.1, τ_d 0.5", thesisCut, &Tables::thesis, findings);
    if (data.histograms) findings.sections.emplace_back(*data.histograms);
    addMatrices(data.name, data.matrixNames == data.rooms ? "rooms" : "classes", data.matrixNames,
                data.matrices, findings);
  }
  if (!results.matrices.empty())
    addMatrices("all data", "classes", results.data[0].matrixNames, results.matrices, findings);
  if (results.eachCut) {
    addEachCut(results, "V-measure by cut", 3, vOf, findings);
    addEachCut(results, "zones by cut", 0, zonesOf, findings);
  }
  if (!results.thesisTables) return findings;
  findings.sections.emplace_back(
      readThesisTable(thesisZonesWithinCsv, 1)
          .resultTable(
              {"The thesis: distances within categories, Eq. 5.1, τ_d 0.5 (Table 5.3)",
               "Another data set: the sequences 1 and 2 of ViDRILO, averaged. CR corridor, EA elevator "
               "area, PO professor office.",
               "classes",
               {},
               {}}));
  return findings;
}

}  // namespace estancia::experiments
