// SPDX-License-Identifier: Apache-2.0
#include "features/feature_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "features/fab_map.hpp"
#include "places/mapped_drive.hpp"
#include "places/place_orders.hpp"
#include "runner/config_lists.hpp"
#include "runner/drive_grid.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: cells of another one are computed anew
constexpr int featureStudyVersion = 2;
constexpr std::size_t smoothing = 20;            // frames of lookahead
constexpr const char* byClassifier = "svm-rbf";  // stands where drives have their distance

using DrivePair = LocalizationErrorsOptions::Drive;

/// A descriptor that is compared.
struct Source {
  std::string name;
  std::unique_ptr<Labeler> labeler;
  /// How classifiers compare its values; absent: as words.
  std::optional<PartKind> kind;
};

std::vector<cv::Mat> localFeaturesOf(const SequenceSource& source, LocalFeature feature,
                                     const ExperimentRun& run, Progress& progress) {
  const auto images = openImages(source);
  std::vector<cv::Mat> features(images->size());
  progress.begin(fmt::format("learning visual words from {}", images->name()), images->size());
  inParallel(images->size(), run.labeler.threads, progress, "stopped while learning visual words",
             [&](std::size_t i) { features[i] = localFeatures(feature, images->image(i)); });
  progress.end();
  return features;
}

/// Where visual words are learned from; absent where there are no such images.
std::optional<VocabularyImages> vocabularyImages(const FeatureStudyOptions& options, const ExperimentRun& run,
                                                 Progress& progress) {
  const auto& vocabulary = options.vocabulary;
  if (!vocabulary || (vocabulary->optional && !std::filesystem::exists(vocabulary->images.path)))
    return std::nullopt;
  return VocabularyImages{digestOf(vocabulary->images), [&vocabulary, &run, &progress](LocalFeature feature) {
                            return localFeaturesOf(vocabulary->images, feature, run, progress);
                          }};
}

/// Whether what needs visual words is left out.
bool lacksWords(const std::string& type, const FeatureStudyOptions& options,
                const std::optional<VocabularyImages>& images, std::vector<std::string>& notes) {
  if (!options.vocabulary)
    fail(ErrorCode::invalidInput, "{} needs images to learn visual words from; name some by [vocabulary]",
         type);
  if (!images)
    notes.push_back(
        fmt::format("{} is not there, so {} was left out", options.vocabulary->images.path.string(), type));
  return !images;
}

std::vector<Source> openSources(const FeatureStudyOptions& options,
                                const std::optional<VocabularyImages>& images, const ExperimentRun& run,
                                std::vector<std::string>& notes) {
  std::vector<Source> sources;
  for (const Candidate& model : modelsToCompare(options.models, run, notes))
    sources.push_back({model.name, loadModel(model.model, run.labeler), {}});
  for (const auto& layer : options.layers) {
    ModelSpec spec = readModelSpec(getModelFolder(layer.model));
    spec.name = layer.name;
    spec.labels.clear();
    spec.softmax = false;
    spec.output = layer.output;
    spec.features = layer.features;
    sources.push_back({layer.name, loadModel(spec, run.labeler), {}});
  }
  for (const std::string& type : options.features)
    if (!needsVocabulary(type) || !lacksWords(type, options, images, notes))
      sources.push_back({type, makeFeatureLabeler(type, images.value_or(VocabularyImages{}), options.sizes),
                         kindOfFeature(type)});
  std::set<std::string> names;
  for (const Source& source : sources)
    if (!names.insert(source.name).second)
      fail(ErrorCode::invalidInput, "two descriptors are called {}; rename one", source.name);
  return sources;
}

/// The room that each mapped frame sees, by the frame's name; read once a drive, as it takes all depth
/// images.
class RoomsSeen {
 public:
  std::vector<std::string> of(const DrivePair& drive, const std::vector<Frame>& frames) {
    if (!io::hasHomeTruth(drive.mapped.images.path)) return {};
    auto& rooms = byDrive_[drive.mapped.name];
    if (rooms.empty()) {
      const auto images = openImages(drive.mapped.images);
      const auto seen = io::roomsSeen(io::readHomeTruth(drive.mapped.images.path), *images);
      for (std::size_t i = 0; i < images->size(); ++i) rooms[images->frame(i).name] = seen[i];
    }
    std::vector<std::string> seen;
    for (const Frame& frame : frames) seen.push_back(rooms[frame.name]);
    return seen;
  }

