// SPDX-License-Identifier: Apache-2.0
#include "recognition/known_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/stats/proportion.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: cells of another one are computed anew
constexpr int knownObjectsVersion = 1;

using Clock = std::chrono::steady_clock;

constexpr std::array<std::string_view, 2> halves{"choosing", "reporting"};

DepthFrameSource readSource(ConfigFile& config, const toml::table& table) {
  DepthFrameSource source;
  config.read(table, {{"name", true, "what to call them", [&](auto& n) { source.name = config.text(n); }},
                      {"path", true, "the folder", [&](auto& n) { source.path = config.anywhere(n); }},
                      {"frames", false, "", [&](auto& n) {
                         source.frames = static_cast<std::size_t>(config.integer(n, 1, 1'000'000));
                       }}});
  return source;
}

/// Counts of a part of the searches.
struct SearchCounts {
  double searched = 0, accepted = 0, wrong = 0, maybe = 0, refused = 0, seconds = 0;

  SearchCounts& operator+=(const SearchCounts& other) {
    searched += other.searched;
    accepted += other.accepted;
    wrong += other.wrong;
    maybe += other.maybe;
    refused += other.refused;
    seconds += other.seconds;
    return *this;
  }
};

using Parts = std::map<std::string, SearchCounts>;

CellResults resultsOf(const Parts& parts) {
  CellResults results;
  for (const auto& [part, counts] : parts)
    for (const auto& [measure, value] : {std::pair{"searched", counts.searched},
                                         {"accepted", counts.accepted},
                                         {"wrong", counts.wrong},
                                         {"maybe", counts.maybe},
                                         {"refused", counts.refused},
                                         {"seconds", counts.seconds}})
      results.push_back({measure, part, value});
  return results;
}

/// The mean distance of a model's points in a pose from those in the true one [m].
double surfaceDistance(const PointCloud& model, const cv::Affine3d& found, const cv::Affine3d& truth) {
  constexpr std::size_t tried = 500;
  const Neighbors there(model.points);
  const cv::Affine3f back(truth.inv() * found);
  const std::size_t step = std::max<std::size_t>(1, model.points.size() / tried);
  std::vector<Neighbor> buffer;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < model.points.size(); i += step, ++count) {
    const cv::Point3f p = back * model.points[i];
    sum += std::sqrt(static_cast<double>(there.nearest(p, 1, buffer).front().squared));
  }
  return sum / static_cast<double>(count);
}

/// What of a model is looked for.
struct Side {
  const char* name;
  PointCloud MadeUpModel::*cloud;
};
constexpr std::array<Side, 2> sides{{{"one side", &MadeUpModel::oneSided}, {"whole", &MadeUpModel::whole}}};

/// Models, each prepared once, and what is found of them.
class KnownObjectSearcher {
 public:
  explicit KnownObjectSearcher(const KnownObjectsOptions& options)
      : options_(options), recognizer_(optionsOf(options)) {
    for (MadeUpModel& model : madeUpModels(options.seed)) {
      if (!options.families.empty() &&
          std::ranges::find(options.families, model.family) == options.families.end())
        continue;
      Entry entry{std::move(model), {}};
      for (std::size_t s = 0; s < sides.size(); ++s)
        entry.prepared[s] = recognizer_.prepareModel(entry.model.name, entry.model.*sides[s].cloud);
      entries_.push_back(std::move(entry));
    }
  }

  /// All models, none of which is there.
  Parts absent(const DepthFrame& frame) const {
    Parts parts;
    const auto scene = prepared(frame.depth, frame);
    for (const Entry& entry : entries_)
      for (std::size_t s = 0; s < sides.size(); ++s) {
        SearchCounts& counts = parts[fmt::format("{}, {}", entry.model.family, sides[s].name)];
        const auto [sure, maybe] = look(entry, s, *scene, counts);
        counts.accepted += sure.empty() ? 0 : 1;
        counts.wrong += static_cast<double>(sure.size());
        counts.maybe += sure.empty() && !maybe.empty() ? 1 : 0;
      }
    return parts;
  }

