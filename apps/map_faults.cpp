// SPDX-License-Identifier: Apache-2.0
#include "map_faults.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <string>

#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"

namespace estancia::apps {

void warnOfFaults(const DriveFaults& faults) {
  const auto ofDepth = [&](const DriveFaults::Frames& frames, const char* what, const char* remedy) {
    if (frames.count > 0)
      spdlog::warn("{} of {} {} (first: {}), and so no areas and objects; {}", frames.count,
                   report::counted(faults.depthImages, "depth image"), what, printable(frames.first), remedy);
  };
  ofDepth(faults.noDepth, "show no distance above 0", "look at the files, and at `estancia check`");
  ofDepth(faults.tooFar, "show no distance below 65.5 m",
          "give the depth units per meter by --depth-scale; `estancia check` proposes them");
  for (const PoseJump& jump : faults.named)
    spdlog::warn("the pose jumps by {:.3g} m{} from {} to {}", jump.distance,
                 jump.seconds ? fmt::format(" in {:.3g} s", *jump.seconds) : "", printable(jump.from),
                 printable(jump.to));
  if (faults.jumps > 0)
    spdlog::warn(
        "{} of the poses in all; {} after a jump left out of areas and objects. Correct the poses, or map "
        "without them: the camera is tracked then",
        report::counted(faults.jumps, "jump"),
        faults.doubted == 1 ? "1 frame is" : fmt::format("{} frames are", faults.doubted));
}

nlohmann::ordered_json faultsOf(const DriveFaults& faults) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  const auto addDepth = [&json](const char* key, const DriveFaults::Frames& frames) {
    if (frames.count > 0) json[key] = {{"frames", frames.count}, {"first", frames.first}};
  };
  addDepth("no_depth", faults.noDepth);
  addDepth("depth_too_far", faults.tooFar);
  if (faults.jumps == 0) return json;
  json["pose_jumps"] = faults.jumps;
  json["frames_left_out"] = faults.doubted;
  for (const PoseJump& jump : faults.named) {
    json["jumps"].push_back({{"from", jump.from}, {"to", jump.to}, {"distance", jump.distance}});
    if (jump.seconds) json["jumps"].back()["seconds"] = *jump.seconds;
  }
  return json;
}

}  // namespace estancia::apps
