// SPDX-License-Identifier: Apache-2.0
#include "zones/zone_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/zones/image_tree.hpp"
#include "estancia/zones/zones.hpp"
#include "places/room_table.hpp"
#include "runner/config_lists.hpp"
#include "zones/category_spread.hpp"
#include "zones/label_order.hpp"
#include "zones/room_classes.hpp"
#include "zones/zone_tables_findings.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int zoneTablesVersion = 1;  // version of the code below: cells of another one are computed anew
// classes of a matrix that shows classes; for more it shows the rooms
constexpr std::size_t maxClasses = 30;
constexpr std::size_t maxPairs = 40;  // classes that are reported one by one; for more their categories

/// Data as labeled by one model.
struct Labeled {
  DescriptorSequence descriptors;
  std::vector<int> rooms;           // a number for the room of each frame
  std::vector<ImageClass> classes;  // one a frame
  std::set<std::string> roomNames, classNames;
  std::string digest;
  std::size_t withoutRoom = 0;  // images that were left out
};

template <class T>
std::vector<T> chosen(const std::vector<T>& from, const std::vector<std::size_t>& which) {
  std::vector<T> some;
  for (const std::size_t i : which) some.push_back(from[i]);
  return some;
}

/// Keeps the frames whose room is known and wanted.
Labeled withRooms(const DescriptorSequence& all, const ZoneTablesOptions::Data& data) {
  std::vector<std::string> rooms, classes, marks;
  if (data.table.empty()) {
    for (const Frame& frame : all.frames) rooms.push_back(frame.room);
  } else {
    const RoomTable table(data.table, data.imageColumn, all.frames);
    rooms = table.column(data.roomColumn);
    if (!data.classColumn.empty()) classes = table.column(data.classColumn);
    if (!data.runColumn.empty()) marks = table.column(data.runColumn);
  }
  if (data.classColumn.empty()) classes = classesOfRuns(all.frames, rooms, marks, data.parts);

  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rooms.size(); ++i)
    if (!rooms[i].empty() &&
        (data.only.empty() || std::find(data.only.begin(), data.only.end(), rooms[i]) != data.only.end()))
      kept.push_back(i);
  const auto withoutRoom = static_cast<std::size_t>(std::ranges::count(rooms, std::string()));
  if (kept.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no image has a known room{}; name them by `table`, or in the images' own "
                            "rooms.csv",
                            data.name, data.only.empty() ? "" : " that is wanted by `only`"));

  Labeled labeled{
      {all.vocabulary, all.model, chosen(all.frames, kept), DescriptorMatrix(all.vocabulary.size())},
      {},
      {},
      {},
      {},
      {},
      withoutRoom};
  std::map<std::string, int> numbers;
  std::string told;
  for (const std::size_t i : kept) {
    labeled.descriptors.descriptors.append(all.descriptors.row(i));
    labeled.rooms.push_back(numbers.emplace(rooms[i], static_cast<int>(numbers.size())).first->second);
    labeled.classes.push_back({rooms[i], classes[i]});
    labeled.roomNames.insert(rooms[i]);
    if (!classes[i].empty()) labeled.classNames.insert(classes[i]);
    told += rooms[i] + '\n' + classes[i] + '\n';
  }
  for (const LabelPart& part : all.vocabulary.layout().parts)
    told += fmt::format("{} {}\n", part.size, part.weight);
  const auto& values = labeled.descriptors.descriptors.values();
  labeled.digest =
      sha256(sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)}) + told);
  return labeled;
}

ZoneReading readingOf(const Labeled& labeled, const std::string& cut, const std::vector<int>& zones) {
  const Agreement agreement = measureAgreement(labeled.rooms, zones);
  ZoneReading reading{cut,
                      std::set<int>(zones.begin(), zones.end()).size(),
                      agreement.vMeasure,
                      agreement.adjustedRandIndex,
                      agreement.purity,
                      std::nullopt,
                      {}};
  const CategorySpread spread = measureCategories(zones, labeled.classes);
  reading.m = spread.m;
  if (spread.pairs.size() <= maxPairs) {
    for (const ClassPair& pair : spread.pairs)
      reading.within.emplace_back(pair.first + " · " + pair.second, pair.distance);
    return reading;
  }
  std::map<std::string, std::vector<ClassPair>> categories;
  for (const ClassPair& pair : spread.pairs) categories[pair.category].push_back(pair);
  for (const auto& [category, pairs] : categories)
    reading.within.emplace_back(category, *meanDistance(pairs));
  return reading;
}

/// What does not depend on the linkage.
struct Compared {
  CondensedDistances distances;
  NearestItems neighbors;
};

