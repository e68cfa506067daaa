// SPDX-License-Identifier: Apache-2.0
#include "recognition/bop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/files.hpp"
#include "estancia/processes/work_queue.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "recognition/bop_measures.hpp"
#include "recognition/bop_results.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: cells of another one are computed anew
constexpr int bopVersion = 1;

/// A name that is a part of file names.
std::string plainName(const ConfigFile& config, const toml::node& node, const std::string& more) {
  const std::string name = config.text(node);
  const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789" + more;
  if (name.empty() || name[0] == '.' || name.find_first_not_of(plain) != std::string::npos)
    config.fail(node, fmt::format("`{}` must be letters, digits and {}", config.key(), more));
  return name;
}

BopSource readBopSource(ConfigFile& config, const toml::table& table) {
  BopSource source;
  config.read(table,
              {{"name", true, "as in the names of results, \"lmo\"",
                [&](auto& n) { source.name = plainName(config, n, "-"); }},
               {"path", true, "the folder", [&](auto& n) { source.path = config.anywhere(n); }},
               {"split", false, "", [&](auto& n) { source.split = plainName(config, n, "-_"); }},
               {"targets", false, "", [&](auto& n) { source.targets = plainName(config, n, "-_."); }},
               {"images", false, "",
                [&](auto& n) { source.images = static_cast<std::size_t>(config.integer(n, 0, 1'000'000)); }},
               {"delta", false, "", [&](auto& n) { source.delta = config.number(n, 0, 1000) / 1000; }},
               {"results", false, "", [&](auto& n) { source.results = config.anywhere(n); }},
               {"optional", false, "", [&](auto& n) { source.optional = config.flag(n); }}});
  return source;
}

/// The objects of a data set, each prepared once.
class BopRecognizer {
 public:
  BopRecognizer(const BopOptions& options, const BopData& data) : recognizer_(optionsOf(options)) {
    constexpr double step = 0.01;  // share of the diameter
    for (const auto& [id, object] : data.objects)
      prepared_[id] = recognizer_.prepareModel(fmt::format("obj_{:06}", id),
                                               sampleMesh(object.mesh, step * object.diameter));
  }

  /// None of what cannot be searched: depth of nothing, a model that is a plane.
  std::vector<BopEstimate> estimate(const BopImage& image, const DepthFrame& frame) const {
    const auto start = std::chrono::steady_clock::now();
    std::vector<BopEstimate> estimates;
    attempt([&] {
      const auto scene = recognizer_.prepareScene(frame.name, backProject(frame.depth, frame.camera));
      std::vector<PoseCandidates> candidates;
      for (const BopTarget& target : image.targets)
        attempt([&] { candidates.push_back(recognizer_.search(*prepared_.at(target.object), *scene)); });
      std::vector<Detection> maybe, sure = recognizer_.verify(candidates, &maybe);
      sure.insert(sure.end(), maybe.begin(), maybe.end());
      for (const Detection& one : sure)
        estimates.push_back(
            {image.scene, image.image, std::stoi(one.model.substr(4)), one.confidence, one.pose});
    });
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    for (BopEstimate& one : estimates) one.seconds = took.count();
    return estimates;
  }

 private:
  static RecognitionOptions optionsOf(const BopOptions& options) {
    RecognitionOptions recognition = RecognitionOptions::preset(options.preset);
    recognition.falseAlarmRate = options.falseAlarmRate;
    recognition.threads = 1;  // cells are taken side by side
    return recognition;
  }

  template <class Work>
  static void attempt(const Work& work) {
    try {
      work();
    } catch (const Interrupted&) {
      throw;
    } catch (const Error&) {
      // Its targets count as missed.
    }
  }

  Recognizer recognizer_;
  std::map<int, std::shared_ptr<const PreparedModel>> prepared_;
};

