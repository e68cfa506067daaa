// SPDX-License-Identifier: Apache-2.0
#include "places/model_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/label_scale.hpp"
#include "places/kmeans.hpp"
#include "places/model_choice_findings.hpp"
#include "places/posed_descriptors.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int modelChoiceVersion = 2;  // version of compute(): cells of another one are computed anew

OptionGroup declare(ModelChoiceOptions::Drive& drive) {
  OptionGroup group("sequence", "Images with poses.");
  group.add("name", &drive.name, "What to call it");
  group.add("optional", &drive.optional, "Leave out, with a note, when it is not there");
  group.add("radius", &drive.radius, "Distance of images that show the same place; 0: follows the positions")
      .unit("m")
      .range(0, 1e6);
  group.add("gap", &drive.gap, "Share of the frames before and after an image that are no answers")
      .range(0, 0.5);
  return group;
}

OptionGroup declare(ModelChoiceOptions& options) {
  OptionGroup group("model-choice", "Which model tells places apart.");
  group.add("clusters", &options.clusters, "Largest number of clusters").range(1, 1000);
  group.add("repeats", &options.repeats, "Runs of k-means that are averaged").range(1, 1000);
  group.add("seed", &options.seed, "Seed of k-means").range(0);
  group.add("thesis-tables", &options.thesisTables, "The thesis' Table 4.1 beside, of KTH-IDOL2");
  return group;
}

ModelChoiceOptions::Drive readDrive(ConfigFile& config, const toml::table& table) {
  ModelChoiceOptions::Drive drive;
  const toml::table* again = nullptr;
  auto keys = together(sourceKeys(config, drive.images, true), keysOf(config, declare(drive)));
  keys.push_back({"again", false, "", [&](auto& n) { again = &config.subtable(n); }});
  config.read(table, keys);
  if (again != nullptr) {
    drive.again = drive.images;  // equal except for the labels
    config.read(*again, sourceKeys(config, *drive.again, false));
  }
  return drive;
}

/// Only vectors that can be averaged can be clustered by k-means.
std::string readDistance(const ConfigFile& config, const toml::node& node) {
  const std::string name = config.text(node);
  std::vector<std::string> fitting;
  for (const Distance& d : baseDistances()) {
    if (d.sigmaWeighted || (d.comparison != Comparison::euclidean && d.comparison != Comparison::cosine))
      continue;
    if (d.name == name) return name;
    fitting.push_back(d.name);
  }
  config.fail(
      node, fmt::format("k-means cannot average by \"{}\"; choose among {}", name, fmt::join(fitting, ", ")));
}

/// A drive that has been opened.
struct OpenDrive {
  ModelChoiceResults::Drive told;
  double gap = 0;  // share of the frames
  std::unique_ptr<Sequence> images, again;
};

std::size_t posedFrames(const Sequence& sequence) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < sequence.size(); ++i) count += sequence.frame(i).pose ? 1 : 0;
  return count;
}

std::unique_ptr<Sequence> openPosed(const SequenceSource& source) {
  auto sequence = openImages(source);
  if (posedFrames(*sequence) < 2)
    throw Error(
        ErrorCode::insufficientData,
        fmt::format("{}: {} of {} frames have a pose, and the choice of a model compares labels with places; "
                    "give a trajectory by `poses = \"FILE\"`",
                    source.path.string(), posedFrames(*sequence), sequence->size()));
  return sequence;
}

/// The root of the variance of all positions [m].
double spreadOf(const Sequence& sequence) {
  std::vector<Position> positions;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (const auto& pose = sequence.frame(i).pose) positions.push_back({pose->x, pose->y, pose->z});
  return std::sqrt(spatialVariance(positions, std::vector<int>(positions.size())).overItems);
}

