// estancia classify: room classifiers, trained, tested and applied.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "described.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/similar_names.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/files/files.hpp"
#include "estancia/findings/confusion_findings.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/listed_sequence.hpp"
#include "estancia/stats/proportion.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using report::counted;

/// Rooms differ by their objects (docs/how-to/rooms.md).
const std::string defaultDescriptor = "inception-v3+coco-ssd";

struct ClassifyArguments {
  explicit ClassifyArguments(CLI::App& command) : declared(command) {}
  SequenceArguments source;
  ModelArguments describing;
  ClassifierOptions classifier;
  FeatureTableOptions tables;
  std::string descriptor, roomClassifier, output, map;
  std::vector<std::string> images;
  /// Rooms to predict by name without a room classifier; none: commonRooms().
  std::vector<std::string> rooms;
  /// 0: all.
  std::size_t maxLabels = 0;
  std::string criterion = "mutual-information";
  double minProbability = 0;
  bool overwrite = false, json = false;
  DeclaredOptions declared;
};

/// Before the long work begins: an output that begins with `start` and is none of the inputs.
void requireOutput(const ClassifyArguments& a, std::vector<std::string> inputs, std::string_view start,
                   std::string_view what) {
  if (a.output.empty()) return;
  inputs.push_back(a.roomClassifier);
  requireNoData(a.output, inputs, start);
  requireReplaceable(
      a.output, a.overwrite, [](const fs::path&) { return true; }, what);
}

// ---- train

/// Tables often hold, beside descriptors, people's annotations of the images: a classifier trained on those
/// learns nothing about images.
void warnOfAnnotations(const Features& features) {
  const std::vector<std::string> annotations = binaryParts(features);
  if (annotations.empty()) return;
  std::vector<std::string> others;
  for (const DescriptorPart& part : features.parts)
    if (std::ranges::find(annotations, part.name) == annotations.end()) others.push_back(part.name);
  spdlog::warn(
      "{} {} only 0 and 1, as annotations do; they are used for training, too.{}",
      fmt::join(annotations, ", "), annotations.size() == 1 ? "holds" : "hold",
      others.empty() ? "" : fmt::format(" Leave them out by --descriptor {}", fmt::join(others, "+")));
}

/// Descriptors of other sources are compared when they are opened.
void warnOfSimilarRooms(const Features& features) {
  std::set<std::string> rooms;
  for (const auto& [room, count] : framesPerRoom(features)) rooms.insert(room);
  for (const std::string& warning : warningsOfSimilarRooms(rooms)) spdlog::warn("{}", warning);
}

/// "; if …: COMMAND" where folders of images may be rooms, which was not asked for.
std::string classesHint(const ClassifyArguments& a) {
  if (a.source.options.type != "auto" || !io::mayBeClasses(a.source.path)) return "";
  return fmt::format("; if each folder of images is a room: estancia classify train {} --type classes -o {}",
                     io::printable(a.source.path), io::printable(a.output));
}

std::unique_ptr<Sequence> openTraining(const ClassifyArguments& a) {
  try {
    return a.source.open();
  } catch (const Error& e) {
    throw Error(e.code(), std::string(e.what()) + classesHint(a));
  }
}

/// Before the images are described, which takes long.
void requireRooms(const Sequence& sequence, const ClassifyArguments& a) {
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (!sequence.frame(i).room.empty()) return;
  throw Error(ErrorCode::insufficientData,
              "no image has a known room; give a table of rooms (--rooms), or a folder of images per room "
              "(--type classes)" +
                  classesHint(a));
}

Features trainingFeatures(const ClassifyArguments& a, FeatureSource& describing) {
  if (holdsNumbers(a.source.path) || isFeatureTable(a.source.path))
    return describing.features(a.source, a.descriptor, a.tables);
  const auto images = openTraining(a);
  requireRooms(*images, a);
  return describing.features(*images, a.descriptor.empty() ? defaultDescriptor : a.descriptor);
}