/// The scores of the targets, and after them the numbers of the estimates, from which the file is written.
CellResults judgeImage(const BopSource& source, const BopData& data, const BopImage& image,
                       const DepthFrame& frame, std::vector<BopEstimate> estimates) {
  std::ranges::stable_sort(estimates, std::greater(), &BopEstimate::score);
  CellResults results;
  std::vector<double> numbers;
  for (const BopTarget& target : image.targets) {
    std::vector<cv::Affine3d> poses;
    for (const BopEstimate& one : estimates) {
      if (one.object != target.object || poses.size() == target.instances) continue;
      poses.push_back(one.pose);
      numbers.insert(numbers.end(), {static_cast<double>(one.object), one.score, one.seconds});
      numbers.insert(numbers.end(), one.pose.matrix.val, one.pose.matrix.val + 12);
    }
    const BopScore score =
        judgeEstimates(target, data.objects.at(target.object), poses, image, frame, source.delta);
    for (const auto& [measure, value] : {std::pair{"targets", score.targets},
                                         {"estimates", static_cast<double>(poses.size())},
                                         {"vsd", score.vsd},
                                         {"mssd", score.mssd},
                                         {"mspd", score.mspd}})
      results.push_back({measure, std::to_string(target.object), value});
  }
  for (const double number : numbers) results.push_back({"number", "", number});
  return results;
}

/// The estimates of a cell that judgeImage() made.
void addEstimates(const BopImage& image, const CellResults& results, std::vector<BopEstimate>& all) {
  std::vector<double> numbers;
  for (const CellResult& result : results)
    if (result.measure == "number") numbers.push_back(result.value);
  for (std::size_t i = 0; i + 15 <= numbers.size(); i += 15) {
    cv::Affine3d pose;
    std::copy_n(&numbers[i + 3], 12, pose.matrix.val);
    all.push_back(
        {image.scene, image.image, static_cast<int>(numbers[i]), numbers[i + 1], pose, numbers[i + 2]});
  }
}

/// The mean time of an image that has estimates [s]; none where it is unknown.
std::optional<double> timeOf(const std::vector<BopEstimate>& estimates) {
  std::map<std::pair<int, int>, double> times;
  double sum = 0;
  for (const BopEstimate& one : estimates) times[{one.scene, one.image}] = one.seconds;
  for (const auto& [image, seconds] : times) sum += seconds < 0 ? NAN : seconds;
  sum /= static_cast<double>(times.size());
  return std::isfinite(sum) ? std::optional(sum) : std::nullopt;
}

ResultTable bopTable(const std::string& title, const BopData& data, const std::vector<CellResults>& cells,
                     std::optional<double> time) {
  ResultTable table;
  table.title = title;
  table.caption =
      "Average recall [%] by VSD, MSSD and MSPD, and the mean of the three (AR), as in the BOP challenge of "
      "2019: of as many instances as are to be found, the most visible ones. s: time of an image.";
  table.rowsAre = "object";
  table.columns = {{"targets", 0}, {"estimates", 0}, {"AR VSD", 1}, {"AR MSSD", 1},
                   {"AR MSPD", 1}, {"AR", 1},        {"s", 2}};
  const auto addRow = [&](const std::string& name, const BopScore& s, double estimates,
                          std::optional<double> t) {
    const double share = s.targets > 0 ? 100 / s.targets : 0;
    table.rows.push_back(
        {name, {s.targets, estimates, share * s.vsd, share * s.mssd, share * s.mspd, 100 * s.recall(), t}});
  };
  BopScore all;
  double allEstimates = 0;
  for (const auto& entry : data.objects) {
    const std::string object = std::to_string(entry.first);
    BopScore sum;
    double estimates = 0;
    for (const CellResults& cell : cells) {
      const auto get = [&](const char* measure) { return valueOf(cell, measure, object).value_or(0); };
      sum += {get("targets"), get("vsd"), get("mssd"), get("mspd")};
      estimates += get("estimates");
    }
    addRow(object, sum, estimates, {});
    all += sum;
    allEstimates += estimates;
  }
  addRow("all", all, allEstimates, time);
  return table;
}