/// Compares the images once for all linkages that want the same. Cells come in order, so that few are
/// remembered.
class SharedComparisons {
 public:
  explicit SharedComparisons(int threads) : threads_(threads) {}

  std::shared_ptr<const Compared> of(const Labeled& labeled, const std::string& distance,
                                     const std::string& linkage) {
    const Key key{&labeled, distance, comparisonFor(getDistance(distance), getLinkage(linkage))};
    const std::lock_guard lock(mutex_);  // the others wait: it takes all threads
    for (const auto& [known, compared] : recent_)
      if (known == key) return compared;
    Progress silent;
    ZoneOptions how;
    how.distance = distance;
    how.linkage = linkage;
    how.threads = threads_;
    CondensedDistances distances = compareImages(labeled.descriptors, how, silent);
    NearestItems neighbors = findNeighbors(distances, neighborsForCut(distances.items()));
    recent_.emplace_front(key,
                          std::make_shared<Compared>(Compared{std::move(distances), std::move(neighbors)}));
    if (recent_.size() > most) recent_.pop_back();
    return recent_.front().second;
  }

 private:
  static constexpr std::size_t most = 4;
  using Key = std::tuple<const Labeled*, std::string, Comparison>;
  int threads_;
  std::mutex mutex_;
  std::deque<std::pair<Key, std::shared_ptr<const Compared>>> recent_;
};

/// One dendrogram and all its cuts.
ZoneCell compute(const Labeled& labeled, const Compared& compared, const std::string& linkage,
                 const ZoneTablesOptions& options) {
  CondensedDistances distances(compared.distances.items());  // linking them takes them apart
  std::copy(compared.distances.values().begin(), compared.distances.values().end(),
            distances.values().begin());
  const Dendrogram tree = link(std::move(distances), getLinkage(linkage));

  ZoneCell cell;
  for (std::size_t k = 1; k <= std::min(options.maxZones, tree.leaves()); ++k)
    cell.vMeasures.push_back(measureAgreement(labeled.rooms, tree.cutInto(k)).vMeasure);
  for (const std::string& cut : options.cuts) {
    if (interrupted()) throw Interrupted("");
    std::vector<int> zones;
    if (cut == ZoneTablesOptions::automatic)
      zones = tree.cutAt(suggestCut(tree, compared.neighbors).distance);
    else if (cut == ZoneTablesOptions::best)
      zones = tree.cutInto(
          static_cast<std::size_t>(std::max_element(cell.vMeasures.begin(), cell.vMeasures.end()) -
                                   cell.vMeasures.begin()) +
          1);
    else
      zones = tree.cutAt(std::strtod(cut.c_str(), nullptr));  // denormals, too, which stod refuses
    cell.readings.push_back(readingOf(labeled, cut, zones));
  }
  return cell;
}

/// The rows of Fig. 5.4: classes where they are few, else rooms.
std::vector<std::string> matrixClasses(const Labeled& labeled) {
  std::vector<std::string> names;
  const bool few = labeled.classNames.size() <= maxClasses && labeled.classNames.size() > 1;
  for (const ImageClass& image : labeled.classes) names.push_back(few ? image.name : image.category);
  return names;
}

bool fits(const std::string& distance, const std::string& linkage) {
  try {
    comparisonFor(getDistance(distance), getLinkage(linkage));
    return true;
  } catch (const Error&) {
    return false;
  }
}

std::vector<std::string> distancesBetweenImages() {
  std::vector<std::string> names;
  for (const Distance& distance : baseDistances())
    if (!distance.sigmaWeighted) names.push_back(distance.name);
  return names;
}

std::vector<std::string> linkageNames() {
  std::vector<std::string> names;
  for (const Choice& linkage : linkages()) names.push_back(linkage.name);
  return names;
}

/// The models of the command line, else those of the configuration as far as they are there.
std::vector<Candidate> chooseModels(const ZoneTablesOptions& options, const ExperimentRun& run,
                                    std::vector<std::string>& notes) {
  std::vector<std::string> models = options.models;
  if (run.models.empty())
    addWhatIsThere(
        options.optionalModels,
        [&](const std::string& model) {
          std::vector<std::string> unused;
          modelsToCompare({model}, run, unused);
          models.push_back(model);
        },
        notes);
  return modelsToCompare(models, run, notes);
}

