// estancia live: a camera, or a recording that is played → a map that grows, or where in a map it is.
// SPDX-License-Identifier: Apache-2.0
#include "live.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/live/live_loop.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/site/ros_publisher.hpp"
#include "estancia/sources/frame_source.hpp"
#include "estancia/sources/ros_source.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_options.hpp"
#include "labeling.hpp"
#include "page_service.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct LiveArguments {
  explicit LiveArguments(CLI::App& command) : declared(command) {}
  std::string source, output, localize;
  FrameSourceOptions sources;
  ModelArguments model;
  MapperOptions mapper;
  MapBudget budget;
  WorldOptions world;
  LocalizerOptions localizer;
  PageArguments page;
  DeclaredOptions declared;
  bool json = false, list = false, publish = false, posesInMap = false;

  const std::string& map() const { return localize.empty() ? output : localize; }
};

Json poseJson(const std::optional<Pose>& pose) {
  if (!pose) return nullptr;
  return {{"position", {pose->x, pose->y, pose->z}},
          {"orientation", {pose->qx, pose->qy, pose->qz, pose->qw}}};
}

Json frameJson(const LiveStatus& now) {
  Json words = Json::array();
  for (const LabelProbability& word : now.words)
    words.push_back({{"word", word.label}, {"p", word.probability}});
  Json json{{"frame", now.frame},
            {"timestamp", now.timestamp ? Json(*now.timestamp) : Json()},
            {"pose", poseJson(now.pose)},
            {"place", now.places.empty() ? Json() : Json(now.places.front().node)},
            {"place_p", now.places.empty() ? Json() : Json(now.places.front().probability)},
            {"area", now.area < 0 ? Json() : Json(now.area)},
            {"area_name", now.area < 0 ? Json() : Json(now.areaName)},
            {"words", words},
            {"decision", now.decision},
            {"dropped", now.dropped},
            {"failed", now.failed},
            {"latency_ms", now.latency}};
  if (now.unmapped) json["unmapped"] = *now.unmapped;
  if (!now.troubles.empty()) json["troubles"] = now.troubles;
  return json;
}

/// Progress on the terminal: one line that is written over, and each trouble once. In a thread of its own, so
/// that a slow terminal costs the mapping nothing.
class StatusLine {
 public:
  StatusLine(const LiveView& live, bool json)
      : live_(live), shows_(!json && isatty(STDERR_FILENO) == 1), thread_([this] { run(); }) {}
  ~StatusLine() {
    over_ = true;
    thread_.join();
    clear();
  }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

 private:
  void run() {
    constexpr auto patience = std::chrono::milliseconds(200);
    for (std::uint64_t revision = 0; !over_;) {
      const LiveStatus now = live_.waitForChange(revision, patience);
      if (now.revision == revision) continue;
      revision = now.revision;
      warn(now);
      if (shows_) show(now);
    }
  }
  void warn(const LiveStatus& now) {
    for (const std::string& trouble : now.troubles)
      if (std::ranges::find(told_, kindOf(trouble)) == told_.end()) {
        clear();
        spdlog::warn("{}", printable(trouble));
      }
    told_.clear();
    for (const std::string& trouble : now.troubles) told_.push_back(kindOf(trouble));
  }
  /// Without its numbers, which change.
  static std::string kindOf(std::string trouble) {
    std::erase_if(trouble, [](char c) { return c >= '0' && c <= '9'; });
    return trouble;
  }
  void show(const LiveStatus& now) {
    std::string words;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, now.words.size()); ++i)
      words += (i == 0 ? "" : ", ") + now.words[i].label;
    const std::string place = now.places.empty() ? "" : fmt::format(", place {}", now.places.front().node);
    const std::string line = fmt::format(
        "{}: {}{}{}  {:.1f}/s, {:.0f} ms, {} dropped  {}", now.state, counted(now.frames, "frame"), place,
        now.area < 0 ? "" : " in " + now.areaName, now.rate, now.medianLatency, now.dropped, words);
    fmt::print(stderr, "\r{}\x1b[K", report::shorten(line, 110));
    std::fflush(stderr);
    isShown_ = true;
  }
  void clear() {
    if (isShown_) fmt::print(stderr, "\r\x1b[K");
    isShown_ = false;
  }

  const LiveView& live_;
  bool shows_, isShown_ = false;
  std::vector<std::string> told_;
  std::atomic<bool> over_ = false;
  std::thread thread_;  // last: it uses all others
};