void train(const ClassifyArguments& a) {
  requireReplaceable(a.output, a.overwrite, isRoomClassifier, "room classifier");
  FeatureSource describing(a.describing);
  Features features = trainingFeatures(a, describing);
  warnOfAnnotations(features);
  if (isFeatureTable(a.source.path)) warnOfSimilarRooms(features);
  if (a.maxLabels > 0) features = withColumns(features, selectColumns(features, a.criterion, a.maxLabels));
  const auto progress = makeStderrProgress();
  const RoomClassifier classifier = trainRoomClassifier(features, a.classifier, *progress);
  if (!classifier.embedding().isInformative())
    throw Error(ErrorCode::invalidInput,
                fmt::format("all images have the same numbers in {}, so rooms cannot be distinguished; use "
                            "another --descriptor",
                            features.name()));
  writeRoomClassifier(classifier, a.output);
  const auto images = framesPerRoom(features);
  std::size_t learned = 0;
  for (const auto& [room, count] : images) learned += count;
  if (a.json) {
    print({{"classifier", a.output},
           {"type", classifier.classifier().type()},
           {"descriptor", descriptorOf(classifier)},
           {"columns", classifier.embedding().columns()},
           {"images", learned},
           {"without_room", features.frames.size() - learned},
           {"rooms", images},
           {"choice", classifier.choice()}});
    return;
  }
  fmt::print("{}: {} of {} by {}\n", printable(a.output), counted(images.size(), "room"),
             counted(learned, "image"), nameOf(classifier));
  for (const auto& [room, count] : images) fmt::print("  {:<24} {:>6}\n", room, counted(count, "image"));
  if (learned < features.frames.size())
    fmt::print("{} without a room were left out\n", counted(features.frames.size() - learned, "image"));
  fmt::print("{}{}\n", classifier.choice(),
             a.maxLabels > 0 ? "; optimistic, as the labels were selected on the same images" : "");
}

// ---- test

Features featuresFor(const ClassifyArguments& a, const RoomClassifier& classifier) {
  const bool numbers = holdsNumbers(a.source.path);
  if (!numbers) requireDescribable(classifier);
  return FeatureSource(a.describing).features(a.source, numbers ? "" : descriptorOf(classifier), a.tables);
}

/// Rows are true rooms, columns predicted rooms, by number.
void printConfusion(const Confusion& confusion) {
  fmt::print("\n{:<24}", "true room, predicted as");
  for (std::size_t r = 0; r < confusion.rooms.size(); ++r) fmt::print(" {:>5}", r + 1);
  fmt::print("   right\n");
  for (std::size_t r = 0; r < confusion.rooms.size(); ++r) {
    std::size_t all = 0;
    fmt::print("{:>3} {:<20}", r + 1, confusion.rooms[r]);
    for (const std::size_t count : confusion.counts[r]) {
      fmt::print(" {:>5}", count);
      all += count;
    }
    fmt::print("   {}\n", all == 0
                              ? "no image"
                              : fmt::format("{:.1f} %", 100 * static_cast<double>(confusion.counts[r][r]) /
                                                            static_cast<double>(all)));
  }
}

