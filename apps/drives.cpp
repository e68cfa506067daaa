// estancia drives: the drives of a map.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <ctime>

#include "common.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/query/drives.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

/// Date in this time zone if `seconds` are since 1970; else the number itself.
std::string timeOf(double seconds) {
  constexpr double year2000 = 946684800, year2100 = 4102444800;
  if (!(seconds >= year2000 && seconds <= year2100)) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(static_cast<std::time_t>(seconds)));
}

std::string posesOf(const DriveSummary& summary) {
  if (!summary.drive.isAligned) return "its poses are not known in the map";
  if (summary.posed == 0) return "no poses";
  if (!summary.drive.alignment) return "its poses are the map's";
  const Pose& p = *summary.drive.alignment;
  return fmt::format("aligned by recognized places: moved by ({:.2f}, {:.2f}, {:.2f}) m", p.x, p.y, p.z);
}

void printText(const std::string& file, const std::vector<DriveSummary>& drives) {
  fmt::print("{}: {}\n", printable(file), counted(drives.size(), "drive"));
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const DriveSummary& d = drives[i];
    fmt::print("{:>4}  {:<24} {:>7} frames from {}  {} ({} new)", i, d.drive.name, d.frames, d.first,
               counted(d.places, "place"), d.newPlaces);
    if (d.kept < d.frames) fmt::print("  {} kept", counted(d.kept, "frame"));
    if (d.begins) fmt::print("  {} to {}", timeOf(*d.begins), timeOf(*d.ends));
    fmt::print("\n      {}", posesOf(d));
    if (d.recognized)
      fmt::print("; recognized {} in place {}",
                 d.recognized->after > 0 ? "after " + counted(d.recognized->after, "frame") : "at once",
                 d.recognized->node);
    else if (i > 0)
      fmt::print("; no place of an earlier drive was recognized: mapped by itself");
    fmt::print("\n");
  }
}

Json poseJson(const std::optional<Pose>& pose) {
  if (!pose) return nullptr;
  return {pose->x, pose->y, pose->z, pose->qx, pose->qy, pose->qz, pose->qw};
}

void printJson(const std::string& file, const std::vector<DriveSummary>& drives) {
  Json list = Json::array();
  for (const DriveSummary& d : drives) {
    Json entry{{"name", d.drive.name},
               {"first_frame", d.first},
               {"frames", d.frames},
               {"kept_frames", d.kept},
               {"begins", d.begins ? Json(*d.begins) : Json()},
               {"ends", d.ends ? Json(*d.ends) : Json()},
               {"places", d.places},
               {"new_places", d.newPlaces},
               {"posed_frames", d.posed},
               {"aligned", d.drive.isAligned},
               {"alignment", poseJson(d.drive.alignment)}};
    entry["recognized"] =
        d.recognized ? Json{{"after", d.recognized->after}, {"node", d.recognized->node}} : Json();
    list.push_back(std::move(entry));
  }
  print(Json{{"map", file}, {"drives", std::move(list)}});
}

}  // namespace

void addDrivesCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("drives", "List the drives that a map was made of, or undo one");
  struct Arguments {
    std::string map;
    std::optional<std::size_t> undo;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command
      ->add_option("--undo", arguments->undo,
                   "Take this drive out of the map: all others are mapped anew; people's corrections stay")
      ->check(wholeNumber(0))
      ->type_name("DRIVE");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia drives home.estancia\n"
              "  estancia drives home.estancia --undo 3");
  command->callback([arguments] {
    if (arguments->undo)
      for (const std::string& gone : undoDrive(arguments->map, *arguments->undo, *makeStderrProgress()))
        spdlog::warn("{}", gone);
    const std::vector<DriveSummary> drives = summarizeDrives(readMap(arguments->map));
    if (arguments->json)
      printJson(arguments->map, drives);
    else
      printText(arguments->map, drives);
  });
}

}  // namespace estancia::apps
