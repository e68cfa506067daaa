// estancia classify: rooms learned from examples, and found again.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "described.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/classify/scores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/io/csv.hpp"
#include "estancia/io/files.hpp"
#include "estancia/report/text.hpp"
#include "estancia/stats/proportion.hpp"
#include "estancia/topology/places.hpp"
#include "estancia/topology/store.hpp"
#include "experiments/src/findings/confusion_findings.hpp"
#include "experiments/src/findings/findings_page.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using report::counted;

/// What is learned from unless told otherwise: rooms are told apart by their things (docs/how-to/rooms.md).
const std::string defaultDescriptor = "inception-v3+coco-ssd";

struct Arguments {
  SequenceArguments source;
  ModelArguments describing;
  ClassifierOptions classifier;
  std::string descriptor, model, output, map;
  std::vector<std::string> images;
  std::size_t labels = 0;  ///< 0: all
  std::string criterion = "mutual-information";
  double least = 0;
  bool overwrite = false, json = false;
};

// ---- train

std::map<std::string, std::size_t> imagesByRoom(const Features& features) {
  std::map<std::string, std::size_t> images;
  for (const Frame& frame : features.frames)
    if (!frame.room.empty()) ++images[frame.room];
  return images;
}

/// Tables often hold, beside descriptors, what people saw in the images: whoever learns from that learns
/// nothing about images.
void warnOfAnswers(const Features& features) {
  std::vector<std::string> answers, others;
  std::size_t column = 0;
  for (const DescriptorPart& part : features.parts) {
    bool binary = part.size() == 1 && isOfTable(part);
    for (std::size_t i = 0; binary && i < features.values.size(); ++i) {
      const float value = features.values.row(i)[column];
      binary = value == 0 || value == 1;
    }
    (binary ? answers : others).push_back(part.name);
    column += part.size();
  }
  if (answers.empty()) return;
  spdlog::warn(
      "learning from {}, too, which {} only 0 and 1: answers of people?{}", fmt::join(answers, ", "),
      answers.size() == 1 ? "holds" : "hold",
      others.empty() ? "" : fmt::format(" Leave them out by --descriptor {}", fmt::join(others, "+")));
}

void train(const Arguments& arguments) {
  requireReplaceable(arguments.output, arguments.overwrite, isRoomClassifier, "room classifier");
  FeatureSource describing(arguments.describing);
  const bool words = holdsNumbers(arguments.source.path);
  Features features = describing.features(
      arguments.source, arguments.descriptor.empty() && !words ? defaultDescriptor : arguments.descriptor);
  warnOfAnswers(features);
  if (arguments.labels > 0)
    features = withColumns(features, selectColumns(features, arguments.criterion, arguments.labels));
  const auto progress = makeStderrProgress();
  ClassifierOptions options = arguments.classifier;
  options.threads = arguments.describing.options.threads;
  const RoomClassifier classifier = trainRoomClassifier(features, options, *progress);
  if (!classifier.embedding().isInformative())
    throw Error(fmt::format(
        "all images have the same numbers in {}: nothing tells the rooms apart; describe them with "
        "something else",
        features.name()));
  writeRoomClassifier(classifier, arguments.output);
  const auto images = imagesByRoom(features);
  std::size_t learned = 0;
  for (const auto& [room, count] : images) learned += count;
  if (arguments.json) {
    print({{"classifier", arguments.output},
           {"type", classifier.classifier().type()},
           {"descriptor", descriptorOf(classifier)},
           {"columns", classifier.embedding().columns()},
           {"images", learned},
           {"without_room", features.frames.size() - learned},
           {"rooms", images},
           {"choice", classifier.choice()}});
    return;
  }
  fmt::print("{}: {} of {} by {}\n", arguments.output, counted(images.size(), "room"),
             counted(learned, "image"), nameOf(classifier));
  for (const auto& [room, count] : images) fmt::print("  {:<24} {:>6}\n", room, counted(count, "image"));
  if (learned < features.frames.size())
    fmt::print("{} without a room were left out\n", counted(features.frames.size() - learned, "image"));
  fmt::print("{}{}\n", classifier.choice(),
             arguments.labels > 0 ? ", too much so: the labels were chosen with these images, too" : "");
}

// ---- test

/// What images are described by when `classifier` is to tell their rooms.
Features described(const Arguments& arguments, const RoomClassifier& classifier) {
  FeatureSource describing(arguments.describing);
  const bool numbers = holdsNumbers(arguments.source.path);
  if (!numbers) requireDescribable(classifier);
  return describing.features(arguments.source, numbers ? "" : descriptorOf(classifier));
}