void test(const ClassifyArguments& a) {
  requireOutput(a, {a.source.path}, pageStart, "page");
  const RoomClassifier classifier = readRoomClassifier(a.roomClassifier);
  const Features features = featuresFor(a, classifier);
  const Confusion confusion = testRooms(classifier, features, a.describing.options.threads);
  const std::size_t total = confusion.total(), right = rightOf(confusion);
  const auto [low, high] = wilsonInterval(right, total);
  auto unknown = framesPerRoom(features);
  for (const std::string& room : classifier.rooms()) unknown.erase(room);
  if (!a.output.empty()) {
    writeFindingsPage(
        a.output, findingsOf(confusion, fs::path(a.roomClassifier).stem().string(),
                             {{"classifier", nameOf(classifier)},
                              {"chosen", classifier.choice()},
                              {"tested on", io::printable(fs::path(a.source.path).filename().string())}}));
    spdlog::info("wrote {}", a.output);
  }
  if (a.json) {
    print({{"classifier", a.roomClassifier},
           {"images", total},
           {"without_room", features.frames.size() - total},
           {"never_learned", unknown},
           {"right", right},
           {"accuracy", confusion.accuracy()},
           {"interval", {low, high}},
           {"balanced_accuracy", confusion.balancedAccuracy()},
           {"rooms", confusion.rooms},
           {"confusion", confusion.counts}});
    return;
  }
  fmt::print("{}: {} of {} correct by {}\n", a.roomClassifier, right, counted(total, "image"),
             nameOf(classifier));
  fmt::print("accuracy           {:>5.1f} %   95 % interval {:.1f} … {:.1f} %, if images were independent\n",
             100 * confusion.accuracy(), 100 * low, 100 * high);
  fmt::print("balanced accuracy  {:>5.1f} %   mean of the rooms' accuracies\n",
             100 * confusion.balancedAccuracy());
  printConfusion(confusion);
  for (const auto& [room, count] : unknown)
    fmt::print("{} of room \"{}\", which is not in the training data, count as errors\n",
               counted(count, "image"), room);
  if (total < features.frames.size())
    fmt::print("{} without a room were left out\n", counted(features.frames.size() - total, "image"));
}

// ---- predict

void printLine(const std::string& image, const std::vector<RoomProbability>& rooms, double minProbability) {
  if (rooms.empty()) return;
  const bool unsure = rooms.front().probability < minProbability;
  const std::string second =
      rooms.size() < 2 ? "" : fmt::format("{} {:.1f} %", rooms[1].room, 100 * rooms[1].probability);
  fmt::print("{:<32} {:<20} {:>5.1f} %   {}{}\n", image, unsure ? "?" : rooms[0].room,
             100 * rooms[0].probability, unsure ? fmt::format("perhaps {}, ", rooms[0].room) : "", second);
}

/// One sequence, or any number of single images.
std::vector<std::string> pathsToPredict(const ClassifyArguments& a) {
  std::vector<std::string> paths{a.source.path};
  paths.insert(paths.end(), a.images.begin(), a.images.end());
  return paths;
}

Features featuresToPredict(const ClassifyArguments& a, const RoomClassifier& classifier) {
  const auto names = pathsToPredict(a);
  const std::vector<fs::path> paths(names.begin(), names.end());
  if (paths.size() == 1 && !isImageFile(paths[0])) return featuresFor(a, classifier);
  requireDescribable(classifier);
  return FeatureSource(a.describing).features(*openImages(paths), descriptorOf(classifier));
}

void predict(const ClassifyArguments& a) {
  requireOutput(a, pathsToPredict(a), predictionsCsvHeader, "table");
  const RoomClassifier classifier = readRoomClassifier(a.roomClassifier);
  const Features features = featuresToPredict(a, classifier);
  const RoomPredictions rooms =
      predictRooms(classifier, features, features.frames, a.describing.options.threads);
  if (!a.output.empty()) {
    writeWhole(a.output, predictionsCsv(rooms, features.frames, a.minProbability));
    spdlog::info("wrote {}", a.output);
    return;
  }
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    if (a.json)
      print(predictionJson(rooms, features.frames, i, a.minProbability));
    else
      printLine(features.frames[i].name, rankedRooms(rooms, i), a.minProbability);
}

// ---- show, name

void show(const ClassifyArguments& a) {
  const RoomClassifier classifier = readRoomClassifier(a.roomClassifier);
  if (a.json) {
    Json parts = Json::array();
    for (const PartEmbedding& learned : classifier.embedding().parts())
      parts.push_back({{"name", learned.part.name},
                       {"columns", learned.part.size()},
                       {"identity", learned.part.identity}});
    print({{"classifier", a.roomClassifier},
           {"type", classifier.classifier().type()},
           {"rooms", classifier.rooms()},
           {"parts", parts},
           {"choice", classifier.choice()}});
    return;
  }
  fmt::print("{}: {}\nrooms: {}\n", printable(a.roomClassifier), nameOf(classifier),
             fmt::join(classifier.rooms(), ", "));
  for (const PartEmbedding& learned : classifier.embedding().parts())
    fmt::print("part {}: {} ({})\n", learned.part.name, counted(learned.part.size(), "number"),
               learned.part.identity);
  fmt::print("{}\n", classifier.choice());
}

