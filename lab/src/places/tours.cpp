// SPDX-License-Identifier: Apache-2.0
#include "places/tours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "places/place_orders.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr int toursVersion = 1;  // version of the code below: cells of another one are computed anew
const std::vector<std::string> visitNames{"views", "turning", "standing"};

/// A part of the 144 directions around a place, in order of time.
std::vector<std::size_t> directionsOf(Visit visit, Chance& chance) {
  std::vector<std::size_t> directions;
  const std::size_t start = chance.below(144);
  if (visit == Visit::views)
    for (std::size_t i = 0; i < 12; ++i) directions.push_back(start + 12 * i);
  if (visit == Visit::turning)
    for (std::size_t i = 0; i < 36; ++i) directions.push_back(start + 4 * i);
  if (visit == Visit::standing)
    for (std::size_t i = 0; i < 6; ++i) {
      // A head is never quite still.
      for (int k = 0; k < 12; ++k) directions.push_back(start + 24 * i + 143 + chance.below(3));
      for (std::size_t k = 1; k < 4; ++k) directions.push_back(start + 24 * i + 6 * k);
    }
  return directions;
}

/// How many images each place has.
std::size_t imagesAround(const DescriptorSequence& recording, const std::string& drive) {
  std::map<std::string, std::size_t> images;
  for (const Frame& frame : recording.frames) ++images[frame.room];
  const std::size_t around = images.begin()->second;
  const bool isEven = std::ranges::all_of(images, [around](const auto& i) { return i.second == around; });
  if (!isEven || 144 % around != 0)
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: a place has {} images; give each as many, evenly around: 144, 72, 48 or 36",
                            drive, around));
  return around;
}

std::string tourName(std::size_t places, std::size_t visits) {
  return fmt::format("{} places, {} visits", places, visits);
}

CellResults mapAll(const ToursOptions& options, const ToursOptions::Drive& drive, Visit visit,
                   LabeledDrives& labeled) {
  const DescriptorSequence& recording = labeled.of(drive.itself.images).recording;
  const std::size_t around = imagesAround(recording, drive.itself.name);
  std::vector<std::size_t> all;
  for (std::size_t p = drive.firstPlace; p < recording.frames.size() / around; p += drive.placeStep)
    all.push_back(p);
  CellResults results;
  for (const std::size_t count : drive.places) {
    if (count > all.size())
      throw Error(ErrorCode::insufficientData, fmt::format("{} has {} places, and a tour of {} is wanted",
                                                           drive.itself.name, all.size(), count));
    for (const std::size_t visits : options.visits) {
      double agreement = 0, nodes = 0;
      for (std::size_t t = 0; t < options.tours; ++t) {
        std::vector<std::size_t> places = all;
        Chance(t).shuffle(places);
        places.resize(count);
        const auto tour = tourOf(places, around, visits, visit, t);
        const MappedRooms mapped = mapRooms(recording, tour);
        agreement += mapped.vMeasure / static_cast<double>(options.tours);
        nodes += mapped.nodes / static_cast<double>(options.tours);
      }
      results.push_back({"v_measure", tourName(count, visits), agreement});
      results.push_back({"nodes", tourName(count, visits), nodes});
    }
  }
  return results;
}

ToursOptions::Drive readPlaces(ConfigFile& config, const toml::table& table) {
  ToursOptions::Drive drive;
  const auto count = [&config](const toml::node& n) {
    return static_cast<std::size_t>(config.integer(n, 1, 1000));
  };
  const auto half = [&](const toml::node& n) {
    drive.placeStep = 2;
    drive.firstPlace = config.choice<std::size_t>(n, {{"first", 0}, {"second", 1}});
  };
  drive.itself = readNamedDrive(
      config, table,
      {{"places", true, "how many places a tour has", each(config, drive.places, count)},
       {"half", false, "every other place only, from the \"first\" or the \"second\" one", half}});
  return drive;
}

}  // namespace

std::vector<std::size_t> tourOf(std::vector<std::size_t> places, std::size_t around, std::size_t visits,
                                Visit visit, std::uint64_t seed) {
  Chance chance(seed);
  std::vector<std::size_t> frames;
  for (std::size_t round = 0; round < visits; ++round) {
    const std::size_t last = places.back();
    if (round > 0) do {
        chance.shuffle(places);
      } while (places.size() > 1 && places.front() == last);
    for (const std::size_t place : places)
      for (const std::size_t direction : directionsOf(visit, chance))
        frames.push_back(place * around + direction % 144 * around / 144);
  }
  return frames;
}

ToursOptions readTours(ConfigFile& config) {
  ToursOptions options;
  const toml::array* drives = nullptr;
  const auto count = [&config](const toml::node& n) {
    return static_cast<std::size_t>(config.integer(n, 1, 10000));
  };
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models to compare",
                each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
               {"visits", false, "how often a tour comes to each place", each(config, options.visits, count)},
               {"tours", false, "how many tours the means are of",
                [&](const toml::node& n) { options.tours = count(n); }},
               {"drive", true, "[[drive]] names images all around some places",
                [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives) options.drives.push_back(readPlaces(config, config.subtable(node)));
  return options;
}

GridColumns toursColumns() {
  return {{"model", "drive", "variant"}, "tour", {"v_measure", "nodes"}};
}

Findings mapTours(const ToursOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress) {
  std::vector<NamedDrive> drives;
  for (const auto& drive : options.drives) drives.push_back(drive.itself);
  const auto driveOf = [&](const NamedDrive& named) -> const ToursOptions::Drive& {
    return *std::ranges::find(options.drives, named.name, [](const auto& d) { return d.itself.name; });
  };
  const auto inputs = [&](const NamedDrive& named, std::size_t) {
    const ToursOptions::Drive& drive = driveOf(named);
    std::string text =
        fmt::format("{} {} {} {} visits", toursVersion, drive.firstPlace, drive.placeStep, options.tours);
    for (const std::size_t n : options.visits) text += fmt::format(" {}", n);
    text += " places";
    for (const std::size_t n : drive.places) text += fmt::format(" {}", n);
    return text;
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& named, std::size_t visit) {
    return mapAll(options, driveOf(named), static_cast<Visit>(visit), labeled);
  };
  return studyDrives({options.models, drives, visitNames, inputs, compute}, toursFindings, grid, run,
                     progress);
}

Findings toursFindings(const DriveResults& results) {
  Findings findings;
  findings.title = "Tours of few and many places";
  for (std::size_t d = 0; d < results.drives.size(); ++d)
    for (std::size_t m = 0; m < results.models.size(); ++m) {
      std::vector<std::string> tours;
      for (const CellResult& result : results.of(m, d))
        if (result.measure == "v_measure") tours.push_back(result.at);
      std::vector<ResultTable::Column> columns;
      for (const char* measure : {"V-measure", "nodes"})
        for (const std::string& variant : results.variants)
          columns.push_back({fmt::format("{}, {}", measure, variant), measure[0] == 'V' ? 3 : 1});
      const std::size_t variants = results.variants.size();
      findings.sections.emplace_back(
          pivot(ResultTable{results.titleOf(m, d),
                            "Mean V-measure of the places against the true ones, and their number.",
                            "tour",
                            std::move(columns),
                            {}},
                tours, [&](std::size_t row, std::size_t column) {
                  return valueOf(results.of(m, d, column % variants),
                                 column < variants ? "v_measure" : "nodes", tours[row]);
                }));
    }
  findings.summary = "Tours mapped with the defaults, by words alone.";
  return findings;
}

}  // namespace estancia::experiments
