// SPDX-License-Identifier: Apache-2.0
#include "places/missing_labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/config.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/label_scale.hpp"
#include "places/place_orders.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr int missingLabelsVersion = 1;  // version of the code below: cells of another one are computed anew
const std::vector<std::pair<std::string, Missing>> treatments{
    {"half of the least", Missing::half}, {"equal shares", Missing::share}, {"floor", Missing::floor}};
constexpr const char* returnedOnly = "returned labels only";

std::vector<std::size_t> bestOf(DescriptorView row, std::size_t best) {
  std::vector<std::size_t> order(row.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return row[a] > row[b]; });
  order.resize(best);
  return order;
}

/// Cosine distance over the labels that both images have; 2 without one.
double distanceOfReturned(DescriptorView a, DescriptorView b, DescriptorView returnedA,
                          DescriptorView returnedB) {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (returnedA[i] <= 0 || returnedB[i] <= 0) continue;
    ab += double{a[i]} * b[i];
    aa += double{a[i]} * a[i];
    bb += double{b[i]} * b[i];
  }
  return aa > 0 && bb > 0 ? 1 - ab / std::sqrt(aa * bb) : 2;
}

/// Share of `asked` whose nearest image of `known` shows the same room.
double nearestRoom(const DescriptorSequence& known, const DescriptorSequence& asked, bool byReturnedOnly) {
  const Distance distance = getDistance(MapperOptions{}.distance, known.vocabulary.layout().parts);
  const DescriptorMatrix vectors = comparedVectors(known.descriptors, known.descriptors, distance);
  const DescriptorMatrix queries = comparedVectors(asked.descriptors, known.descriptors, distance);
  std::size_t right = 0;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    std::pair<double, std::size_t> nearest{3, 0};
    for (std::size_t i = 0; i < vectors.size(); ++i) {
      const double d = byReturnedOnly ? distanceOfReturned(vectors.row(i), queries.row(q),
                                                           known.descriptors.row(i), asked.descriptors.row(q))
                                      : compare(distance.comparison, vectors.row(i), queries.row(q));
      nearest = std::min(nearest, {d, i});
    }
    right += known.frames[nearest.second].room == asked.frames[q].room ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(queries.size());
}

double classifierAccuracy(const DescriptorSequence& learned, const DescriptorSequence& asked) {
  const RoomClassifier classifier = trainRoomClassifier(featuresOf(learned), ClassifierOptions{});
  const DescriptorMatrix probabilities = classifier.predict(featuresOf(asked));
  std::size_t right = 0;
  for (std::size_t i = 0; i < asked.frames.size(); ++i) {
    const DescriptorView row = probabilities.row(i);
    const auto best = static_cast<std::size_t>(std::ranges::max_element(row) - row.begin());
    right += classifier.rooms()[best] == asked.frames[i].room ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(asked.frames.size());
}

CellResults judge(const MissingLabelsOptions& options, const MissingLabelsOptions::Drive& drive,
                  std::size_t best, LabeledDrives& labeled) {
  const DescriptorSequence& recording = labeled.of(drive.itself.images).recording;
  const DescriptorSequence& queries = labeled.of(drive.again).recording;
  CellResults results;
  for (const auto& [name, missing] : treatments) {
    DescriptorSequence known = recording, asked = queries;
    known.descriptors = withBest(recording.descriptors, best, missing);
    asked.descriptors = withBest(queries.descriptors, best, missing);
    results.push_back({"nearest", name, nearestRoom(known, asked, false)});
    if (drive.areRooms) results.push_back({"accuracy", name, classifierAccuracy(known, asked)});
    if (missing == Missing::half && best != 0)
      results.push_back({"nearest", returnedOnly, nearestRoom(known, asked, true)});
    if (drive.areRooms) continue;
    double sum = 0, squares = 0, nodes = 0;
    const auto n = static_cast<double>(options.orders);
    for (const auto& tour : ordersOfStays(known.frames, options.orders)) {
      const MappedRooms mapped = mapRooms(known, tour);
      sum += mapped.vMeasure / n;
      squares += mapped.vMeasure * mapped.vMeasure / n;
      nodes += mapped.nodes / n;
    }
    results.push_back({"v_measure", name, sum});
    results.push_back({"deviation", name, std::sqrt(std::max(0.0, squares - sum * sum))});
    results.push_back({"nodes", name, nodes});
    if (best == 0) break;  // there is nothing missing
  }
  return results;
}

std::string nameOf(std::size_t best) {
  return best == 0 ? "all" : fmt::format("{}", best);
}

Findings findingsOf(const DriveResults& results) {
  static const std::vector<std::pair<std::string, ResultTable::Column>> measures{
      {"v_measure", {"V-measure", 3, ResultTable::Best::none}},
      {"nodes", {"nodes", 1, ResultTable::Best::none}},
      {"nearest", {"nearest image", 3, ResultTable::Best::none}},
      {"accuracy", {"classifier", 3, ResultTable::Best::none}}};
  std::vector<std::string> names = {returnedOnly};
  for (const auto& [name, missing] : treatments) names.push_back(name);
  std::rotate(names.begin(), names.begin() + 1, names.end());
  Findings findings;
  findings.title = "Labelers that return their best labels only";
  results.each([&](std::size_t m, std::size_t d) {
    std::vector<ResultTable::Column> columns;
    std::vector<std::pair<std::string, std::string>> sources;
    for (const auto& [measure, column] : measures)
      for (const std::string& name : names)
        if (valueOf(results.of(m, d, 0), measure, name)) {
          columns.push_back(column);
          columns.back().name += ", " + name;
          sources.emplace_back(measure, name);
        }
    findings.sections.emplace_back(pivot(ResultTable{results.titleOf(m, d),
                                                     "By what stands for a missing label.",
                                                     "labels returned",
                                                     std::move(columns),
                                                     {}},
                                         results.variants, [&](std::size_t row, std::size_t column) {
                                           const auto& [measure, name] = sources[column];
                                           const CellResults& cell = results.of(m, d, row);
                                           const auto value = valueOf(cell, measure, name);
                                           return value || results.variants[row] != "all"
                                                      ? value
                                                      : valueOf(cell, measure, names[0]);
                                         }));
  });
  findings.summary =
      "Maps by words alone, the mean of several orders of the places; the nearest image of another "
      "visit; and a classifier of rooms.";
  return findings;
}

}  // namespace

