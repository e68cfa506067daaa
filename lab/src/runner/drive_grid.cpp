// SPDX-License-Identifier: Apache-2.0
#include "runner/drive_grid.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/digest.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace estancia::experiments {

const LabeledDrive& LabeledDrives::of(const SequenceSource& source) {
  const std::string digest = digestOf(source);
  if (const auto known = labeled_.find(digest); known != labeled_.end()) return known->second;
  std::shared_ptr<const Sequence> images = openImages(source);
  const std::string what = fmt::format("labeling {}", images->name());
  DescriptorSequence recording = labelAll(*images, labeler_, what, {.cache = run_.cache}, progress_);
  return labeled_.emplace(digest, LabeledDrive{std::move(images), std::move(recording)}).first->second;
}

Findings studyDrives(const DriveStudy& study,
                     const std::function<Findings(const DriveResults& results)>& findingsOf, Grid& grid,
                     const ExperimentRun& run, Progress& progress) {
  std::vector<std::string> notes;
  const auto models = modelsToCompare(study.models, run, notes);
  const auto drives = presentDrives(study.drives, notes);
  const std::size_t variants = study.variants.size();
  std::vector<std::string> digests;
  digests.reserve(drives.size());
  for (const NamedDrive& drive : drives) {
    digests.push_back(digestOf(drive.images));
    const auto images = openImages(drive.images);
    for (const std::string& warning : images->warnings())
      notes.push_back(fmt::format("{}: {}", drive.name, warning));
  }
  DriveResults results{namesIn(models), namesIn(drives), study.variants};
  std::vector<std::pair<std::string, std::string>> identities;
  for (const Candidate& model : models) {
    const auto labeler = loadModel(model.model, run.labeler);
    identities.emplace_back("Model", labeler->identity());
    std::vector<Cell> cells;
    for (std::size_t d = 0; d < drives.size(); ++d)
      for (std::size_t v = 0; v < variants; ++v) {
        Cell cell{
            {model.name, drives[d].name},
            sha256(fmt::format("{} {} {}", labeler->cacheKey(), digests[d], study.inputs(drives[d], v)))};
        if (study.coordinates)
          for (const std::string& coordinate : study.coordinates(v)) cell.coordinates.push_back(coordinate);
        else if (!study.variants[v].empty())
          cell.coordinates.push_back(study.variants[v]);
        cells.push_back(std::move(cell));
      }
    LabeledDrives labeled(*labeler, run, progress);
    const auto found = grid.run(
        cells, [&](std::size_t c) { return study.compute(labeled, drives[c / variants], c % variants); },
        progress, model.name);
    results.cells.insert(results.cells.end(), found.begin(), found.end());
  }
  Findings findings = findingsOf(results);
  findings.facts = std::move(identities);
  findings.notes = std::move(notes);
  return findings;
}

std::vector<Measure<CellResults>> measuresIn(
    const std::vector<CellResults>& cells,
    const std::vector<std::pair<std::string, ResultTable::Column>>& columns) {
  std::vector<Measure<CellResults>> measures;
  for (const auto& [name, column] : columns)
    if (std::ranges::any_of(cells,
                            [&, name = name](const auto& cell) { return valueOf(cell, name).has_value(); }))
      measures.push_back({column, [name = name](const CellResults& cell) { return valueOf(cell, name); }});
  return measures;
}

}  // namespace estancia::experiments