std::vector<OpenDrive> openDrives(const ModelChoiceOptions& options, std::vector<std::string>& notes) {
  std::vector<OpenDrive> drives;
  std::set<std::string> names;
  for (const auto& wanted : options.sequences) {
    if (wanted.optional && !fs::exists(wanted.images.path)) {
      notes.push_back(fmt::format("{} is not there and was left out", wanted.images.path.string()));
      continue;
    }
    OpenDrive drive;
    drive.images = openPosed(wanted.images);
    drive.told.name = wanted.name.empty() ? drive.images->name() : wanted.name;
    if (!names.insert(drive.told.name).second)
      throw Error(ErrorCode::invalidInput,
                  fmt::format("two sequences are called {}; tell them apart by `name`", drive.told.name));
    for (const std::string& warning : drive.images->warnings())
      notes.push_back(fmt::format("{}: {}", drive.told.name, warning));
    const double spread = spreadOf(*drive.images);
    if (!(spread > 0))
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: all images were taken at one place, so nothing tells the models apart",
                              wanted.images.path.string()));
    drive.told.frames = posedFrames(*drive.images);
    drive.told.radius = wanted.radius > 0 ? wanted.radius : spread / 4;
    drive.gap = wanted.gap;
    drive.told.again = wanted.again.has_value();
    if (wanted.again) drive.again = openPosed(*wanted.again);
    drives.push_back(std::move(drive));
  }
  if (drives.empty())
    throw Error(ErrorCode::insufficientData,
                "none of the sequences is there; name one of yours by [[sequence]]");
  return drives;
}

/// The sequence as labeled by one model, and its second visit.
struct Labeled {
  PosedDescriptors images;
  std::optional<PosedDescriptors> again;
};

Labeled label(const OpenDrive& drive, Labeler& labeler, const std::string& model, LabelCache* cache,
              Progress& progress, std::vector<std::string>& notes) {
  const auto of = [&](const Sequence& sequence, const std::string& which) {
    auto result =
        labelPosed(sequence, labeler, cache, progress, fmt::format("{}: labeling {}", model, which));
    if (result.unreadable > 0)
      notes.push_back(
          fmt::format("{}: {} unreadable images were left out ({})", which, result.unreadable, model));
    return result;
  };
  Labeled labeled{of(*drive.images, drive.told.name), std::nullopt};
  if (drive.again) labeled.again = of(*drive.again, drive.told.name + " again");
  // Labels that were discovered on the way have been 0 before.
  labeled.images.widen(labeler.vocabulary());
  return labeled;
}

std::size_t countDifferent(const DescriptorMatrix& vectors) {
  std::set<std::vector<float>> seen;
  for (std::size_t i = 0; i < vectors.size(); ++i) seen.emplace(vectors.row(i).begin(), vectors.row(i).end());
  return seen.size();
}

/// One cell: all k, and the places.
ModelChoiceCell compute(const Labeled& labeled, const OpenDrive& drive, const std::string& distanceName,
                        const ModelChoiceOptions& options) {
  const double radius = drive.told.radius;
  const PosedDescriptors& images = labeled.images;
  const Distance distance = getDistance(distanceName, images.parts);
  const DescriptorMatrix vectors = comparedVectors(images.descriptors, images.descriptors, distance);
  ModelChoiceCell cell;
  // More clusters than there are different descriptors would be filled with single images, which lie close
  // together by themselves: a model that always gives one answer would win.
  const std::size_t different = countDifferent(vectors);
  for (std::size_t k = 1; k <= std::min(options.clusters, vectors.size()); ++k) {
    if (k > different) {
      cell.variance.push_back(cell.variance.back());
      continue;
    }
    SpatialVariance mean;
    for (std::size_t r = 0; r < options.repeats; ++r) {
      if (interrupted()) throw Interrupted("");
      const auto found = spatialVariance(images.positions, kMeans(vectors, k, {1, options.seed + r}));
      mean.overClusters += found.overClusters / static_cast<double>(options.repeats);
      mean.overItems += found.overItems / static_cast<double>(options.repeats);
    }
    cell.variance.push_back(mean);
  }
  const PlacedImages placed{vectors, images.positions, images.frames};
  if (labeled.again) {
    const PosedDescriptors& again = *labeled.again;
    const DescriptorMatrix queries = comparedVectors(again.descriptors, images.descriptors, distance);
    cell.recognition =
        recognizePlaces({queries, again.positions, again.frames}, placed, distance.comparison, radius, 0);
  } else {
    const double gap = drive.gap * static_cast<double>(images.frames.back() + 1);
    cell.recognition = recognizePlaces(placed, placed, distance.comparison, radius,
                                       std::max<std::size_t>(1, static_cast<std::size_t>(gap)));
  }
  return cell;
}

}  // namespace