DescriptorMatrix withBest(const DescriptorMatrix& all, std::size_t best, Missing missing) {
  if (best == 0 || best >= all.labels()) return all;
  DescriptorMatrix result(all.labels());
  result.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const DescriptorView row = all.row(i);
    std::vector<float> kept(row.size());
    double sum = 0;
    float least = 1;
    for (const std::size_t label : bestOf(row, best)) {
      kept[label] = row[label];
      sum += row[label];
      least = std::min(least, row[label]);
    }
    const auto share = static_cast<float>((1 - sum) / static_cast<double>(row.size() - best));
    // What is above 0 counts as returned.
    const float other =
        missing == Missing::share ? std::clamp(share, 1e-12F, std::max(least, 1e-12F)) : 1e-12F;
    if (missing != Missing::half)
      for (float& value : kept)
        if (value <= 0) value = other;
    result.append(kept);
  }
  return result;
}

MissingLabelsOptions readMissingLabels(ConfigFile& config) {
  MissingLabelsOptions options;
  const toml::array* drives = nullptr;
  const auto count = [&config](std::int64_t least) {
    return [&config, least](const toml::node& n) {
      return static_cast<std::size_t>(config.integer(n, least, 1'000'000));
    };
  };
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models to compare",
                each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
               {"best", false, "how many labels are returned; 0: all", each(config, options.best, count(0))},
               {"orders", false, "orders of the places", [&](auto& n) { options.orders = count(1)(n); }},
               {"drive", true, "[[drive]] names images of places or rooms",
                [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives) {
    MissingLabelsOptions::Drive drive;
    const toml::table *again = nullptr, *test = nullptr;
    drive.itself = readNamedDrive(
        config, config.subtable(node),
        {{"again", false, "places: the images that are found", [&](auto& n) { again = &config.subtable(n); }},
         {"test", false, "rooms: the images that are asked", [&](auto& n) { test = &config.subtable(n); }}});
    if ((again == nullptr) == (test == nullptr))
      config.fail(node, "a drive has either `again`, for places, or `test`, for rooms; give one of them");
    drive.areRooms = test != nullptr;
    drive.again = drive.itself.images;  // equal except for the labels
    config.read(drive.areRooms ? *test : *again, sourceKeys(config, drive.again, false));
    options.drives.push_back(std::move(drive));
  }
  return options;
}

GridColumns missingLabelsColumns() {
  return {
      {"model", "drive", "variant"}, "missing", {"v_measure", "deviation", "nodes", "nearest", "accuracy"}};
}

Findings compareMissingLabels(const MissingLabelsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress) {
  std::vector<NamedDrive> drives;
  std::vector<std::string> variants;
  for (const auto& drive : options.drives) drives.push_back(drive.itself);
  for (const std::size_t best : options.best) variants.push_back(nameOf(best));
  const auto driveOf = [&](const NamedDrive& named) -> const MissingLabelsOptions::Drive& {
    return *std::ranges::find(options.drives, named.name, [](const auto& d) { return d.itself.name; });
  };
  const auto inputs = [&](const NamedDrive& named, std::size_t) {
    return fmt::format("{} {} {} {}", missingLabelsVersion, options.orders, driveOf(named).areRooms,
                       digestOf(driveOf(named).again));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& named, std::size_t variant) {
    return judge(options, driveOf(named), options.best[variant], labeled);
  };
  return studyDrives({options.models, drives, variants, inputs, compute}, findingsOf, grid, run, progress);
}

}  // namespace estancia::experiments
