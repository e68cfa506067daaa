// The drive of the sample world, as a folder with the truth about it, on axes that are not the map's.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/pose.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// From the axes of the sample world to those of the drive: a quarter turn and a shift.
inline const cv::Affine3d sampleHomeFromMap{cv::Vec3d(0, 0, std::numbers::pi / 2), cv::Vec3d(20, -3, 0.1)};

/// A table (10), a mug (11), an umbrella (12) and a sofa (13), which the map does not have. Two rooms: west
/// (areas 0 and 1) and east.
inline void writeSampleHome(const std::filesystem::path& folder) {
  std::string poses, rooms = "image,room\n", visible = "image,id,pixels,pixels_with_depth\n";
  for (const char* part : {"rgb", "depth", "instance"}) std::filesystem::create_directories(folder / part);
  for (const MappedFrame& frame : samplePlaces().frames) {
    const Pose at = poseOf(sampleHomeFromMap * rigidOf(*frame.pose));
    poses += fmt::format("{} {} {} {} {} {} {} {}\n", *frame.timestamp, at.x, at.y, at.z, at.qx, at.qy, at.qz,
                         at.qw);
    rooms += fmt::format("{},{}\n", frame.name, frame.node < 2 ? "west" : "east");
    for (int id = 10; id < 14; ++id) visible += fmt::format("{},{},500,500\n", frame.name, id);
    cv::imwrite(folder / "rgb" / frame.name, cv::Mat(6, 8, CV_8UC3, cv::Scalar(90, 90, 90)));
    cv::imwrite(folder / "depth" / frame.name, cv::Mat(6, 8, CV_16U, cv::Scalar(1000)));
    cv::imwrite(folder / "instance" / frame.name, cv::Mat(6, 8, CV_16U, cv::Scalar(11)));
  }
  writeFile(folder / "poses.txt", poses);
  writeFile(folder / "rooms.csv", rooms);
  writeFile(folder / "visible.csv", visible);
  writeFile(folder / "camera-intrinsics.txt", "8 0 3.5\n0 8 2.5\n0 0 1\n");
  writeFile(folder / "home.json", R"({"rooms": [{"name": "west", "polygon": [[0, 0], [4, 0], [4, 4]]}]})");
  std::string things = "id,category,model,model_name,room,x,y,z,size_x,size_y,size_z,yaw_degrees\n";
  const auto thing = [&](int id, const char* category, const cv::Point3d& center, const cv::Point3d& size,
                         double degrees) {
    const cv::Point3d at = sampleHomeFromMap * center;
    things += fmt::format("{},{},m,n,west,{},{},{},{},{},{},{}\n", id, category, at.x, at.y, at.z, size.x,
                          size.y, size.z, degrees + 90);
  };
  const std::vector<WorldObject> objects = sampleObjects();
  thing(10, "table", objects[0].center, objects[0].size, 90);
  thing(11, "mug", objects[1].center + cv::Point3d(0.01, 0, 0), objects[1].size, 0);
  thing(12, "umbrella", objects[3].center, objects[3].size, 0);
  thing(13, "sofa", {1, 1, 0.4}, {2, 1, 0.8}, 0);
  writeFile(folder / "instances.csv", things);
  writeFile(folder / "things.toml",
            "other = \"small\"\n[classes]\nfurniture = [\"sofa\", \"table\"]\n[words]\ntable = [\"board\"]\n"
            "mug = [\"coffee mug\"]\numbrella = [\"folding chair\"]\nsofa = [\"couch\"]\n");
}

}  // namespace estancia::test