ModelChoiceOptions readModelChoice(ConfigFile& config) {
  ModelChoiceOptions options;
  /// A list of anything; one alone need not stand in [ ].
  const auto each = [&config](const toml::node& node, const auto& add) {
    if (const auto* list = node.as_array()) {
      if (list->empty())
        config.fail(node, fmt::format("`{}` is empty; leave it out for the default", config.key()));
      for (const toml::node& element : *list) add(element);
    } else {
      add(node);
    }
  };
  const toml::array* sequences = nullptr;
  config.read(
      together(keysOf(config, declare(options)),
               {
                   {"type", true, "the kind of experiment", [](auto&) {}},
                   {"models", false, "",
                    [&](auto& n) { each(n, [&](auto& e) { options.models.push_back(config.text(e)); }); }},
                   {"distances", false, "",
                    [&](auto& n) {
                      options.distances.clear();
                      each(n, [&](auto& e) { options.distances.push_back(readDistance(config, e)); });
                    }},
                   {"shown", false, "",
                    [&](auto& n) {
                      options.shown.clear();
                      each(n, [&](auto& e) {
                        options.shown.push_back(static_cast<std::size_t>(config.integer(e, 1, 1000)));
                      });
                    }},
                   {"sequence", true, "[[sequence]] names images with poses",
                    [&](auto& n) { sequences = &config.list(n); }},
               }));
  for (const toml::node& sequence : *sequences)
    options.sequences.push_back(readDrive(config, config.subtable(sequence)));
  return options;
}

GridColumns modelChoiceColumns() {
  return {{"model", "sequence", "distance"}, "k", ModelChoiceCell::measures()};
}

Findings chooseModel(const ModelChoiceOptions& options, Grid& grid, const ExperimentRun& run,
                     Progress& progress) {
  std::vector<std::string> notes;
  const auto models = modelsToCompare(options.models, run, notes);
  const auto drives = openDrives(options, notes);

  std::vector<std::string> names;
  for (const Candidate& model : models) names.push_back(model.name);
  ModelChoiceResults results{names, options.distances, {}, {}};
  for (const OpenDrive& drive : drives) results.drives.push_back(drive.told);
  results.cells.resize(models.size() * drives.size() * options.distances.size());
  std::vector<std::pair<std::string, std::string>> identities;
  for (std::size_t m = 0; m < models.size(); ++m) {  // model by model: descriptors of one at a time
    const auto labeler = loadModel(models[m].model, run.labeler);
    identities.emplace_back("Model", labeler->identity());
    std::vector<Labeled> labeled;
    std::vector<Cell> cells;
    for (const OpenDrive& drive : drives) {
      labeled.push_back(label(drive, *labeler, names[m], run.cache, progress, notes));
      const Labeled& last = labeled.back();
      for (const std::string& distance : options.distances)
        cells.push_back(
            {{names[m], drive.told.name, distance},
             sha256(fmt::format("{} {} {} {} {} {} {} {} {}", modelChoiceVersion, last.images.digest(),
                                last.again ? last.again->digest() : "", distance, options.clusters,
                                options.repeats, options.seed, drive.told.radius, drive.gap))});
    }
    const auto found = grid.run(
        cells,
        [&](std::size_t c) {
          const std::size_t s = c / options.distances.size();
          return compute(labeled[s], drives[s], options.distances[c % options.distances.size()], options)
              .toResults();
        },
        progress, fmt::format("{}: clustering", names[m]));
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::size_t s = c / options.distances.size(), d = c % options.distances.size();
      results.cells[(d * drives.size() + s) * models.size() + m] = ModelChoiceCell::fromResults(found[c]);
    }
  }

  Findings findings = findingsOf(results, options.shown);
  if (options.thesisTables) findings.sections.emplace_back(besideThesis(results));
  findings.facts.insert(findings.facts.end(), identities.begin(), identities.end());
  findings.facts.emplace_back("k-means", fmt::format("k = 1 … {}, mean of {} clusterings, seed {}",
                                                     options.clusters, options.repeats, options.seed));
  findings.notes.insert(findings.notes.begin(), notes.begin(), notes.end());
  return findings;
}

}  // namespace estancia::experiments