void printSummary(const LiveArguments& arguments, const LiveLoop& live) {
  const LiveStatus now = live.status();
  const auto world = live.world();
  if (arguments.json)
    return print({{"map", arguments.map()},
                  {"frames", now.frames},
                  {"dropped", now.dropped},
                  {"failed", now.failed},
                  {"places", world ? world->places.nodes.size() : 0},
                  {"areas", world ? world->areas.size() : 0},
                  {"objects", world ? world->objects.size() : 0},
                  {"latency_ms", {{"median", now.medianLatency}, {"p95", now.p95Latency}}},
                  {"forward_ms", now.forward}});
  fmt::print("{}: {} ({} dropped, {} unusable)", printable(arguments.map()), counted(now.frames, "frame"),
             now.dropped, now.failed);
  if (now.frames == 0) return fmt::print("; no new frame came\n");
  if (world)
    fmt::print("; {}, {}, {}", counted(world->places.nodes.size(), "place"),
               counted(world->areas.size(), "area"), counted(world->objects.size(), "object"));
  fmt::print("\n  from a frame to its place {:.0f} ms (95 % below {:.0f} ms), the network alone {:.0f} ms\n",
             now.medianLatency, now.p95Latency, now.forward);
}

/// A run that has mapped nothing has failed, unless a recording is mapped already.
void requireFrames(const LiveArguments& arguments, const LiveStatus& now) {
  if (now.frames > 0 || std::filesystem::exists(arguments.map())) return;
  throw Error(
      ErrorCode::insufficientData,
      fmt::format("no image of {} could be used, so there is no map{}{}", printable(arguments.source),
                  now.troubles.empty() ? "" : ": ", now.troubles.empty() ? "" : now.troubles.front()));
}

void run(const LiveArguments& arguments) {
  LiveOptions options;
  options.localize = !arguments.localize.empty();
  options.localizer = arguments.localizer;
  options.posesAreInMap = arguments.posesInMap;
  options.changeMapper = [&](MapperOptions& mapper) { arguments.declared.applyTo(declare(mapper)); };
  options.changeBudget = [&](MapBudget& budget) { arguments.declared.applyTo(declare(budget)); };
  options.changeWorld = [&](WorldOptions& world) { arguments.declared.applyTo(declare(world)); };
  const auto labeler = loadModel(arguments.model.model.empty() ? defaultModel : arguments.model.model,
                                 arguments.model.options);
  auto source = makeFrameSource(arguments.source, arguments.sources);
  for (const std::string& warning : source->warnings()) spdlog::warn("{}", warning);
  LiveLoop live(std::move(source), *labeler, arguments.map(), options);
  {
    const PageService page(live, arguments.page, [&live] { live.stop(); });
    std::optional<RosPublisher> ros;
    if (arguments.publish) ros.emplace(live, ros::makeDdsNode(rosDomain()));
    const StatusLine line(live, arguments.json);
    live.run([&arguments](const LiveStatus& now) {
      if (arguments.json) print(frameJson(now));
    });
  }
  requireFrames(arguments, live.status());
  if (!arguments.page.mcp) printSummary(arguments, live);
}