/// data × models, model by model: one network at a time.
std::vector<std::vector<Labeled>> labelData(const std::vector<const ZoneTablesOptions::Data*>& data,
                                            const std::vector<Candidate>& models, const ExperimentRun& run,
                                            Progress& progress, Findings& told) {
  std::vector<std::unique_ptr<Sequence>> sequences;
  for (const ZoneTablesOptions::Data* one : data) {
    sequences.push_back(openImages(one->images));
    for (const std::string& warning : sequences.back()->warnings())
      told.notes.push_back(fmt::format("{}: {}", one->name, warning));
  }
  std::vector<std::vector<Labeled>> labeled(data.size());
  for (const Candidate& model : models) {
    const auto labeler = loadModel(model.model, run.labeler);
    told.facts.emplace_back("Model", labeler->identity());
    for (std::size_t d = 0; d < data.size(); ++d) {
      const DescriptorSequence sequence =
          labelAll(*sequences[d], *labeler, fmt::format("{}: labeling {}", model.name, sequences[d]->name()),
                   {.cache = run.cache}, progress);
      if (sequence.frames.size() < sequences[d]->size())
        told.notes.push_back(fmt::format("{}: {} unreadable images were left out ({})", data[d]->name,
                                         sequences[d]->size() - sequence.frames.size(), model.name));
      labeled[d].push_back(
          withRooms(inLabelOrder(sequence, data[d]->labelOrder, data[d]->orderSeed), *data[d]));
      if (const std::size_t unknown = labeled[d].back().withoutRoom; unknown > 0 && labeled[d].size() == 1)
        told.notes.push_back(fmt::format("{}: the rooms of {} of {} images are unknown; these were left out",
                                         data[d]->name, unknown, sequence.frames.size()));
    }
  }
  return labeled;
}

/// The mean over the models of what each has at the same place of the matrix, of one measure.
std::vector<double> meanMatrix(std::span<const CellResults> models, const std::string& measure,
                               std::size_t size) {
  std::vector<double> sums(size, NAN);
  for (const CellResults& model : models)
    for (const CellResult& value : model) {
      if (value.measure != measure) continue;
      double& sum = sums.at(std::stoul(value.at));
      sum = (std::isnan(sum) ? 0 : sum) + value.value / static_cast<double>(models.size());
    }
  return sums;
}

/// The mean over the data, where all have the same classes.
std::vector<ClassMatrix> meanOverData(const std::vector<ZoneTablesResults::Data>& data) {
  if (data.size() < 2 ||
      std::ranges::any_of(data, [&](const auto& one) { return one.matrixNames != data[0].matrixNames; }))
    return {};
  std::vector<ClassMatrix> means = data[0].matrices;
  for (std::size_t k = 0; k < means.size(); ++k)
    for (std::size_t i = 0; i < means[k].values.size(); ++i) {
      double& sum = means[k].values[i] = 0;
      for (const auto& one : data) sum += one.matrices[k].values[i] / static_cast<double>(data.size());
    }
  return means;
}

/// Fills in the matrices of classes: the mean over the models.
void compareClasses(const std::vector<std::vector<Labeled>>& labeled, const ExperimentRun& run,
                    Progress& progress, ZoneTablesResults& results) {
  std::vector<std::string> shown;
  for (const std::string& distance : {ZoneOptions{}.distance, ZoneOptions::thesis().distance})
    if (std::find(results.distances.begin(), results.distances.end(), distance) != results.distances.end())
      shown.push_back(distance);
  Grid grid(run.folder, {{"data", "model", "distance"}, "", {}}, run.labeler.threads, run.distribution);
  std::vector<Cell> cells;
  for (std::size_t d = 0; d < labeled.size(); ++d)
    for (std::size_t m = 0; m < results.models.size(); ++m)
      for (const std::string& distance : shown)
        cells.push_back(
            {{results.data[d].name, results.models[m], distance},
             sha256(fmt::format("classes and their means {} {}", zoneTablesVersion, labeled[d][m].digest))});
  const std::size_t perData = results.models.size() * shown.size();
  const auto found = grid.run(
      cells,
      [&](std::size_t c) {
        const Labeled& here = labeled[c / perData][c % perData / shown.size()];
        Progress silent;
        ZoneOptions how;
        how.distance = shown[c % shown.size()];
        how.linkage = ZoneOptions::thesis().linkage;  // it takes every distance as it is
        how.threads = 1;
        const ClassDistances distances = classDistances(here.descriptors, matrixClasses(here), how, silent);
        CellResults values;
        for (std::size_t i = 0; i < distances.mean.size(); ++i)
          if (std::isfinite(distances.mean[i]))
            values.push_back({"mean", std::to_string(i), distances.mean[i]});
        for (std::size_t i = 0; i < distances.ofMeans.size(); ++i)
          values.push_back({"of_means", std::to_string(i), distances.ofMeans[i]});
        return values;
      },
      progress, "distances of classes");
  for (std::size_t d = 0; d < labeled.size(); ++d) {
    auto& data = results.data[d];
    const auto names = matrixClasses(labeled[d][0]);
    const std::set<std::string> rows(names.begin(), names.end());
    data.matrixNames.assign(rows.begin(), rows.end());
    const std::size_t size = rows.size() * rows.size();
    for (std::size_t s = 0; s < shown.size(); ++s) {
      std::vector<CellResults> models;
      for (std::size_t m = 0; m < results.models.size(); ++m)
        models.push_back(found[d * perData + m * shown.size() + s]);
      if (!getDistance(shown[s]).standardized)
        data.matrices.push_back({shown[s], true, meanMatrix(models, "of_means", size)});
      data.matrices.push_back({shown[s], false, meanMatrix(models, "mean", size)});
    }
  }
  results.matrices = meanOverData(results.data);
}