 private:
  std::map<std::string, std::map<std::string, std::string>> byDrive_;
};

void add(CellResults& results, const char* measure, const std::optional<double>& value) {
  if (value) results.push_back({measure, "", *value});
}

void addMap(CellResults& results, const MapQuality& quality) {
  results.push_back({"frames", "", static_cast<double>(quality.frames)});
  results.push_back({"nodes", "", static_cast<double>(quality.nodes)});
  if (quality.rooms) {
    results.push_back({"v_measure", "", quality.rooms->vMeasure});
    results.push_back({"ari", "", quality.rooms->adjustedRandIndex});
    results.push_back({"purity", "", quality.rooms->purity});
  }
  if (quality.roomsSeen) results.push_back({"seen_v_measure", "", quality.roomsSeen->vMeasure});
  add(results, "edge_precision", quality.edgePrecision);
  add(results, "edge_recall", quality.edgeRecall);
  add(results, "original", quality.original.total);
}

/// By positions or a list of true answers where there are any, else by rooms.
std::optional<double> rightOf(const Accuracy& accuracy) {
  return accuracy.recall ? accuracy.recall : accuracy.room;
}

/// The mean agreement of places and rooms over random orders of the stays in rooms.
void addOrders(CellResults& results, const DescriptorSequence& recording, const MapperOptions& options,
               std::size_t orders) {
  if (orders == 0 || !valueOf(results, "v_measure")) return;
  double sum = 0;
  for (const auto& tour : ordersOfStays(recording.frames, orders))
    sum += mapRooms(recording, tour, options).vMeasure;
  results.push_back({"orders_v_measure", "", sum / static_cast<double>(orders)});
}

CellResults mapAndFind(const DrivePair& drive, const std::string& distance, std::size_t orders,
                       LabeledDrives& labeled, RoomsSeen& roomsSeen) {
  const DescriptorSequence& recording = labeled.of(drive.mapped.images).recording;
  const DescriptorSequence& queries = labeled.of(drive.again).recording;
  MapperOptions options;
  options.distance = distance;
  const ScratchMap file(withoutPoses(recording), labeled.run().folder / ".map.estancia", options);
  const auto map =
      std::make_shared<const LocalizerMap>(readLocalizerMap(file.path(), LocalizerOptions{}.maxImages));
  TopologicalMap judged = map->map;
  for (std::size_t i = 0; i < judged.frames.size(); ++i) judged.frames[i].pose = recording.frames[i].pose;
  CellResults results;
  addMap(results, evaluate(judged, roomsSeen.of(drive, recording.frames)));
  addOrders(results, recording, options, orders);
  const AdmissibleImages truth = drive.truth.empty() ? AdmissibleImages{} : readAdmissibleImages(drive.truth);
  const auto unposed = withoutPoses(queries);
  const auto accuracyOf = [&](std::size_t lookahead) {
    return measureAnswers(judged, queries.frames, locate(unposed, map, lookahead), truth);
  };
  const LocalizationAccuracy causal = accuracyOf(0);
  add(results, "one_image", rightOf(causal.nearestImage));
  add(results, "filtered", rightOf(causal.belief));
  add(results, "smoothed", rightOf(accuracyOf(smoothing).belief));
  return results;
}

CellResults findByFabMap(const FabMap& model, const DrivePair& drive, LabeledDrives& labeled) {
  const DescriptorSequence& recording = labeled.of(drive.mapped.images).recording;
  const DescriptorSequence& queries = labeled.of(drive.again).recording;
  TopologicalMap judged{recording.vocabulary};  // one node: FAB-MAP has none
  judged.nodes.push_back({0, recording.frames.size()});
  for (const Frame& frame : recording.frames) judged.frames.push_back({frame});
  std::vector<Localization> answers;
  double unknown = 0;
  for (const FabMap::Answer& answer : model.recognize(queries.descriptors, recording.descriptors)) {
    Localization& one = answers.emplace_back();
    one.nearestImage = answer.byImage;
    one.beliefImage = answer.byAll;
    unknown += answer.unknown > 0.5 ? 1 : 0;
  }
  const LocalizationAccuracy accuracy =
      measureAnswers(judged, queries.frames, answers,
                     drive.truth.empty() ? AdmissibleImages{} : readAdmissibleImages(drive.truth));
  CellResults results{{"frames", "", static_cast<double>(recording.frames.size())}};
  add(results, "one_image", rightOf(accuracy.nearestImage));
  add(results, "filtered", rightOf(accuracy.belief));
  results.push_back({"unknown", "", unknown / static_cast<double>(answers.size())});
  return results;
}

