// TUM RGB-D: `rgb.txt` and `depth.txt` list `time file`; `groundtruth.txt` is the camera's denser trajectory.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// The files of a list, relative to its folder, in its order.
std::vector<TimedFile> readList(const fs::path& list) {
  std::vector<TimedFile> files;
  const auto lines = readLines(list);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto words = wordsOf(lines[i]);
    if (words.empty() || words[0].starts_with('#')) continue;
    const auto time = toNumber(words[0]);
    if (!time || !std::isfinite(*time) || words.size() < 2)
      fail(ErrorCode::malformedFile, "{}:{}: not `time file`", printable(list), i + 1);
    const fs::path file = fs::path(std::string(words[1].begin(), words.back().end()))
                              .lexically_normal();  // names may contain blanks
    if (file.is_absolute() || *file.begin() == "..")
      fail(ErrorCode::unsafePath, "{}:{}: {} leaves the folder of the data set", printable(list), i + 1,
           printable(file));
    files.push_back({*time, file});
  }
  return files;
}

/// The published color cameras of the three Kinects, by the name of the folder.
std::optional<CameraIntrinsics> publishedCamera(const std::string& folder) {
  if (folder.find("freiburg1") != std::string::npos) return {{640, 480, 517.3, 516.5, 318.6, 255.3}};
  if (folder.find("freiburg2") != std::string::npos) return {{640, 480, 520.9, 521.0, 325.1, 249.7}};
  if (folder.find("freiburg3") != std::string::npos) return {{640, 480, 535.4, 539.2, 320.1, 247.6}};
  return std::nullopt;
}

}  // namespace

static Opened openTumRgbd(const fs::path& path, const SequenceOptions& options) {
  const fs::path list = path / "rgb.txt";
  auto sequence =
      std::make_unique<ImageFiles>(nameOf(path), options.depthScale > 0 ? options.depthScale : 5000);
  const auto images = readList(list);
  if (images.empty()) fail(ErrorCode::insufficientData, "{}: no images", printable(list));
  std::vector<TimedFile> depths;
  if (fs::exists(path / "depth.txt")) try {
      depths = readList(path / "depth.txt");
    } catch (const Error& error) {  // images are usable without depth
      sequence->warn(fmt::format("depth.txt is ignored: {}", error.what()));
    }
  for (TimedFile& depth : depths) depth.file = path / depth.file;
  std::ranges::stable_sort(depths, {}, &TimedFile::timestamp);
  for (const auto& [time, file] : images)
    sequence->add({printable(file), time, {}, {}}, path / file, nearestDepth(depths, time));
  if (const auto camera = publishedCamera(sequence->name())) sequence->setIntrinsics(*camera);
  const fs::path truth = path / "groundtruth.txt";
  if (options.poses.empty() && fs::exists(truth))
    attachPoses(*sequence, readTrajectory(truth), truth, options.maxPoseGap);
  return sequence;
}

const SequenceFormat tumFormat{"tum", "TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt",
                               [](const fs::path& path) { return fs::is_regular_file(path / "rgb.txt"); },
                               openTumRgbd};

}  // namespace estancia::io