  /// One model of each family, another one in the next frame; each placed in one of the ways, and hidden or
  /// not.
  Parts present(const DepthFrame& frame, std::size_t number) const {
    constexpr std::array<Placement, 4> ways{Placement::standing, Placement::lying, Placement::stacked,
                                            Placement::byWall};
    constexpr std::array<double, 4> hidden{0, 0.25, 0.45, 0.6};
    Parts parts;
    std::map<std::string, std::size_t> seen;
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      const Entry& entry = entries_[e];
      const std::size_t size = seen[entry.model.family]++;
      if (size != number % 3) continue;
      const std::uint64_t seed = options_.seed * 1'000'003 + number * 101 + e;
      const Placement placement = ways[(number / 3 + e) % 4];
      const double cover = hidden[(number / 2 + e / 3) % 4];
      count(entry, 1, placement, cover, frame, seed, parts);
      count(entry, 0, Placement::standing, cover, frame, seed, parts);
    }
    return parts;
  }

 private:
  struct Entry {
    MadeUpModel model;
    std::array<std::shared_ptr<const PreparedModel>, sides.size()> prepared;
  };
  struct Found {
    std::vector<Detection> sure, maybe;
  };

  static RecognitionOptions optionsOf(const KnownObjectsOptions& options) {
    RecognitionOptions recognition = RecognitionOptions::preset(options.preset);
    recognition.threads = 1;  // cells are taken side by side
    return recognition;
  }

  std::shared_ptr<const PreparedScene> prepared(const cv::Mat& depth, const DepthFrame& frame) const {
    return recognizer_.prepareScene(frame.name, backProject(depth, frame.camera));
  }

  Found look(const Entry& entry, std::size_t side, const PreparedScene& scene, SearchCounts& counts) const {
    Found found;
    const auto start = Clock::now();
    try {
      found.sure = recognizer_.verify({recognizer_.search(*entry.prepared[side], scene)}, &found.maybe);
    } catch (const Interrupted&) {
      throw;
    } catch (const Error&) {
      ++counts.refused;  // a plane, whose pose is undefined
    }
    counts.seconds += std::chrono::duration<double>(Clock::now() - start).count();
    ++counts.searched;
    return found;
  }

  void count(const Entry& entry, std::size_t side, Placement placement, double hidden,
             const DepthFrame& frame, std::uint64_t seed, Parts& parts) const {
    const auto placed = place(entry.model, frame, placement, hidden, side == 0, seed);
    if (!placed) return;
    const std::string seen = placed->hidden > 0.5 ? "less than half seen" : nameOf(placement);
    SearchCounts& counts = parts[fmt::format("{}, {}, {}", entry.model.family, sides[side].name, seen)];
    const Found found = look(entry, side, *prepared(placed->depth, frame), counts);
    cv::Affine3d truth = placed->pose;
    if (side == 0) truth = truth * entry.model.view;
    const auto isRight = [&](const Detection& one) {
      return surfaceDistance(entry.model.*sides[side].cloud, one.pose, truth) <
             options_.distance * entry.model.diameter();
    };
    const auto right = static_cast<double>(std::ranges::count_if(found.sure, isRight));
    counts.accepted += right > 0 ? 1 : 0;
    counts.wrong += static_cast<double>(found.sure.size()) - std::min(right, 1.0);
    counts.maybe += right == 0 && std::ranges::any_of(found.maybe, isRight) ? 1 : 0;
  }

  const KnownObjectsOptions& options_;
  Recognizer recognizer_;
  std::vector<Entry> entries_;
};

struct Task {
  std::size_t source, frame;
  std::string name;
  bool present;
};

Parts sumOf(const std::vector<Task>& tasks, const std::vector<CellResults>& found, std::size_t source,
            std::size_t half, bool present) {
  Parts sum;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (tasks[i].source != source || tasks[i].frame % 2 != half || tasks[i].present != present) continue;
    for (const CellResult& result : found[i]) {
      if (result.measure != "searched") continue;
      const auto get = [&](const char* measure) { return valueOf(found[i], measure, result.at).value_or(0); };
      const SearchCounts counts{result.value, get("accepted"), get("wrong"),
                                get("maybe"), get("refused"),  get("seconds")};
      sum[result.at] += counts;
      sum["z all"] += counts;  // the last
    }
  }
  return sum;
}