/// Publishes to the graph of ROS 2.
void listTopics(const LiveArguments& arguments) {
  const auto topics = discoveredTopics(*ros::makeDdsNode(rosDomain()));
  if (!arguments.json) {
    fmt::print("{}", topicTable(topics));
    return;
  }
  Json json = Json::array();
  for (const ros::DdsTopic& topic : topics)
    json.push_back({{"name", topic.name},
                    {"type", topic.type},
                    {"writers", topic.writers},
                    {"readers", topic.readers},
                    {"reliable", topic.reliable}});
  print(Json{{"topics", std::move(json)}});
}

/// A file that is no map is reported by its reader.
bool isCalledMap(const std::string& source) {
  return std::filesystem::path(source).extension() == ".estancia";
}

/// A camera, a recording, or a map at rest.
void runOrServe(const LiveArguments& arguments) {
  if (arguments.list) return listTopics(arguments);
  if (arguments.source.empty())
    throw Error(ErrorCode::invalidOption, "SOURCE is missing: a camera, a recording, ros2:/TOPIC or a map");
  if (isMapFile(arguments.source) || (arguments.map().empty() && isCalledMap(arguments.source))) {
    if (!arguments.map().empty())
      throw Error(
          ErrorCode::invalidOption,
          fmt::format("{} is a map, not images; alone it is served as it is, without -o and --localize",
                      printable(arguments.source)));
    return serveMapFile(arguments.source, arguments.page);
  }
  if (arguments.map().empty())
    throw Error(ErrorCode::invalidOption,
                "give the map that is made by -o, or one to be found in by --localize");
  run(arguments);
}

}  // namespace

void addLiveCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("live", "Map a camera's frames while they come, or find them in a map");
  auto arguments = std::make_shared<LiveArguments>(*command);
  command->add_option(
      "SOURCE", arguments->source,
      "A camera: its number, /dev/videoN, http://… (MJPEG) or rtsp://…; ros2:/TOPIC of images; or a "
      "video, folder or bag that is played at its own pace; or a map at rest, which needs no -o");
  command->add_flag(
      "--ros2", arguments->publish,
      "Publish where the robot is (/estancia/where, JSON) and the map (/estancia/map, markers) on "
      "topics of ROS 2");
  command->add_flag("--list", arguments->list, "List the topics of ROS 2 that are published, and end");
  CLI::Option* output = addOutputOption(*command, arguments->output,
                                        "The map file, NAME.estancia; a map that is there is gone on with");
  command
      ->add_option("--localize", arguments->localize,
                   "Only find the frames in this map; nothing but people's corrections changes it")
      ->type_name("MAP")
      ->excludes(output);
  addPosesInMapOption(*command, arguments->posesInMap);
  arguments->declared.add(declare(arguments->sources.replay), {"rate", "frames-per-second"});
  arguments->declared.add(declare(arguments->sources.sequence), {"type", "poses"});
  SequenceArguments::addDepthTo(arguments->declared);
  arguments->declared.addFlags("sequence", {"image-topic=image", "odom-topic=odom"});
  command->add_option("--model", arguments->model.model,
                      fmt::format("The model that labels the images: a name of `models list`, a folder, or "
                                  "several joined by +\nDefault: {}",
                                  arguments->model.byDefault));
  arguments->model.addLabelerTo(arguments->declared);
  arguments->declared.add(declare(arguments->mapper), {});
  arguments->declared.add(declare(arguments->budget), {"memory", "file-budget"});
  arguments->declared.add(declare(arguments->world), {"layers"});
  arguments->declared.add(declare(arguments->localizer), {});
  arguments->page.addTo(arguments->declared);
  addJsonOption(*command, arguments->json);
  command->get_option("--mcp")->excludes("--json");
  addExamples(*command,
              "  estancia live 0 -o home.estancia\n"
              "  estancia live http://robot.local:8080/stream -o home.estancia\n"
              "  estancia live ros2:/camera/color/image_raw -o home.estancia\n"
              "  estancia live --list\n"
              "  estancia live ~/drive -o home.estancia --rate 2\n"
              "  estancia live 0 --localize home.estancia --json");
  command->callback([arguments] { runOrServe(*arguments); });
}

}  // namespace estancia::apps