/// Finds and judges the targets of one data set.
void runSource(const BopOptions& options, const BopSource& source, Grid& grid, const ExperimentRun& run,
               Progress& progress, Findings& findings) {
  const BopData data = readBop(source);
  const bool given = !source.results.empty();
  std::map<std::pair<int, int>, std::vector<BopEstimate>> theirs;
  if (given)
    for (const BopEstimate& one : readBopResults(source.results))
      theirs[{one.scene, one.image}].push_back(one);
  const std::string how = given ? sha256(io::readBytes(source.results, std::size_t{1} << 30U))
                                : fmt::format("{} {}", options.preset, options.falseAlarmRate);
  std::vector<Cell> cells;
  for (const BopImage& image : data.images)
    cells.push_back({{source.name, std::to_string(image.scene), std::to_string(image.image)},
                     sha256(fmt::format("{} {} {} {} {} {}", bopVersion, source.path.string(), source.split,
                                        source.targets, source.delta, how))});
  const auto recognizer = given ? nullptr : std::make_unique<const BopRecognizer>(options, data);
  const auto found = grid.run(
      cells,
      [&](std::size_t i) {
        const BopImage& image = data.images[i];
        const DepthFrame frame = readBopDepth(image);
        if (recognizer) return judgeImage(source, data, image, frame, recognizer->estimate(image, frame));
        const auto there = theirs.find({image.scene, image.image});
        return judgeImage(source, data, image, frame,
                          there == theirs.end() ? std::vector<BopEstimate>() : there->second);
      },
      progress, "looking for the targets of " + source.name);
  std::vector<BopEstimate> estimates;
  for (std::size_t i = 0; i < found.size(); ++i) addEstimates(data.images[i], found[i], estimates);
  findings.sections.emplace_back(bopTable(source.name, data, found, timeOf(estimates)));
  if (source.images > 0)
    findings.notes.push_back(fmt::format("{}: {} images only; the recall of all is what compares with others",
                                         source.name, data.images.size()));
  if (given || (run.distribution != nullptr && !run.distribution->isFirst())) return;
  std::string split = source.split;
  std::ranges::replace(split, '_', '-');
  const std::string name = fmt::format("estancia_{}-{}.csv", source.name, split);
  writeBopResults(run.folder / name, estimates);
  findings.facts.emplace_back("Results of " + source.name, name);
}

}  // namespace

BopOptions readBopOptions(ConfigFile& config) {
  BopOptions options;
  OptionGroup group("bop", "Data sets of the BOP challenge.");
  group.add("preset", &options.preset, "Preset of recognition").choices(RecognitionOptions::presets());
  group.add("false_alarm_rate", &options.falseAlarmRate, "Rate of false alarms that recognition allows")
      .above(0, 1);
  config.read(together(keysOf(config, std::move(group)),
                       {{"type", true, "the kind of experiment", [](auto&) {}},
                        {"dataset", true, "data sets in the layout of BOP", [&](auto& n) {
                           for (const toml::node& one : config.list(n)) {
                             options.sources.push_back(readBopSource(config, config.subtable(one)));
                             if (std::ranges::count(options.sources, options.sources.back().name,
                                                    &BopSource::name) > 1)
                               config.fail(one, "two data sets have the same name; give each its own");
                           }
                         }}}));
  return options;
}

GridColumns bopColumns() {
  return {{"dataset", "scene", "image"}, "object", {"targets", "estimates", "vsd", "mssd", "mspd"}};
}

Findings compareWithBop(const BopOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress) {
  refuseModels(run, "recognition");
  Findings findings;
  findings.title = "Data sets of the BOP challenge";
  findings.summary = "Known objects that are there, found in depth images alone.";
  findings.facts = {{"Recognition", fmt::format("preset {}, rate of false alarms {}", options.preset,
                                                options.falseAlarmRate)}};
  for (const BopSource& source : options.sources)
    if (source.optional && !std::filesystem::exists(source.path))
      findings.notes.push_back(fmt::format("{} is not there and was left out", source.path.string()));
    else
      runSource(options, source, grid, run, progress, findings);
  if (findings.sections.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("none of the data sets is there; unpack {}, or name a `path` of yours",
                            options.sources.empty() ? "one" : options.sources.front().path.string()));
  return findings;
}

}  // namespace estancia::experiments