Json placeJson(int node, const Place& place) {
  Json json{{"node", node}, {"predicted_rooms", Json::array()}};
  for (const auto& [room, probability] : place.predicted)
    json["predicted_rooms"].push_back({{"room", room}, {"p", probability}});
  return json;
}

void name(const ClassifyArguments& a) {
  if (a.roomClassifier.empty()) {
    nameRoomsByNames(a.map, a.rooms);
  } else {
    const RoomClassifier classifier = readRoomClassifier(a.roomClassifier);
    const auto sequence = a.source.path.empty() ? nullptr : a.source.open();
    FeatureSource describing(a.describing);
    nameRooms(a.map, classifier, sequence.get(), describing);
  }
  const WorldMap world = readWorld(a.map);
  const std::vector<Place> places = placesOf(world.places);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (a.json)
      print(placeJson(world.places.nodes[i].id, places[i]));
    else
      fmt::print("place {:<5} {}\n", world.places.nodes[i].id,
                 places[i].predicted.empty() ? "no prediction" : describeRooms(places[i].predicted));
  if (!a.json)
    for (const WorldArea& area : world.areas)
      fmt::print("area {:<6} {}\n", area.id,
                 area.predictedRoom.empty()
                     ? "no prediction"
                     : fmt::format("{} {:.0f} %", area.predictedRoom, 100 * area.roomProbability));
}

// ---- the commands

using Shared = std::shared_ptr<ClassifyArguments>;

CLI::App* addCommand(CLI::App& classify, const std::string& name, const std::string& what, Shared& a) {
  CLI::App* command = classify.add_subcommand(name, what);
  a = std::make_shared<ClassifyArguments>(*command);
  if (name != "train" && name != "name")
    command->add_option("MODEL", a->roomClassifier, "The room classifier, of `estancia classify train`")
        ->required();
  return command;
}

/// SEQ with depth, and how it is described.
void addSource(CLI::App& command, ClassifyArguments& a, const std::string& what, bool required = true,
               bool withRooms = true) {
  a.source.addTo(a.declared, required, withRooms);
  SequenceArguments::addDepthTo(a.declared);
  command.get_option("SEQ")->description(what);
  a.declared.add(declare(a.tables));
  addDescribing(a.declared, a.describing);
}

std::string explained(std::string text, const Choices& choices) {
  for (const auto& [name, explanation] : choices) text += fmt::format("\n  {}: {}", name, explanation);
  return text;
}

void addTrain(CLI::App& classify) {
  Shared a;
  CLI::App* command =
      addCommand(classify, "train", "Train a room classifier on images whose rooms are known", a);
  addSource(*command, *a,
            "Images with rooms (rooms.csv, a data set, a folder for each room), their labels (*.labels …), a "
            "table of features, or a map");
  addOutputOption(*command, a->output, "The room classifier, NAME.classifier")->required();
  command
      ->add_option(
          "--descriptor", a->descriptor,
          fmt::format("{}\nSeveral are joined by +. Of labels, maps and tables: the parts to use\n"
                      "Default: {}; of labels, maps and tables all parts",
                      explained("Descriptor of images: a model of `models list`, or", descriptorTypes()),
                      defaultDescriptor))
      ->type_name("NAME");
  a->declared.add(declare(a->classifier), {"type=classifier", "balanced", "folds", "seed"});
  command
      ->add_option("--max-labels", a->maxLabels,
                   "Learn only from this many labels (or other numbers), the best by --by\nDefault: all")
      ->check(wholeNumber(1));
  command
      ->add_option(
          "--by", a->criterion,
          explained("How --max-labels ranks labels:", selectionCriteria()) + "\nDefault: " + a->criterion)
      ->type_name("NAME")
      ->needs("--max-labels");
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(
      *command,
      "  estancia classify train ~/photos -o rooms.classifier\n"
      "  estancia classify train nyu -o rooms.classifier --split train --only kitchen,bathroom,bedroom\n"
      "  estancia classify train table.csv -o table.classifier --descriptor g+d\n"
      "  estancia classify train images.labels --rooms rooms.csv -o rooms.classifier --classifier forest");
  command->callback([a] { train(*a); });
}