Features featuresFor(const Source& source, const DescriptorSequence& recording) {
  Features features = featuresOf(recording);
  if (source.kind)
    for (DescriptorPart& part : features.parts) part.kind = *source.kind;
  return features;
}

CellResults classifyRooms(const FeatureStudyOptions::Rooms& rooms, const Source& source,
                          LabeledDrives& labeled) {
  const Features learned = featuresFor(source, labeled.of(rooms.learned.images).recording);
  const Features asked = featuresFor(source, labeled.of(rooms.asked).recording);
  ClassifierOptions options;
  options.type = byClassifier;
  const RoomClassifier classifier = trainRoomClassifier(learned, options);
  const DescriptorMatrix probabilities = classifier.predict(asked);
  std::size_t right = 0;
  for (std::size_t i = 0; i < asked.frames.size(); ++i) {
    const DescriptorView row = probabilities.row(i);
    const auto best = static_cast<std::size_t>(std::ranges::max_element(row) - row.begin());
    right += classifier.rooms()[best] == asked.frames[i].room ? 1 : 0;
  }
  const auto all = static_cast<double>(asked.frames.size());
  return {{"frames", "", all}, {"accuracy", "", static_cast<double>(right) / all}};
}

/// What is there of the drives and rooms.
struct Tasks {
  std::vector<DrivePair> drives;
  std::vector<FeatureStudyOptions::Rooms> rooms;
  std::vector<std::string> digests;  // digests of all of them
  std::size_t orders;

  Tasks(const FeatureStudyOptions& options, std::vector<std::string>& notes) : orders(options.orders) {
    std::vector<NamedDrive> named;
    for (const auto& drive : options.drives) named.push_back(drive.mapped);
    for (const auto& set : options.rooms) named.push_back(set.learned);
    for (const NamedDrive& present : presentDrives(named, notes)) {
      const auto isIt = [&](const NamedDrive& drive) { return drive.name == present.name; };
      for (const auto& drive : options.drives)
        if (isIt(drive.mapped)) {
          drives.push_back(drive);
          digests.push_back(digestOf(drive.mapped.images) + digestOf(drive.again) +
                            (drive.truth.empty() ? "" : sha256OfFile(drive.truth)) +
                            digestOfHome(drive.mapped.images.path));
        }
      for (const auto& set : options.rooms)
        if (isIt(set.learned)) {
          rooms.push_back(set);
          digests.push_back(digestOf(set.learned.images) + digestOf(set.asked));
        }
    }
    if (drives.empty())
      throw Error(ErrorCode::insufficientData, "none of the drives is there; name one of yours by [[drive]]");
  }

 private:
  /// What the rooms seen depend on, beside the images.
  static std::string digestOfHome(const std::filesystem::path& folder) {
    return io::hasHomeTruth(folder) ? sha256OfFile(folder / "home.json") : "";
  }
};

/// The cells of one descriptor, task by task.
std::vector<std::vector<CellResults>> study(const Source& source, const Tasks& tasks,
                                            const std::vector<std::string>& distances, RoomsSeen& roomsSeen,
                                            Grid& grid, const ExperimentRun& run, Progress& progress) {
  std::vector<Cell> cells;
  const auto addCell = [&](const std::string& task, const std::string& by, const std::string& inputs) {
    cells.push_back({{source.name, task, by},
                     sha256(fmt::format("{} {} {} {}", featureStudyVersion, source.labeler->cacheKey(),
                                        source.kind ? static_cast<int>(*source.kind) : -1, inputs))});
  };
  std::size_t next = 0;
  for (const DrivePair& drive : tasks.drives) {
    const std::string inputs = fmt::format("{} {}", tasks.digests[next++], tasks.orders);
    for (const std::string& distance : distances) addCell(drive.mapped.name, distance, inputs);
  }
  for (const auto& rooms : tasks.rooms) addCell(rooms.learned.name, byClassifier, tasks.digests[next++]);
  LabeledDrives labeled(*source.labeler, run, progress);
  const std::size_t ofDrives = tasks.drives.size() * distances.size();
  const auto found = grid.run(
      cells,
      [&](std::size_t c) {
        if (c >= ofDrives) return classifyRooms(tasks.rooms[c - ofDrives], source, labeled);
        return mapAndFind(tasks.drives[c / distances.size()], distances[c % distances.size()], tasks.orders,
                          labeled, roomsSeen);
      },
      progress, source.name);
  std::vector<std::vector<CellResults>> byTask;
  for (std::size_t c = 0; c < found.size(); ++c) {
    if (c >= ofDrives || c % distances.size() == 0) byTask.emplace_back();
    byTask.back().push_back(found[c]);
  }
  return byTask;
}

