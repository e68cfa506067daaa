// What the tests of experiments compare: small models, and a drive through four rooms of one color each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// A model NAME in `folder` that sees colors the better the larger `scale` is.
inline void writeColorModel(const ScratchFolder& folder, const std::string& name, const std::string& scale) {
  writeSmallModel(folder / name, "scale = " + scale);
  std::string toml = readFile(folder / name / "model.toml");
  toml.replace(toml.find("small"), 5, name);
  writeFile(folder / name / "model.toml", toml);
}

/// Four rooms in a row of 3 m, each of its own color, seen ten times each; with rooms.csv and a TUM
/// trajectory.
inline void writeColorDrive(const std::filesystem::path& folder, std::uint64_t seed) {
  std::filesystem::create_directories(folder);
  const std::vector<cv::Scalar> colors{{20, 20, 230}, {20, 230, 20}, {230, 20, 20}, {230, 230, 230}};
  cv::RNG random(seed);
  std::string rooms = "image,room\n", poses;
  for (int i = 0; i < 40; ++i) {
    cv::Mat image(48, 64, CV_8UC3, colors[static_cast<std::size_t>(i / 10)]), noise(image.size(), CV_8SC3);
    random.fill(noise, cv::RNG::NORMAL, 0, 20);
    cv::add(image, noise, image, {}, CV_8UC3);
    const std::string name = (i < 10 ? "000" : "00") + std::to_string(i) + ".png";
    cv::imwrite((folder / name).string(), image);
    poses += std::to_string(i) + " " + std::to_string(3 * (i / 10)) + " 0 0 0 0 0 1\n";
    rooms += name + ",room" + std::to_string(i / 10) + "\n";
  }
  writeFile(folder / "rooms.csv", rooms);
  writeFile(folder / "poses.txt", poses);
}

}  // namespace estancia::test
