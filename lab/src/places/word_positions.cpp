// SPDX-License-Identifier: Apache-2.0
#include "places/word_positions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "estancia/areas/word_map.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/readers/home_truth.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int wordPositionsVersion = 1;  // version of the code below: cells of another one are computed anew

/// What a word map is made of.
enum class Evidence { wordsAndDepth, words, truthAndDepth };
const std::vector<std::string> evidenceNames{"words, depth", "words alone", "true categories, depth"};

/// The things of a drive that are to be found.
struct Things {
  /// By category: those that are seen well enough, as polygons on the floor [m].
  std::map<std::string, std::vector<std::vector<cv::Point2f>>> boxes;
  /// By image, the categories of which it shows one well enough.
  std::map<std::string, std::set<std::string>> named;
  /// Pixels in all images.
  std::map<std::string, double> pixels;
};

std::vector<cv::Point2f> boxOf(const io::HomeInstance& thing, const Floor& floor) {
  std::vector<cv::Point2f> corners;
  for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const double x = u * thing.size.x / 2, y = v * thing.size.y / 2;
    const double c = std::cos(thing.yaw), s = std::sin(thing.yaw);
    corners.emplace_back(
        floor.position({thing.center.x + c * x - s * y, thing.center.y + s * x + c * y, thing.center.z}));
  }
  return corners;
}

Things thingsOf(const fs::path& folder, const Floor& floor, std::size_t minPixels) {
  const io::HomeTruth truth = io::readHomeTruth(folder);
  std::map<int, const io::HomeInstance*> instances;
  for (const io::HomeInstance& thing : truth.instances) instances.emplace(thing.id, &thing);
  std::set<int> large;
  Things things;
  for (const auto& [image, visible] : truth.visible)
    for (const io::VisibleInstance& seen : visible) {
      const std::string& category = instances.at(seen.id)->category;
      things.pixels[category] += seen.pixels;
      if (static_cast<std::size_t>(seen.pixels) < minPixels) continue;
      things.named[image].insert(category);
      large.insert(seen.id);
    }
  for (const int id : large)
    things.boxes[instances.at(id)->category].push_back(boxOf(*instances.at(id), floor));
  return things;
}

/// Categories that are to be found, most pixels first.
std::vector<std::string> categoriesOf(const Things& things, const WordPositionsOptions& options) {
  std::vector<std::string> categories;
  for (const auto& [category, words] : options.words)
    if (things.pixels.contains(category)) categories.push_back(category);
  std::ranges::stable_sort(categories, std::greater(), [&](const auto& c) { return things.pixels.at(c); });
  if (options.categories > 0 && categories.size() > options.categories) categories.resize(options.categories);
  return categories;
}

WordMap mapOf(const LabeledDrive& drive, const DescriptorSequence& words, const Floor& floor,
              bool withDepth) {
  std::map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < drive.images->size(); ++i) numbers.emplace(drive.images->frame(i).name, i);
  const CameraIntrinsics camera = *drive.images->intrinsics();
  const double fieldOfView = 2 * std::atan(camera.width / (2 * camera.fx));
  WordMap map(floor, words.vocabulary.size());
  for (std::size_t i = 0; i < words.frames.size(); ++i) {
    const Frame& frame = words.frames[i];
    if (!frame.pose) continue;
    if (withDepth)
      map.add(words.descriptors.row(i), drive.images->depth(numbers.at(frame.name)), camera, *frame.pose);
    else
      map.add(words.descriptors.row(i), fieldOfView, *frame.pose);
  }
  return map;
}

/// Answers of a model that names exactly the categories that each image shows.
DescriptorSequence trueWords(const DescriptorSequence& recording, const Things& things) {
  std::vector<std::string> names;
  for (const auto& [category, pixels] : things.pixels) names.push_back(category);
  DescriptorSequence result{Vocabulary(names), "truth", recording.frames, DescriptorMatrix(names.size())};
  for (const Frame& frame : recording.frames) {
    LexicalDescriptor words(names.size(), 0.0F);
    const auto named = things.named.find(fs::path(frame.name).filename().string());
    for (std::size_t c = 0; c < names.size() && named != things.named.end(); ++c)
      words[c] = named->second.contains(names[c]) ? 1.0F : 0.0F;
    result.descriptors.append(words);
  }
  return result;
}

/// From the strongest cell of the labels to the nearest box [m]; nothing where they are not in the map.
std::optional<double> distanceTo(const std::vector<std::vector<cv::Point2f>>& boxes, const WordMap& map,
                                 const std::vector<std::size_t>& labels) {
  const FloorHeat heat = map.heat(labels);
  double strongest = 0, nearest = 1e9;
  cv::Point cell;
  cv::minMaxLoc(heat.values, nullptr, &strongest, nullptr, &cell);
  if (!(strongest > 0) || boxes.empty()) return std::nullopt;
  for (const auto& box : boxes)
    nearest = std::min(nearest, std::max(0.0, -cv::pointPolygonTest(box, heat.cells.centerOf(cell), true)));
  return nearest;
}

