// SPDX-License-Identifier: Apache-2.0
#include "places/maps_findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "findings/pivot.hpp"
#include "findings/thesis.hpp"

namespace estancia::experiments {
namespace {

constexpr auto higher = ResultTable::Best::largest;  // is better

const std::vector<std::pair<std::string, ResultTable::Column>> mapColumns{
    {"nodes", {"nodes", 0}},
    {"links", {"links", 0}},
    {"v_measure", {"V-measure", 3, higher}},
    {"ari", {"ARI", 3, higher}},
    {"purity", {"purity", 3, higher}},
    {"edge_precision", {"edge precision", 3, higher}},
    {"edge_recall", {"edge recall", 3, higher}},
    {"score_a", {"A", 3}},
    {"score_b", {"B", 3}},
    {"score_c", {"C", 3}},
    {"score_d", {"D", 3}},
    {"score_e", {"E", 3}},
    {"score", {"score", 2, higher}}};

const std::vector<std::pair<std::string, ResultTable::Column>> authorsColumns{
    {"nodes", {"author: nodes", 0}},
    {"links", {"author: links", 0}},
    {"v_measure", {"author: V", 3}},
    {"purity", {"author: purity", 3}},
    {"score", {"author: score", 2}}};

constexpr const char* scoreCaption =
    "Score: the thesis author's 20·(A+B+C+D+E): A purity of the rooms, B few links, C short links, D compact "
    "nodes, E spread nodes.";

MapGround groundOf(const MapsOptions::Drive& drive, std::set<std::string>& rooms) {
  const auto images = openImages(drive.itself.images);
  MapGround ground;
  if (!drive.floorPlan.empty())
    ground.floorPlan =
        drive.extent ? readFloorPlan(drive.floorPlan, *drive.extent) : readHomeFloorPlan(drive.floorPlan);
  std::vector<std::optional<Pose>> poses;
  for (std::size_t i = 0; i < images->size(); ++i) {
    poses.push_back(images->frame(i).pose);
    if (!images->frame(i).room.empty()) rooms.insert(images->frame(i).room);
  }
  ground.path = report::projectPath(poses, /*fromAbove=*/ground.floorPlan.has_value());
  return ground;
}

/// The settings of one preset: its own thresholds, then the sweep.
struct Sweep {
  std::string preset;
  std::vector<std::size_t> settings;
};

std::vector<Sweep> sweepsOf(const std::vector<MapSetting>& settings) {
  std::vector<Sweep> sweeps;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    const auto known = std::ranges::find(sweeps, settings[s].preset, &Sweep::preset);
    if (known != sweeps.end())
      known->settings.push_back(s);
    else
      sweeps.push_back({settings[s].preset, {s}});
  }
  return sweeps;
}

class MapsWriter {
 public:
  MapsWriter(const MapsOptions& options, const DriveResults& results,
             const std::map<std::string, MapGround>& grounds)
      : options_(options), results_(results) {
    if (options.thesisTables) authors_ = readThesisTable(lextomapSweepsCsv, 3);
    for (const std::string& name : results.drives) grounds_.push_back(&grounds.at(name));
  }

  /// All sequences with one setting.
  void addSetting(std::size_t model, std::size_t setting) {
    std::vector<std::pair<std::string, std::pair<CellResults, CellResults>>> rows;
    for (std::size_t d = 0; d < results_.drives.size(); ++d)
      rows.emplace_back(results_.drives[d], std::pair(results_.of(model, d, setting), authorsOf(d, setting)));
    addTable(fmt::format("Maps{}", titleEnd(model, setting)), "sequence", rows);
    Images images{fmt::format("Maps side by side{}", titleEnd(model, setting)),
                  "Nodes at the mean of their images, as large as they have images, in the color of their "
                  "room; the driven path pale (thesis Fig. 4.6).",
                  {}};
    for (std::size_t d = 0; d < results_.drives.size(); ++d)
      addMap(images, model, d, setting, results_.drives[d], /*isWide=*/true);
    addImages(std::move(images));
  }

  /// Who is found in the reference's map, with each preset's own thresholds.
  void addLocalization(std::size_t model, const std::vector<Sweep>& sweeps) {
    std::vector<ResultTable::Column> columns{{"images", 0}};
    for (const Sweep& sweep : sweeps) columns.push_back({"preset " + sweep.preset + " [%]", 1});
    const ThesisTable printed = readThesisTable(lextomapLocalizationCsv, 1);
    if (options_.thesisTables) columns.push_back({"author [%]", 1});
    bool isAny = false;
    ResultTable table = pivot(
        {fmt::format("Images found in the map of {}{}", options_.reference, modelEnd(model)),
         "The share of the images whose nearest node by words is the node nearest by meters, as the thesis "
         "author counted it; a node lies where its image nearest to their median was taken.",
         "sequence",
         std::move(columns),
         {}},
        results_.drives, [&](std::size_t d, std::size_t c) -> CellValue {
          if (c == 0) return static_cast<double>(grounds_[d]->path.points.size());
          if (c > sweeps.size()) return percent(printed.find({results_.drives[d]}, "found"));
          const auto share = valueOf(results_.of(model, d, sweeps[c - 1].settings[0]), "found");
          isAny = isAny || share;
          return percent(share);
        });
    if (isAny) findings.sections.emplace_back(std::move(table));
  }