/// Each drive found by FAB-MAP, a cell a drive.
std::vector<CellResults> recognize(const std::string& name, Labeler& shownWords,
                                   const SequenceSource& vocabulary, const Tasks& tasks, Grid& grid,
                                   const ExperimentRun& run, Progress& progress) {
  const std::string learned = digestOf(vocabulary);
  std::vector<Cell> cells;
  for (std::size_t d = 0; d < tasks.drives.size(); ++d)
    cells.push_back({{name, tasks.drives[d].mapped.name, "likelihood"},
                     sha256(fmt::format("{} {} {} {}", featureStudyVersion, shownWords.cacheKey(), learned,
                                        tasks.digests[d]))});
  LabeledDrives labeled(shownWords, run, progress);
  std::optional<FabMap> model;  // learned when a cell is missing
  return grid.run(
      cells,
      [&](std::size_t d) {
        if (!model) model.emplace(labeled.of(vocabulary).recording.descriptors);
        return findByFabMap(*model, tasks.drives[d], labeled);
      },
      progress, name);
}

FeatureStudyOptions::Layer readLayer(ConfigFile& config, const toml::table& table) {
  FeatureStudyOptions::Layer layer;
  config.read(
      table,
      {{"name", true, "what to call it", [&](auto& n) { layer.name = config.text(n); }},
       {"model", true, "whose layer", [&](auto& n) { layer.model = config.text(n); }},
       {"output", true, "the value's name in the network", [&](auto& n) { layer.output = config.text(n); }},
       {"features", true, "how many numbers it has",
        [&](auto& n) { layer.features = static_cast<std::size_t>(config.integer(n, 2, 1'000'000)); }}});
  return layer;
}

ShownLayer readShownLayer(ConfigFile& config, const toml::table& table) {
  ShownLayer layer;
  config.read(
      table,
      {{"model", true, "whose layer", [&](auto& n) { layer.model = config.text(n); }},
       {"output", true, "the value's name in the network", [&](auto& n) { layer.output = config.text(n); }},
       {"channels", true, "how many square channels it has",
        [&](auto& n) { layer.channels = static_cast<std::size_t>(config.integer(n, 1, 1'000'000)); }}});
  return layer;
}

FeatureStudyOptions::Rooms readRooms(ConfigFile& config, const toml::table& table) {
  FeatureStudyOptions::Rooms rooms;
  const toml::table* asked = nullptr;
  rooms.learned = readNamedDrive(
      config, table,
      {{"test", true, "the images to ask about", [&](auto& n) { asked = &config.subtable(n); }}});
  rooms.asked = rooms.learned.images;  // equal except for the labels
  config.read(*asked, sourceKeys(config, rooms.asked, false));
  return rooms;
}

