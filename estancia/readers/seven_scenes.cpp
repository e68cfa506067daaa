// Microsoft 7-Scenes: frame-XXXXXX.color.png with frame-XXXXXX.pose.txt (4×4, camera → world, meters), or the
// images in `frames/` and all poses in `poses.csv` (`frame,T00,…,T23`). The data set has no time stamps.
// Depth is frame-XXXXXX.depth.png in millimeters, not registered to color; both share one published camera.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "estancia/files/csv.hpp"
#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> colorImages(const fs::path& path) {
  auto files = filesIn(path, {".color.png", ".color.jpg"});
  std::erase_if(files, [](const fs::path& f) { return !f.filename().string().starts_with("frame-"); });
  return files;
}

constexpr CameraIntrinsics published = {640, 480, 585, 585, 320, 240};

/// "frame-000123.color.png" → 123; nothing when there is no such number.
std::optional<double> numberOf(const fs::path& file) {
  const std::string name = file.filename().string();
  const auto begin = std::string_view("frame-").size();
  return toNumber(std::string_view(name).substr(begin, name.find('.') - begin));
}

/// Lost tracking is NaN, in several spellings (-1.#IND).
double valueOf(std::string_view text) {
  return toNumber(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::optional<Pose> poseOfFile(const fs::path& file) {
  std::array<double, 12> matrix{};
  std::size_t count = 0;
  for (const auto& line : readLines(file))
    for (const auto word : wordsOf(line))
      if (count++ < matrix.size()) matrix[count - 1] = valueOf(word);
  if (count != 16)
    fail(ErrorCode::malformedFile, "{}: {} numbers; give 16 (4×4, camera to world)", printable(file), count);
  return poseOfMatrix(matrix);
}

std::unordered_map<double, std::optional<Pose>> posesOfTable(const fs::path& file) {
  std::unordered_map<double, std::optional<Pose>> poses;
  for (const CsvRow& row : readCsv(file)) {
    std::array<double, 12> matrix{};
    if (row.cells.size() != matrix.size() + 1)
      fail(ErrorCode::malformedFile, "{}:{}: {} cells instead of 13: `frame,T00,T01,…,T23`", printable(file),
           row.line, row.cells.size());
    const auto number = toNumber(row.cells[0]);
    if (!number && poses.empty()) continue;  // the header
    if (!number)
      fail(ErrorCode::malformedFile, "{}:{}: no frame number in the first column", printable(file), row.line);
    std::ranges::transform(row.cells.begin() + 1, row.cells.end(), matrix.begin(), valueOf);
    poses[*number] = poseOfMatrix(matrix);
  }
  return poses;
}

}  // namespace

static bool isSevenScenes(const fs::path& path) {
  if (!fs::is_directory(path)) return false;
  const auto hasFrames = [](const fs::path& folder) {  // a photograph may have such a name, too
    return !colorImages(folder).empty() && !filesIn(folder, {".pose.txt", ".depth.png"}).empty();
  };
  if (hasFrames(path)) return true;
  const fs::path frames = path / "frames";
  return fs::is_directory(frames) &&
         (hasFrames(frames) || (fs::exists(path / "poses.csv") && !colorImages(frames).empty()));
}

static Opened openSevenScenes(const fs::path& path, const SequenceOptions& options) {
  auto files = colorImages(path);
  if (files.empty() && fs::is_directory(path / "frames")) files = colorImages(path / "frames");
  if (files.empty())
    fail(ErrorCode::insufficientData, "{}: no images named as in 7-Scenes (frame-000000.color.png)",
         printable(path));
  std::unordered_map<double, std::optional<Pose>> table;
  if (fs::exists(path / "poses.csv")) table = posesOfTable(path / "poses.csv");

  auto sequence =
      std::make_unique<ImageFiles>(nameOf(path), options.depthScale > 0 ? options.depthScale : 1000);
  sequence->setIntrinsics(published);
  if (!table.empty()) sequence->setPoseSource({});
  std::size_t without = 0;
  std::string first;
  for (const auto& file : files) {
    Frame frame;
    frame.name = printable(file.filename());
    const std::string name = file.filename().string();
    const auto beside = [&](const char* suffix) {
      return file.parent_path() / (name.substr(0, name.find('.')) + suffix);
    };
    const fs::path poseFile = beside(".pose.txt");
    if (const auto number = numberOf(file); number && table.contains(*number))
      frame.pose = table[*number];
    else if (fs::exists(poseFile)) {
      frame.pose = poseOfFile(poseFile);
      sequence->setPoseSource({});
    }
    if (!frame.pose && without++ == 0) first = frame.name;
    DepthFile depth;
    if (fs::exists(beside(".depth.png"))) depth.file = beside(".depth.png");
    sequence->add(std::move(frame), file, std::move(depth));
  }
  if (without > 0)
    sequence->warn(fmt::format("{} of {} frames have no pose: missing, NaN or no rotation (first: {})",
                               without, files.size(), first));
  return sequence;
}

const SequenceFormat sevenScenesFormat{
    "sevenscenes", "7-Scenes: frame-000000.color.png with .pose.txt, or frames/ and poses.csv", isSevenScenes,
    openSevenScenes};

}  // namespace estancia::io