  void addSweep(std::size_t model, const Sweep& sweep) {
    if (sweep.settings.size() < 2) return;
    for (const char* measure : {"nodes", "v_measure", "score"}) addCurves(model, sweep, measure);
    for (std::size_t d = 0; d < results_.drives.size(); ++d) {
      const std::string& name = results_.drives[d];
      std::vector<std::pair<std::string, std::pair<CellResults, CellResults>>> rows;
      Images images{
          fmt::format("{}, preset {}: maps over the thresholds{}", name, sweep.preset, modelEnd(model)),
          "τ_join, τ_revisit below each.",
          {}};
      for (const std::size_t s : sweep.settings) {
        const auto of = options_.settings[s].coordinates();
        const std::string thresholds = of[1] + ", " + of[2];
        rows.emplace_back(thresholds, std::pair(results_.of(model, d, s), authorsOf(d, s)));
        addMap(images, model, d, s, thresholds, /*isWide=*/false);
      }
      addTable(fmt::format("{}, preset {}{}", name, sweep.preset, modelEnd(model)), "τ_join, τ_revisit",
               rows);
      addImages(std::move(images));
    }
  }

  /// Over all sequences and models.
  double meanV(std::size_t setting) const {
    std::vector<CellResults> cells;
    results_.each([&](std::size_t m, std::size_t d) { cells.push_back(results_.of(m, d, setting)); });
    return meanOver(cells, "v_measure");
  }

  Findings findings;

 private:
  std::string modelEnd(std::size_t model) const {
    return results_.models.size() > 1 ? ", " + results_.models[model] : "";
  }
  std::string thresholdsOf(std::size_t setting) const {
    const auto of = options_.settings[setting].coordinates();
    return fmt::format("τ_join {}, τ_revisit {}", of[1], of[2]);
  }
  std::string titleEnd(std::size_t model, std::size_t setting) const {
    return fmt::format(", preset {} ({}){}", options_.settings[setting].preset, thresholdsOf(setting),
                       modelEnd(model));
  }
  static CellValue percent(const CellValue& share) { return share ? CellValue(100 * *share) : share; }

  /// His numbers of this sequence with these thresholds: his program is the preset `thesis`.
  CellResults authorsOf(std::size_t drive, std::size_t setting) const {
    CellResults results;
    const auto of = options_.settings[setting].coordinates();
    if (of[0] != "thesis") return results;
    for (const auto& [measure, column] : mapColumns)
      if (const auto value = authors_.find({results_.drives[drive], of[1], of[2]}, measure))
        results.push_back({measure, "", *value});
    return results;
  }

  /// Rows of ours and the author's.
  void addTable(const std::string& title, const std::string& rowsAre,
                const std::vector<std::pair<std::string, std::pair<CellResults, CellResults>>>& rows) {
    using Pair = std::pair<CellResults, CellResults>;
    std::vector<Measure<Pair>> measures;
    const auto add = [&](const auto& columns, CellResults Pair::*whose) {
      std::vector<CellResults> cells;
      for (const auto& row : rows) cells.push_back(row.second.*whose);
      for (const auto& measure : measuresIn(cells, columns))
        measures.push_back(
            {measure.column, [of = measure.of, whose](const Pair& row) { return of(row.*whose); }});
    };
    add(mapColumns, &Pair::first);
    add(authorsColumns, &Pair::second);
    ResultTable table = pivot<Pair>({title, scoreCaption, rowsAre, {}, {}}, rows, measures);
    if (rowsAre == "sequence")  // none of them is better
      for (ResultTable::Column& column : table.columns) column.best = ResultTable::Best::none;
    findings.sections.emplace_back(std::move(table));
  }

  void addMap(Images& images, std::size_t model, std::size_t drive, std::size_t setting,
              const std::string& name, bool isWide) const {
    const CellResults& cell = results_.of(model, drive, setting);
    auto image = drawMap(cell, *grounds_[drive], isWide);
    if (image.empty()) return;
    images.images.push_back(
        {std::move(image), fmt::format("{}: {} nodes, {} links", name, valueOf(cell, "nodes").value_or(0),
                                       valueOf(cell, "links").value_or(0))});
  }

  void addImages(Images images) {
    if (!images.images.empty()) findings.sections.emplace_back(std::move(images));
  }