/// Rows are true rooms, columns, by number, what they are taken for.
void printConfusion(const Confusion& confusion) {
  fmt::print("\n{:<24}", "true room, taken for");
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
                              ? "never true"
                              : fmt::format("{:.1f} %", 100 * static_cast<double>(confusion.counts[r][r]) /
                                                            static_cast<double>(all)));
  }
}

void test(const Arguments& arguments) {
  if (!arguments.output.empty())
    requireNoData(arguments.output, {arguments.model, arguments.source.path}, pageStart);
  const RoomClassifier classifier = readRoomClassifier(arguments.model);
  const Features features = described(arguments, classifier);
  const Confusion confusion = testRooms(classifier, features, arguments.describing.options.threads);
  const std::size_t total = confusion.total(), right = experiments::rightOf(confusion);
  const auto [low, high] = wilsonInterval(right, total);
  auto unlearned = imagesByRoom(features);
  for (const std::string& room : classifier.rooms()) unlearned.erase(room);
  if (!arguments.output.empty()) {
    experiments::writeFindingsPage(
        arguments.output,
        experiments::findingsOf(
            confusion, fs::path(arguments.model).stem().string(),
            {{"classifier", nameOf(classifier)},
             {"chosen", classifier.choice()},
             {"tested on", io::printable(fs::path(arguments.source.path).filename().string())}}));
    spdlog::info("wrote {}", arguments.output);
  }
  if (arguments.json) {
    print({{"classifier", arguments.model},
           {"images", total},
           {"without_room", features.frames.size() - total},
           {"never_learned", unlearned},
           {"right", right},
           {"accuracy", confusion.accuracy()},
           {"interval", {low, high}},
           {"balanced_accuracy", confusion.balancedAccuracy()},
           {"rooms", confusion.rooms},
           {"confusion", confusion.counts}});
    return;
  }
  fmt::print("{}: {} of {} right by {}\n", arguments.model, right, counted(total, "image"),
             nameOf(classifier));
  fmt::print("accuracy           {:>5.1f} %   95 % interval {:.1f} … {:.1f} %, if images were independent\n",
             100 * confusion.accuracy(), 100 * low, 100 * high);
  fmt::print("balanced accuracy  {:>5.1f} %   the mean of the rooms' own\n",
             100 * confusion.balancedAccuracy());
  printConfusion(confusion);
  for (const auto& [room, count] : unlearned)
    fmt::print("{} of room \"{}\", which it has never learned: they cannot be right\n",
               counted(count, "image"), room);
  if (total < features.frames.size())
    fmt::print("{} without a room were left out\n", counted(features.frames.size() - total, "image"));
}

// ---- predict

bool isUnsure(const std::vector<RoomProbability>& rooms, double least) {
  return rooms.empty() || rooms.front().probability < least;
}

void printLine(const std::string& image, const std::vector<RoomProbability>& rooms,
               const Arguments& arguments) {
  const bool unsure = isUnsure(rooms, arguments.least);
  if (arguments.json) {
    Json json{{"image", image}, {"room", nullptr}, {"probability", nullptr}, {"rooms", Json::object()}};
    if (!unsure) json["room"] = rooms.front().room;
    if (!rooms.empty()) json["probability"] = rooms.front().probability;
    for (const auto& [room, probability] : rooms) json["rooms"][room] = probability;
    print(json);
    return;
  }
  if (rooms.empty()) return;
  const std::string second =
      rooms.size() < 2 ? "" : fmt::format("{} {:.1f} %", rooms[1].room, 100 * rooms[1].probability);
  fmt::print("{:<32} {:<20} {:>5.1f} %   {}{}\n", image, unsure ? "?" : rooms[0].room,
             100 * rooms[0].probability, unsure ? fmt::format("perhaps {}, ", rooms[0].room) : "", second);
}

constexpr std::string_view csvHeader = "image,predicted_room,probability,second,second_probability\n";

std::string csvOf(const RoomPredictions& said, const std::vector<Frame>& frames, double least) {
  std::string text(csvHeader);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto rooms = rankedRooms(said, i);
    text += io::csvCell(frames[i].name) + ',' + (isUnsure(rooms, least) ? "" : io::csvCell(rooms[0].room));
    for (std::size_t r = 0; r < 2; ++r) {
      if (r == 1) text += ',' + (rooms.size() > 1 ? io::csvCell(rooms[1].room) : "");
      text += ',' + (r < rooms.size() ? fmt::format("{:.6f}", rooms[r].probability) : "");
    }
    text += '\n';
  }
  return text;
}

