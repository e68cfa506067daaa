// NYU Depth V2, labeled frames (Silberman et al., ECCV 2012): rgb/0000.jpg and depth/0000.png, numbered from
// 0 as in nyu_depth_v2_labeled.mat, and scenes.csv with a header: `index`, `scene` and optionally `split`.
// Depth of 8 bits has 255 for 10 m, as in any folder. Frames without a line have neither room nor split.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "estancia/files/csv.hpp"
#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// The color camera, to which depth is registered: camera_params.m of the data set's toolbox (fx_rgb …).
constexpr CameraIntrinsics nyuCamera = {
    640, 480, 518.85790117450188, 519.46961112127485, 325.58244941119034, 253.73616633400465};

/// The digits of `text` without leading zeros.
std::optional<std::string> indexOf(const std::string& text) {
  if (text.empty() || text.size() > 9 || text.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return text.substr(std::min(text.find_first_not_of('0'), text.size() - 1));
}

struct Scene {
  std::string room, split;
  std::size_t line;
};

std::unordered_map<std::string, Scene> readScenes(const fs::path& file) {
  const std::string name = printable(file);
  std::unordered_map<std::string, Scene> scenes;
  std::vector<std::string> header;
  std::optional<std::size_t> index, room, split;
  forEachCsvRow(file, [&](const CsvRow& row) {
    const std::string where = fmt::format("{}:{}", name, row.line);
    if (header.empty()) {
      header = row.cells;
      index = findColumn(header, "index");
      room = findColumn(header, "scene");
      split = findColumn(header, "split");
      if (!index || !room) fail(ErrorCode::malformedFile, "{}: no columns `index` and `scene`", where);
      return;
    }
    if (row.cells.size() != header.size())
      fail(ErrorCode::malformedFile, "{}: {} cells instead of {}", where, row.cells.size(), header.size());
    const auto number = indexOf(row.cells[*index]);
    if (!number)
      fail(ErrorCode::malformedFile, "{}: index \"{}\" is not a frame number", where,
           printable(row.cells[*index]));
    const Scene scene{printable(row.cells[*room]), split ? printable(row.cells[*split]) : "", row.line};
    const auto [entry, isNew] = scenes.emplace(*number, scene);
    if (!isNew)
      fail(ErrorCode::malformedFile, "{}: frame {} is repeated from line {}; keep one of them", where,
           *number, entry->second.line);
  });
  return scenes;
}

}  // namespace

static bool isNyu(const fs::path& path) {
  if (!fs::is_regular_file(path / "scenes.csv") || !rgbdFoldersFormat.recognizes(path)) return false;
  std::string header = firstBytes(path / "scenes.csv", 200);
  header = "," + header.substr(0, header.find_first_of("\r\n")) + ",";
  return header.find(",index,") != std::string::npos && header.find(",scene,") != std::string::npos;
}

static Opened openNyu(const fs::path& path, const SequenceOptions& options) {
  auto sequence = rgbdFoldersFormat.open(path, options);
  sequence->setIntrinsics(nyuCamera);
  auto scenes = readScenes(path / "scenes.csv");
  auto& splits = sequence->splits();
  splits.resize(sequence->size());
  for (std::size_t i = 0; i < sequence->size(); ++i) {
    Frame& frame = sequence->frames()[i];
    const auto number = indexOf(fs::path(frame.name).stem().string());
    const auto found = number ? scenes.find(*number) : scenes.end();
    if (found == scenes.end()) continue;
    frame.room = found->second.room;
    splits[i] = found->second.split;
    found->second.line = 0;  // taken
  }
  const auto left = std::ranges::count_if(scenes, [](const auto& entry) { return entry.second.line > 0; });
  if (left > 0)
    sequence->warn(fmt::format("scenes.csv: {} of {} lines name missing images", left, scenes.size()));
  return sequence;
}

const SequenceFormat nyuFormat{
    "nyu", "NYU Depth V2: rgb/0000.jpg, depth/0000.png, scenes.csv (index, scene, split)", isNyu, openNyu};

}  // namespace estancia::io