CellResults findThings(const LabeledDrive& drive, const fs::path& folder, Evidence evidence,
                       const WordPositionsOptions& options) {
  std::vector<Pose> poses;
  for (const Frame& frame : drive.recording.frames)
    if (frame.pose) poses.push_back(*frame.pose);
  if (poses.empty() || !drive.images->hasDepth() || !drive.images->intrinsics())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: a word map is measured with poses, depth and a camera", folder.string()));
  const Floor floor(poses);
  const Things things = thingsOf(folder, floor, options.minPixels);
  const bool isTrue = evidence == Evidence::truthAndDepth;
  const DescriptorSequence words = isTrue ? trueWords(drive.recording, things) : drive.recording;
  const WordMap map = mapOf(drive, words, floor, evidence != Evidence::words);
  CellResults results;
  double found = 0, judged = 0;
  for (const std::string& category : categoriesOf(things, options)) {
    const auto known = std::ranges::find(options.words, category, [](const auto& w) { return w.first; });
    std::optional<double> nearest;
    for (const std::string& word : isTrue ? std::vector{category} : known->second)
      if (const auto boxes = things.boxes.find(category); boxes != things.boxes.end())
        if (const auto distance = distanceTo(boxes->second, map, findLabels(words.vocabulary, word)))
          nearest = std::min(*distance, nearest.value_or(*distance));
    ++judged;
    found += nearest && *nearest <= options.reach ? 1 : 0;
    if (nearest) results.push_back({"distance", category, *nearest});
  }
  if (judged == 0)
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no thing of a category that has words is in sight", folder.string()));
  results.push_back({"categories", "", judged});
  results.push_back({"found", "", found});
  results.push_back({"share", "", found / judged});
  return results;
}

OptionGroup declare(WordPositionsOptions& options) {
  OptionGroup group("word-map", "Words on the floor, beside the things.");
  group.add("reach", &options.reach, "How far from a thing its word may be").unit("m").range(0, 100);
  group.add("categories", &options.categories, "Those with the most pixels are to be found; 0: all");
  group.add("least-pixels", &options.minPixels, "Pixels of an instance that can be named");
  return group;
}

}  // namespace

WordPositionsOptions readWordPositions(ConfigFile& config) {
  WordPositionsOptions options;
  const toml::array* drives = nullptr;
  const auto words = [&](const toml::node& node) {
    for (const auto& [category, list] : config.subtable(node)) {
      auto& [name, known] =
          options.words.emplace_back(std::string(category.str()), std::vector<std::string>());
      each(config, known, [&config](const toml::node& n) { return config.text(n); })(list);
    }
  };
  config.read(together(keysOf(config, declare(options)),
                       {{"type", true, "the kind of experiment", [](auto&) {}},
                        {"models", false, "the models to compare",
                         each(config, options.models, [&config](auto& n) { return config.text(n); })},
                        {"words", true, "a list of words by category", words},
                        {"drive", true, "[[drive]] names images with depth, poses and the truth of a home",
                         [&](auto& n) { drives = &config.list(n); }}}));
  for (const toml::node& node : *drives)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  return options;
}

GridColumns wordPositionsColumns() {
  return {{"model", "drive", "variant"}, "category", {"distance", "found", "categories", "share"}};
}

Findings compareWordPositions(const WordPositionsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress) {
  std::string asked = fmt::format("{} {} {}", options.reach, options.categories, options.minPixels);
  for (const auto& [category, words] : options.words)
    asked += fmt::format("\n{}: {}", category, fmt::join(words, ", "));
  const auto inputs = [&](const NamedDrive& drive, std::size_t) {
    return fmt::format("{} {} {} {}", wordPositionsVersion, asked,
                       sha256OfFile(drive.images.path / "instances.csv"),
                       sha256OfFile(drive.images.path / "visible.csv"));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t evidence) {
    return findThings(labeled.of(drive.images), drive.images.path, static_cast<Evidence>(evidence), options);
  };
  return studyDrives({options.models, options.drives, evidenceNames, inputs, compute}, wordPositionsFindings,
                     grid, run, progress);
}

Findings wordPositionsFindings(const DriveResults& results) {
  constexpr auto largest = ResultTable::Best::largest;
  const auto measures = measuresIn(
      results.cells,
      {{"categories", {"categories", 0}}, {"found", {"found", 0}}, {"share", {"share", 3, largest}}});
  Findings findings;
  findings.title = "Words on the floor, beside the things";
  results.each([&](std::size_t model, std::size_t drive) {
    std::vector<std::pair<std::string, CellResults>> rows;
    std::vector<std::string> categories;
    for (std::size_t v = 0; v < results.variants.size(); ++v) {
      rows.emplace_back(results.variants[v], results.of(model, drive, v));
      for (const CellResult& result : rows.back().second)
        if (result.measure == "distance" && std::ranges::count(categories, result.at) == 0)
          categories.push_back(result.at);
    }
    const std::string title = results.titleOf(model, drive);
    findings.sections.emplace_back(pivot(
        ResultTable{title,
                    "Found: the strongest cell of one of the category's words is near one of its things. "
                    "True categories: as if a model named just those that each image shows.",
                    "word map of",
                    {},
                    {}},
        rows, measures));
    findings.sections.emplace_back(pivot(
        ResultTable{
            title + ": distances",
            "From the strongest cell of the best word to the nearest thing of the category [m]; those "
            "with the most pixels first.",
            "category",
            columnsOf(results.variants, 2),
            {}},
        categories, [&](std::size_t row, std::size_t column) {
          return valueOf(rows[column].second, "distance", categories[row]);
        }));
  });
  findings.summary = fmt::format("{} drives and their things.", results.drives.size());
  return findings;
}

}  // namespace estancia::experiments
