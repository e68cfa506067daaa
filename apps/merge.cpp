// estancia merge: one map of several.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <mutex>

#include "common.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/processes/work_queue.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct MergeArguments {
  std::vector<std::string> maps;
  std::string output;
  bool overwrite = false, json = false;
};

/// Meaning of the maps' numbers.
std::string listOf(const std::vector<std::filesystem::path>& maps) {
  std::string list;
  for (const auto& map : maps) list += map.string() + "\n";
  return sha256(list);
}

/// In all processes that mpirun started; what the first one has.
MergedMaps mergeTogether(WorkQueue& queue, const std::vector<std::filesystem::path>& maps,
                         const std::string& output, ExistingMap existing, Progress& progress) {
  ShareWork share{.leads = queue.isFirst()};
  share.run = [&](std::size_t pieces, const std::function<std::string(std::size_t)>& work) {
    std::mutex mutex;
    progress.begin("comparing maps", pieces, 0);
    std::vector<std::string> results = queue.results(listOf(maps), pieces, work, [&] {
      const std::lock_guard lock(mutex);
      progress.advance();
    });
    progress.end();
    return results;
  };
  MergedMaps merged;
  queue.together([&] { merged = mergeMaps(maps, output, existing, progress, share); });
  return merged;
}

void run(const MergeArguments& arguments) {
  const std::vector<std::filesystem::path> maps(arguments.maps.begin(), arguments.maps.end());
  const ExistingMap existing = arguments.overwrite ? ExistingMap::replace : ExistingMap::refuse;
  MergedMaps merged;
  const Processes processes = joinProcesses();
  if (processes.queue)
    merged = mergeTogether(*processes.queue, maps, arguments.output, existing, *processes.progress);
  else
    merged = mergeMaps(maps, arguments.output, existing, *processes.progress);
  if (!processes.speaks()) return;
  for (const std::string& conflict : merged.conflicts) spdlog::warn("{}", conflict);
  if (arguments.json) {
    Json parts = Json::array();
    for (const MergedMaps::Part& part : merged.parts)
      parts.push_back({{"recognized", part.isRecognized}, {"aligned", part.isAligned}});
    return print(Json{{"map", arguments.output},
                      {"drives", merged.drives},
                      {"frames", merged.frames},
                      {"nodes", merged.places},
                      {"merged", std::move(parts)},
                      {"conflicts", merged.conflicts}});
  }
  fmt::print("{}: {}, {}, {}\n", printable(arguments.output), counted(merged.drives, "drive"),
             counted(merged.frames, "frame"), counted(merged.places, "place"));
  for (std::size_t i = 0; i < merged.parts.size(); ++i) {
    const MergedMaps::Part& part = merged.parts[i];
    fmt::print("  {}: shares {} with the maps before", printable(arguments.maps[i + 1]),
               part.isRecognized ? "places" : "no place");
    if (part.hasPoses) fmt::print(", its poses are {}known in the merged map", part.isAligned ? "" : "not ");
    fmt::print("\n");
  }
}

}  // namespace

void addMergeMapsCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("merge", "Make one map of several: of other drives, robots or floors");
  auto arguments = std::make_shared<MergeArguments>();
  command->add_option("MAPS", arguments->maps, "The map files; the first one gives the frame of the poses")
      ->required()
      ->expected(2, -1);
  addOutputOption(*command, arguments->output, "The merged map, NAME.estancia")->required();
  addOverwriteOption(*command, arguments->overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia merge day.estancia evening.estancia -o home.estancia\n"
              "  mpirun -n 8 estancia merge robots/*.estancia -o building.estancia");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