/// One sequence, or any number of single images.
std::vector<std::string> pathsToPredict(const Arguments& arguments) {
  std::vector<std::string> paths{arguments.source.path};
  paths.insert(paths.end(), arguments.images.begin(), arguments.images.end());
  return paths;
}

Features featuresToPredict(const Arguments& arguments, const RoomClassifier& classifier) {
  const auto names = pathsToPredict(arguments);
  const std::vector<fs::path> paths(names.begin(), names.end());
  if (paths.size() == 1 && !isImageFile(paths[0])) return described(arguments, classifier);
  requireDescribable(classifier);
  return FeatureSource(arguments.describing).features(*openImages(paths), descriptorOf(classifier));
}

void predict(const Arguments& arguments) {
  if (!arguments.output.empty()) {
    auto inputs = pathsToPredict(arguments);
    inputs.push_back(arguments.model);
    requireNoData(arguments.output, inputs, csvHeader);
  }
  const RoomClassifier classifier = readRoomClassifier(arguments.model);
  const Features features = featuresToPredict(arguments, classifier);
  const RoomPredictions said =
      predictRooms(classifier, features, features.frames, arguments.describing.options.threads);
  if (!arguments.output.empty()) {
    writeWhole(arguments.output, csvOf(said, features.frames, arguments.least));
    spdlog::info("wrote {}", arguments.output);
    return;
  }
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    printLine(features.frames[i].name, rankedRooms(said, i), arguments);
}

// ---- show, name

void show(const Arguments& arguments) {
  const RoomClassifier classifier = readRoomClassifier(arguments.model);
  if (arguments.json) {
    Json parts = Json::array();
    for (const PartEmbedding& learned : classifier.embedding().parts())
      parts.push_back({{"name", learned.part.name},
                       {"columns", learned.part.size()},
                       {"identity", learned.part.identity}});
    print({{"classifier", arguments.model},
           {"type", classifier.classifier().type()},
           {"rooms", classifier.rooms()},
           {"parts", parts},
           {"choice", classifier.choice()}});
    return;
  }
  fmt::print("{}: {}\nrooms: {}\n", arguments.model, nameOf(classifier), fmt::join(classifier.rooms(), ", "));
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

void name(const Arguments& arguments) {
  const RoomClassifier classifier = readRoomClassifier(arguments.model);
  const auto sequence = arguments.source.path.empty() ? nullptr : arguments.source.open();
  FeatureSource describing(arguments.describing);
  nameRooms(arguments.map, classifier, sequence.get(), describing);
  const TopologicalMap map = readMap(arguments.map);
  const std::vector<Place> places = placesOf(map);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (arguments.json)
      print(placeJson(map.nodes[i].id, places[i]));
    else
      fmt::print("place {:<5} {}\n", map.nodes[i].id,
                 places[i].predicted.empty() ? "nothing is known of its images"
                                             : describeRooms(places[i].predicted));
}

using Shared = std::shared_ptr<Arguments>;

void addModel(CLI::App& command, const Shared& arguments) {
  command.add_option("MODEL", arguments->model, "The room classifier, of `estancia classify train`")
      ->required();
}

void addTrain(CLI::App& classify, const Shared& arguments) {
  CLI::App* command = classify.add_subcommand("train", "Learn the rooms of images whose rooms are known");
  arguments->source.addTo(*command);
  command->get_option("SEQ")->description(
      "Images with rooms (rooms.csv, a data set, a folder a room), their words (*.labels …), or a map");
  arguments->source.addDepthTo(*command);
  command->add_option("-o,--output", arguments->output, "The room classifier, NAME.classifier")->required();
  std::string descriptors = "What to learn from: models of `models list`, and";
  for (const auto& [name, explanation] : descriptorTypes())
    descriptors += fmt::format("\n{} ({})", name, explanation);
  command->add_option("--descriptor", arguments->descriptor,
                      fmt::format("{}\nseveral joined by +; default: {}, of words, maps and tables "
                                  "all they hold (of a table's columns g0, g1 …, d0, d1 …: g+d)",
                                  descriptors, defaultDescriptor));
  std::string types = "What learns:";
  std::vector<std::string> names;
  for (const auto& [name, explanation] : classifierTypes()) {
    types += fmt::format("\n{} ({})", name, explanation);
    names.push_back(name);
  }
  command->add_option("--classifier", arguments->classifier.type, types)
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  command->add_flag("--overwrite", arguments->overwrite, "Replace an existing room classifier");
  const auto learning = "Learning";
  command
      ->add_option("--labels", arguments->labels,
                   "Learn from this many labels (or other numbers) only, the best by --by; default: all")
      ->check(positive())
      ->group(learning);
  std::string criteria = "What makes labels good:";
  std::vector<std::string> known;
  for (const auto& [name, explanation] : selectionCriteria()) {
    criteria += fmt::format("\n{} ({})", name, explanation);
    known.push_back(name);
  }
  command->add_option("--by", arguments->criterion, criteria)
      ->check(CLI::IsMember(known))
      ->capture_default_str()
      ->needs("--labels")
      ->group(learning);
  command
      ->add_flag("--balanced", arguments->classifier.balanced,
                 "Each room counts alike, however many images it has; otherwise each image does")
      ->group(learning);
  command
      ->add_option("--folds", arguments->classifier.folds,
                   "Parts that are held out in turn to find what is not given")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str()
      ->group(learning);
  command->add_option("--seed", arguments->classifier.seed, "Of whatever is random in learning")
      ->capture_default_str()
      ->group(learning);
  arguments->describing.addRunningTo(*command);
  addJsonOption(*command, arguments->json);
  addExamples(
      *command,
      "  estancia classify train ~/photos -o rooms.classifier\n"
      "  estancia classify train nyu -o rooms.classifier --split train --only kitchen,bathroom,bedroom\n"
      "  estancia classify train table.csv -o table.classifier --descriptor g+d\n"
      "  estancia classify train images.labels --rooms rooms.csv -o rooms.classifier --classifier forest");
  command->callback([arguments] { train(*arguments); });
}

void addTest(CLI::App& classify, const Shared& arguments) {
  CLI::App* command =
      classify.add_subcommand("test", "Measure a room classifier on images whose rooms are known");
  addModel(*command, arguments);
  arguments->source.addTo(*command);
  command->get_option("SEQ")->description(
      "Images with rooms, their words, or a map; not those it has learned from");
  arguments->source.addDepthTo(*command);
  command->add_option("-o,--output", arguments->output, "Write a page, too");
  arguments->describing.addRunningTo(*command);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia classify test rooms.classifier ~/other-images\n"
              "  estancia classify test rooms.classifier nyu --split test --json\n"
              "  estancia classify test rooms.classifier ~/other-images -o test.html");
  command->callback([arguments] { test(*arguments); });
}