NamedDrive readVocabulary(ConfigFile& config, const toml::table& table, VocabularySizes& sizes) {
  const auto count = [&config](std::size_t& to) {
    return [&config, &to](auto& n) { to = static_cast<std::size_t>(config.integer(n, 1, 1'000'000)); };
  };
  return readNamedDrive(config, table,
                        {{"words", false, "words of bags of words", count(sizes.words)},
                         {"vlad_words", false, "words of VLAD", count(sizes.vladWords)},
                         {"seed", false, "of k-means", [&](auto& n) {
                            sizes.seed = static_cast<std::uint64_t>(config.integer(n, 0, 1'000'000'000));
                          }}});
}

}  // namespace

FeatureStudyOptions readFeatureStudy(ConfigFile& config) {
  FeatureStudyOptions options;
  options.features = namesIn(featureTypes());
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  const toml::array *layers = nullptr, *shown = nullptr, *drives = nullptr, *rooms = nullptr;
  const toml::table* vocabulary = nullptr;
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "networks whose words are compared", each(config, options.models, text)},
       {"features", false, "descriptors without words; []: none",
        [&](auto& n) {
          if (config.list(n).empty()) return options.features.clear();
          each(config, options.features, oneOf(config, featureTypes()))(n);
        }},
       {"fab_map", false, "local features whose words FAB-MAP finds drives by",
        each(config, options.fabMaps, oneOf(config, std::vector<std::string>{"orb", "sift"}))},
       {"distances", false, "how they are compared",
        each(config, options.distances, oneOf(config, distances()))},
       {"orders", false, "random orders of each drive's stays in rooms; 0: none",
        [&](auto& n) { options.orders = static_cast<std::size_t>(config.integer(n, 0, 1000)); }},
       {"layer", false, "inner layers of networks", [&](auto& n) { layers = &config.list(n); }},
       {"shown_layer", false, "layers that are drawn of an image", [&](auto& n) { shown = &config.list(n); }},
       {"vocabulary", false, "images to learn visual words from",
        [&](auto& n) { vocabulary = &config.subtable(n); }},
       {"drive", true, "[[drive]] names a drive to map, [drive.again] the one to find",
        [&](auto& n) { drives = &config.list(n); }},
       {"rooms", false, "rooms to learn, [rooms.test] to ask", [&](auto& n) { rooms = &config.list(n); }}});
  if (layers != nullptr)
    for (const toml::node& node : *layers) options.layers.push_back(readLayer(config, config.subtable(node)));
  if (shown != nullptr)
    for (const toml::node& node : *shown)
      options.shownLayers.push_back(readShownLayer(config, config.subtable(node)));
  if (vocabulary != nullptr) options.vocabulary = readVocabulary(config, *vocabulary, options.sizes);
  for (const toml::node& node : *drives)
    options.drives.push_back(readDrivePair(config, config.subtable(node)));
  if (rooms != nullptr)
    for (const toml::node& node : *rooms) options.rooms.push_back(readRooms(config, config.subtable(node)));
  return options;
}

GridColumns featureStudyColumns() {
  GridColumns columns{{"descriptor", "task", "distance"}, "", {"frames"}};
  for (const auto& measure : featureMeasures()) columns.measures.push_back(measure.first);
  columns.measures.emplace_back("accuracy");
  return columns;
}

Findings compareFeatures(const FeatureStudyOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress) {
  std::vector<std::string> notes;
  const Tasks tasks(options, notes);
  const auto learned = vocabularyImages(options, run, progress);
  const auto sources = openSources(options, learned, run, notes);
  FeatureResults results{namesIn(sources), options.distances, {}, {}};
  if (results.distances.empty()) results.distances = {MapperOptions{}.distance};
  for (const DrivePair& drive : tasks.drives) results.tasks.push_back({drive.mapped.name, true});
  for (const auto& rooms : tasks.rooms) results.tasks.push_back({rooms.learned.name, false});
  RoomsSeen roomsSeen;
  std::vector<std::pair<std::string, std::string>> identities;
  for (const Source& source : sources) {
    identities.emplace_back("Descriptor", source.labeler->identity());
    results.cells.push_back(study(source, tasks, results.distances, roomsSeen, grid, run, progress));
  }
  for (const std::string& feature : options.fabMaps) {
    const std::string name = "fab-map, " + feature;
    if (lacksWords(name, options, learned, notes)) continue;
    const auto labeler = makeShownWordLabeler(feature == "orb" ? LocalFeature::orb : LocalFeature::sift,
                                              *learned, options.sizes);
    identities.emplace_back("FAB-MAP", labeler->identity());
    results.recognizers.emplace_back(
        name, recognize(name, *labeler, options.vocabulary->images, tasks, grid, run, progress));
  }
  Findings findings = featureFindings(results);
  if (!options.shownLayers.empty()) {
    const auto images = openImages(tasks.drives.front().mapped.images);
    findings.sections.emplace_back(
        layerFigures(options.shownLayers, images->image(0), images->frame(0).name));
  }
  findings.facts = std::move(identities);
  findings.notes = std::move(notes);
  return findings;
}

}  // namespace estancia::experiments