void addTest(CLI::App& classify) {
  Shared a;
  CLI::App* command =
      addCommand(classify, "test", "Measure a room classifier on images whose rooms are known", a);
  addSource(*command, *a, "Images with rooms, their labels, or a map; not those of the training");
  addOutputOption(*command, a->output, "Write a page, too");
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia classify test rooms.classifier ~/other-images\n"
              "  estancia classify test rooms.classifier nyu --split test --json\n"
              "  estancia classify test rooms.classifier ~/other-images -o test.html");
  command->callback([a] { test(*a); });
}

void addPredict(CLI::App& classify) {
  Shared a;
  CLI::App* command = addCommand(classify, "predict", "Predict the room of each image", a);
  addSource(*command, *a, "Images, or a sequence, its labels, or a map");
  command->add_option("IMAGE", a->images, "More images");
  command
      ->add_option("--min-probability", a->minProbability,
                   "Give no room to images whose best room is less probable")
      ->check(CLI::Range(0.0, 1.0));
  addOutputOption(*command, a->output, "Write a CSV instead");
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia classify predict rooms.classifier image.jpg another.jpg\n"
              "  estancia classify predict rooms.classifier ~/photos --json\n"
              "  estancia classify predict rooms.classifier ~/photos --min-probability 0.5 -o predicted.csv");
  command->callback([a] { predict(*a); });
}

void addShow(CLI::App& classify) {
  Shared a;
  CLI::App* command = addCommand(classify, "show", "Show the rooms and descriptors of a room classifier", a);
  addJsonOption(*command, a->json);
  addExamples(*command, "  estancia classify show rooms.classifier");
  command->callback([a] { show(*a); });
}

void addName(CLI::App& classify) {
  Shared a;
  CLI::App* command = addCommand(classify, "name", "Name the places and areas of a map by their rooms", a);
  command->add_option(
      "MODEL", a->roomClassifier,
      "The room classifier, of `estancia classify train`; left out: rooms are told by what the "
      "map's labels have to do with their names, without any example");
  command->add_option("MAP", a->map, "The map file");
  addSource(
      *command, *a,
      "The images of the map; needed where its labels are not all that MODEL was trained on, as with the "
      "defaults of `train` and `map`",
      false, false);
  command
      ->add_option("--rooms", a->rooms,
                   fmt::format("Without MODEL: the rooms that there are, separated by commas, in English\n"
                               "Default: those that occur of {}",
                               fmt::join(commonRooms(), ", ")))
      ->delimiter(',')
      ->type_name("NAME");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia classify name home.estancia --rooms kitchen,bedroom,bathroom,office\n"
              "  estancia classify name rooms.classifier home.estancia ~/photos");
  command->callback([a] {
    if (a->map.empty()) std::swap(a->map, a->roomClassifier);  // the map alone
    if (a->map.empty()) throw CLI::RequiredError("MAP");
    if (!a->rooms.empty() && !a->roomClassifier.empty())
      throw Error(ErrorCode::invalidOption,
                  "a room classifier has rooms of its own; leave out --rooms, or MODEL");
    name(*a);
  });
}

}  // namespace

void addClassifyCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("classify", "Train room classifiers, and predict the rooms of images");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia classify train ~/photos -o rooms.classifier\n"
              "  estancia classify test rooms.classifier ~/other-images\n"
              "  estancia classify predict rooms.classifier image.jpg\n"
              "  estancia map ~/drive -o home.estancia --room-classifier rooms.classifier");
  addTrain(*command);
  addTest(*command);
  addPredict(*command);
  addShow(*command);
  addName(*command);
}

}  // namespace estancia::apps