void addPredict(CLI::App& classify, const Shared& arguments) {
  CLI::App* command = classify.add_subcommand("predict", "Tell which room each image shows");
  addModel(*command, arguments);
  arguments->source.addTo(*command);
  command->get_option("SEQ")->description("Images, or a sequence as of other commands, its words, or a map");
  arguments->source.addDepthTo(*command);
  command->add_option("IMAGE", arguments->images, "More images");
  command->add_option("--least", arguments->least, "Say nothing of images that are less probable than this")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("-o,--output", arguments->output, "Write a CSV instead");
  arguments->describing.addRunningTo(*command);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia classify predict rooms.classifier image.jpg another.jpg\n"
              "  estancia classify predict rooms.classifier ~/photos --json\n"
              "  estancia classify predict rooms.classifier ~/photos --least 0.5 -o said.csv");
  command->callback([arguments] { predict(*arguments); });
}

void addShow(CLI::App& classify, const Shared& arguments) {
  CLI::App* command = classify.add_subcommand("show", "Tell what a room classifier knows");
  addModel(*command, arguments);
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia classify show rooms.classifier");
  command->callback([arguments] { show(*arguments); });
}

void addName(CLI::App& classify, const Shared& arguments) {
  CLI::App* command =
      classify.add_subcommand("name", "Name the places of an existing map, or name them anew");
  addModel(*command, arguments);
  command->add_option("MAP", arguments->map, "The map file")->required();
  arguments->source.addTo(*command, false);
  command->get_option("SEQ")->description(
      "The images that the map was made of; needed where its words are not all that MODEL has learned from, "
      "as "
      "with what `train` and `map` take by default");
  arguments->source.addDepthTo(*command);
  arguments->describing.addRunningTo(*command);
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia classify name rooms.classifier home.estancia ~/photos");
  command->callback([arguments] { name(*arguments); });
}

}  // namespace

void addClassifyCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("classify", "Learn rooms from examples, and tell which room images show");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia classify train ~/photos -o rooms.classifier\n"
              "  estancia classify test rooms.classifier ~/other-images\n"
              "  estancia classify predict rooms.classifier image.jpg\n"
              "  estancia map ~/drive -o home.estancia --room-classifier rooms.classifier");
  addTrain(*command, arguments);
  addTest(*command, arguments);
  addPredict(*command, arguments);
  addShow(*command, arguments);
  addName(*command, arguments);
}

}  // namespace estancia::apps