/// Fig. 5.5 of the first model, by Eq. 5.1.
void spreadClasses(const std::vector<std::vector<Labeled>>& labeled, const ExperimentRun& run,
                   ZoneTablesResults& results) {
  ZoneOptions how = ZoneOptions::thesis();
  how.threads = run.labeler.threads;
  Progress silent;
  for (std::size_t d = 0; d < labeled.size(); ++d) {
    if (results.find(d, 0, how.distance, how.linkage) == nullptr) continue;
    const Labeled& first = labeled[d][0];
    const Dendrogram tree = link(compareImages(first.descriptors, how, silent), getLinkage(how.linkage));
    results.data[d].histograms = classHistograms(
        tree.cutAt(0.5), matrixClasses(first),
        {fmt::format("{}: percent of the images of a class in each zone (Fig. 5.5)", results.data[d].name),
         results.models[0] + ", Eq. 5.1, average linkage, τ_d 0.5; zones from the largest on.",
         "class",
         {},
         {}});
  }
}

/// The data that is there.
std::vector<const ZoneTablesOptions::Data*> presentData(const ZoneTablesOptions& options,
                                                        std::vector<std::string>& notes) {
  std::vector<const ZoneTablesOptions::Data*> data;
  for (const ZoneTablesOptions::Data& one : options.data) {
    if (one.optional && !fs::exists(one.images.path))
      notes.push_back(fmt::format("{} is not there and was left out", one.images.path.string()));
    else
      data.push_back(&one);
  }
  if (data.empty())
    throw Error(ErrorCode::insufficientData, "none of the data is there; name yours by [[data]]");
  return data;
}

/// Fills in the cells: all dendrograms and their cuts.
void findCells(const ZoneTablesOptions& options, const std::vector<std::vector<Labeled>>& labeled, Grid& grid,
               const ExperimentRun& run, Progress& progress, ZoneTablesResults& results,
               std::vector<std::string>& notes) {
  struct Place {
    const Labeled* labeled;
    const std::string *distance, *linkage;
    std::size_t index;  // in results.cells
  };
  std::vector<Cell> cells;
  std::vector<Place> places;
  std::set<std::string> unfit;
  for (std::size_t d = 0; d < labeled.size(); ++d)
    for (std::size_t m = 0; m < results.models.size(); ++m)
      for (const std::string& distance : results.distances)
        for (const std::string& linkage : results.linkages) {
          results.cells.emplace_back();
          if (!fits(distance, linkage)) {
            unfit.insert(fmt::format("{} with {}", linkage, distance));
            continue;
          }
          places.push_back({&labeled[d][m], &distance, &linkage, results.cells.size() - 1});
          cells.push_back({{results.data[d].name, results.models[m], distance, linkage},
                           sha256(fmt::format("{} {} {} {}", zoneTablesVersion, labeled[d][m].digest,
                                              fmt::join(options.cuts, " "), options.maxZones))});
        }
  if (!unfit.empty())
    notes.push_back(fmt::format("These do not go together and were left out: {}.", fmt::join(unfit, ", ")));
  SharedComparisons comparisons(run.labeler.threads);
  const auto found = grid.run(
      cells,
      [&](std::size_t c) {
        const Place& place = places[c];
        const auto compared = comparisons.of(*place.labeled, *place.distance, *place.linkage);
        return compute(*place.labeled, *compared, *place.linkage, options).toResults();
      },
      progress, "finding zones");
  for (std::size_t c = 0; c < cells.size(); ++c)
    results.cells[places[c].index] = ZoneCell::fromResults(found[c]);
}

std::string readCut(const ConfigFile& config, const toml::node& node) {
  if (node.is_number()) return fmt::format("{}", config.number(node, 0, 1e9));
  return config.choice(node, std::vector<std::pair<std::string, std::string>>{
                                 {ZoneTablesOptions::automatic, ZoneTablesOptions::automatic},
                                 {ZoneTablesOptions::best, ZoneTablesOptions::best}});
}