ResultTable tableOf(const std::string& title, const Parts& parts, bool present) {
  ResultTable table;
  table.title = title;
  table.caption =
      present ? "Models that were put there, one at a time, and found in the right pose; from … to: 95 % "
                "interval (Wilson). Wrong: other instances. Maybe: found, but not sure. Refused: as a plane."
              : "Models that are not there, one at a time, of which an instance was accepted; from … to: 95 "
                "% interval (Wilson). Wrong: instances. Maybe: those that have none but such as may be.";
  table.rowsAre = "models";
  using Best = ResultTable::Best;
  table.columns = {{"searched", 0},
                   {present ? "found" : "accepted", 0},
                   {"%", 1, present ? Best::largest : Best::smallest},
                   {"from", 1},
                   {"to", 1},
                   {"wrong", 0, Best::smallest},
                   {"maybe", 0},
                   {"refused", 0},
                   {"s", 2}};
  for (const auto& [part, counts] : parts) {
    const auto [low, high] = wilsonInterval(counts.accepted / counts.searched, counts.searched);
    table.rows.push_back(
        {part == "z all" ? "all" : part,
         {counts.searched, counts.accepted, 100 * counts.accepted / counts.searched, 100 * low, 100 * high,
          counts.wrong, counts.maybe, counts.refused, counts.seconds / counts.searched}});
  }
  return table;
}

}  // namespace

KnownObjectsOptions readKnownObjects(ConfigFile& config) {
  KnownObjectsOptions options;
  OptionGroup group("known-objects", "Known objects in depth frames.");
  group.add("preset", &options.preset, "Preset of recognition").choices(RecognitionOptions::presets());
  group.add("distance", &options.distance, "Largest ADD-S of a right pose, as a share of the diameter")
      .range(0, 10);
  group.add("seed", &options.seed, "Seed of models and places").range(0, 1e9);
  const std::vector<std::string> halfNames(halves.begin(), halves.end());
  config.read(together(
      keysOf(config, std::move(group)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"halves", false, "", each(config, options.halves, oneOf(config, halfNames))},
       {"families", false, "", each(config, options.families, [&config](auto& n) { return config.text(n); })},
       {"frames", true, "depth frames", [&](auto& n) {
          for (const toml::node& one : config.list(n))
            options.sources.push_back(readSource(config, config.subtable(one)));
        }}}));
  return options;
}

GridColumns knownObjectsColumns() {
  return {{"frames", "half", "scene", "task"},
          "part",
          {"searched", "accepted", "wrong", "maybe", "refused", "seconds"}};
}

Findings compareKnownObjects(const KnownObjectsOptions& options, Grid& grid, const ExperimentRun& run,
                             Progress& progress) {
  refuseModels(run, "recognition");
  std::vector<Task> tasks;
  std::vector<Cell> cells;
  for (std::size_t s = 0; s < options.sources.size(); ++s) {
    const DepthFrameSource& source = options.sources[s];
    const std::vector<std::string> names = namesOfFrames(source);
    for (std::size_t f = 0; f < names.size(); ++f) {
      const std::string half(halves[f % 2]);
      if (std::ranges::find(options.halves, half) == options.halves.end()) continue;
      for (const bool present : {false, true}) {
        tasks.push_back({s, f, names[f], present});
        cells.push_back({{source.name, half, names[f], present ? "present" : "absent"},
                         sha256(fmt::format("{} {} {} {} {} {} {}", knownObjectsVersion, source.path.string(),
                                            names[f], f, options.preset, options.distance, options.seed))});
      }
    }
  }
  const KnownObjectSearcher searcher(options);
  const auto found = grid.run(
      cells,
      [&](std::size_t i) {
        const DepthFrame frame = readFrame(options.sources[tasks[i].source], tasks[i].frame);
        return resultsOf(tasks[i].present ? searcher.present(frame, tasks[i].frame) : searcher.absent(frame));
      },
      progress, "looking for known objects");
  Findings findings;
  findings.title = "Known objects in depth frames";
  for (const bool present : {false, true})
    for (std::size_t half = 0; half < halves.size(); ++half)
      for (std::size_t s = 0; s < options.sources.size(); ++s)
        if (const Parts parts = sumOf(tasks, found, s, half, present); !parts.empty())
          findings.sections.emplace_back(tableOf(fmt::format("{} in {} ({})", present ? "Present" : "Absent",
                                                             options.sources[s].name, halves[half]),
                                                 parts, present));
  findings.facts = {
      {"Halves", "even frames are for choosing, odd ones for reporting"},
      {"Poses", fmt::format("right where ADD-S is below {:.0f} % of the diameter", 100 * options.distance)}};
  findings.summary = "Made-up models, one at a time, in real depth frames.";
  return findings;
}

}  // namespace estancia::experiments