  /// The mean over the sequences; NaN where one lacks it.
  static double meanOver(const std::vector<CellResults>& cells, const std::string& measure) {
    std::vector<double> values;
    for (const CellResults& cell : cells)
      values.push_back(valueOf(cell, measure).value_or(std::numeric_limits<double>::quiet_NaN()));
    return meanOf(values);
  }

  /// A curve for each τ_join over τ_revisit (over τ_join where that is the only one swept).
  void addCurves(std::size_t model, const Sweep& sweep, const std::string& measure) {
    std::map<std::optional<double>, std::map<double, std::size_t>> lines;  // τ_join → τ_revisit → setting
    std::map<double, std::size_t> alone;                                   // τ_join → setting
    for (const std::size_t s : sweep.settings) {
      const MapperOptions& mapper = options_.settings[s].mapper;
      if (mapper.tauRevisit) lines[mapper.tauJoin][*mapper.tauRevisit] = s;
      if (mapper.tauJoin) alone[*mapper.tauJoin] = s;
    }
    std::erase_if(lines, [](const auto& line) { return line.second.size() < 2; });
    const bool overJoin = lines.empty();
    if (overJoin) lines[std::nullopt] = alone;
    std::set<double> x;  // where all curves are known
    for (const auto& [at, setting] : lines.begin()->second)
      if (std::ranges::all_of(lines, [at = at](const auto& line) { return line.second.contains(at); }))
        x.insert(at);
    if (x.size() < 2) return;
    const auto column = std::ranges::find(mapColumns, measure, [](const auto& c) { return c.first; });
    LineChart chart{.title = fmt::format("{} over the thresholds, preset {}{}", column->second.name,
                                         sweep.preset, modelEnd(model)),
                    .caption = fmt::format("Mean over {} sequences.", results_.drives.size()),
                    .xName = overJoin ? "τ_join" : "τ_revisit",
                    .yName = column->second.name,
                    .x = {x.begin(), x.end()},
                    .lines = {},
                    .closeUp = true};
    for (const auto& [join, settings] : lines) {
      const std::string name = overJoin ? "ours" : join ? fmt::format("τ_join {}", *join) : "τ_join auto";
      addCurve(chart, name, measure, settings, [&](std::size_t s) {
        std::vector<CellResults> cells;
        for (std::size_t d = 0; d < results_.drives.size(); ++d) cells.push_back(results_.of(model, d, s));
        return cells;
      });
      addCurve(chart, "author, " + name, measure, settings, [&](std::size_t s) {
        std::vector<CellResults> cells;
        for (std::size_t d = 0; d < results_.drives.size(); ++d)
          if (CellResults cell = authorsOf(d, s); !cell.empty()) cells.push_back(std::move(cell));
        return cells;
      });
    }
    if (!chart.lines.empty()) findings.sections.emplace_back(std::move(chart));
  }

  void addCurve(LineChart& chart, const std::string& name, const std::string& measure,
                const std::map<double, std::size_t>& settings, const auto& cellsOf) const {
    LineChart::Line line{name, {}};
    for (const double at : chart.x) line.y.push_back(meanOver(cellsOf(settings.at(at)), measure));
    if (std::ranges::any_of(line.y, [](double y) { return std::isfinite(y); }))
      chart.lines.push_back(std::move(line));
  }

  const MapsOptions& options_;
  const DriveResults& results_;
  ThesisTable authors_;
  std::vector<const MapGround*> grounds_;
};

}  // namespace

std::map<std::string, MapGround> groundsOf(const MapsOptions& options) {
  std::map<std::string, MapGround> grounds;
  std::set<std::string> rooms;
  for (const auto& drive : options.sequences)
    if (!drive.itself.optional || std::filesystem::exists(drive.itself.images.path))
      grounds.emplace(drive.itself.name, groundOf(drive, rooms));
  for (auto& [name, ground] : grounds) ground.rooms.assign(rooms.begin(), rooms.end());
  return grounds;
}

Findings mapsFindings(const MapsOptions& options, const DriveResults& results,
                      const std::map<std::string, MapGround>& grounds) {
  const std::vector<Sweep> sweeps = sweepsOf(options.settings);
  MapsWriter writer(options, results, grounds);
  writer.findings.title = "Maps side by side";
  for (std::size_t m = 0; m < results.models.size(); ++m) {
    for (const Sweep& sweep : sweeps) writer.addSetting(m, sweep.settings[0]);
    writer.addLocalization(m, sweeps);
    for (const Sweep& sweep : sweeps) writer.addSweep(m, sweep);
  }
  writer.findings.summary = fmt::format("{} sequences, each mapped with {} settings.", results.drives.size(),
                                        options.settings.size());
  for (const Sweep& sweep : sweeps)
    if (const double v = writer.meanV(sweep.settings[0]); std::isfinite(v))
      writer.findings.summary += fmt::format(
          " With the thresholds of the preset {} their mean V-measure is {:.3f}.", sweep.preset, v);
  return std::move(writer.findings);
}

}  // namespace estancia::experiments