OptionGroup declare(ZoneTablesOptions::Data& data) {
  OptionGroup group("data", "Images with rooms.");
  group.add("name", &data.name, "What to call them");
  group.add("image-column", &data.imageColumn, "Column of the images' names");
  group.add("room-column", &data.roomColumn, "Column of the rooms");
  group.add("class-column", &data.classColumn, "Column of the classes; none: runs of images in one room");
  group.add("run-column", &data.runColumn, "Column whose values part runs");
  group.add("parts", &data.parts, "Parts that each run is cut into").range(1, 1000);
  group.add("label-order", &data.labelOrder, "Order of the labels, for cumulated distances")
      .choices(labelOrders());
  group.add("order-seed", &data.orderSeed, "Of shuffled labels");
  group.add("optional", &data.optional, "Leave out, with a note, when they are not there");
  return group;
}

OptionGroup declare(ZoneTablesOptions& options) {
  OptionGroup group("zones", "Zones by model, distance, linkage and cut.");
  group.add("max-zones", &options.maxZones, "Most zones of the best cut").range(1, 10000);
  group.add("each-cut", &options.eachCut,
            "Tables of all cuts of all data in place of those of distances by linkages");
  group.add("thesis-tables", &options.thesisTables, "The thesis' Tables 5.2 and 5.3 beside, of ViDRILO");
  return group;
}

ZoneTablesOptions::Data readData(ConfigFile& config, const toml::table& table) {
  ZoneTablesOptions::Data data;
  auto keys =
      together(sourceKeys(config, data.images, true), requiring("name", keysOf(config, declare(data))));
  keys.push_back({"table", false, "the CSV of rooms", [&](auto& n) { data.table = config.anywhere(n); }});
  keys.push_back({"only", false, "only these rooms", [&](auto& n) {
                    for (const auto& element : config.list(n)) data.only.push_back(config.text(element));
                  }});
  config.read(table, keys);
  const toml::node* column = firstOf(table, {"image_column", "room_column", "class_column", "run_column"});
  if (column != nullptr && data.table.empty())
    config.fail(*column, "a column of which table? name it by `table`");
  return data;
}

}  // namespace

ZoneTablesOptions readZoneTables(ConfigFile& config) {
  ZoneTablesOptions options;
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  const toml::array* data = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "the models to compare", each(config, options.models, text)},
       {"optional_models", false, "and these where they are", each(config, options.optionalModels, text)},
       {"distances", false, "", each(config, options.distances, oneOf(config, distancesBetweenImages()))},
       {"linkages", false, "", each(config, options.linkages, oneOf(config, linkageNames()))},
       {"cuts", false, "",
        each(config, options.cuts, [&config](const toml::node& node) { return readCut(config, node); })},
       {"data", true, "[[data]] names images with rooms", [&](auto& n) { data = &config.list(n); }}}));
  for (const toml::node& one : *data) options.data.push_back(readData(config, config.subtable(one)));
  return options;
}

GridColumns zoneTablesColumns() {
  return {{"data", "model", "distance", "linkage"}, "cut", ZoneCell::measures()};
}

Findings compareZones(const ZoneTablesOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress) {
  Findings told;
  const auto models = chooseModels(options, run, told.notes);
  const auto data = presentData(options, told.notes);
  const auto labeled = labelData(data, models, run, progress, told);

  ZoneTablesResults results;
  for (const Candidate& model : models) results.models.push_back(model.name);
  for (std::size_t d = 0; d < data.size(); ++d) {
    const Labeled& first = labeled[d][0];
    results.data.push_back({data[d]->name,
                            first.rooms.size(),
                            {first.roomNames.begin(), first.roomNames.end()},
                            first.classNames.size(),
                            {},
                            {}});
  }
  results.distances = options.distances.empty() ? distancesBetweenImages() : options.distances;
  results.linkages = options.linkages.empty() ? linkageNames() : options.linkages;
  results.cuts = options.cuts;
  results.thesisTables = options.thesisTables;
  results.eachCut = options.eachCut;
  findCells(options, labeled, grid, run, progress, results, told.notes);
  compareClasses(labeled, run, progress, results);
  spreadClasses(labeled, run, results);

  Findings findings = findingsOf(results);
  findings.facts.insert(findings.facts.end(), told.facts.begin(), told.facts.end());
  findings.notes.insert(findings.notes.begin(), told.notes.begin(), told.notes.end());
  return findings;
}

}  // namespace estancia::experiments
