// SPDX-License-Identifier: Apache-2.0
// ViDRILO (Martínez-Gómez, García-Varea, Cazorla, Morell: ViDRILO: The Visual and Depth Robot Indoor
// Localization with Objects information dataset, IJRR 34(14), 2015), and RobotVision@ImageCLEF, from which it
// came. One folder a sequence.
//
// Published: five sequences of pairs of a color image and a point cloud (PCD) of one Kinect, each with the
// category of its room (ten) and the presence of fifteen objects. The files of sequence 1 are called
// "sequence1visual12…" after their number; the challenge's toolbox keeps images and clouds in folders
// "…Visual" and "…Depth", and takes z of an organized cloud as depth.
// Inferred, because the data set is no longer available: names of the clouds and the text form of
// annotations. Any folder is read in which the extension distinguishes images and clouds, and the last number
// in the name pairs them; see readAnnotations(). Annotations in Matlab files are to be written to rooms.csv.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <unordered_map>

#include "estancia/core/ascii.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/files/pcd.hpp"
#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

const std::vector<std::string> cloudSuffix = {".pcd"}, cloudWords = {"depth", "pcd", "cloud"},
                               imageWords = {"visual", "rgb", "color", "image", "img"};

bool nameContains(const fs::path& path, const std::vector<std::string>& words) {
  const std::string name = lowerCase(path.filename().string());
  return std::ranges::any_of(words, [&](const std::string& w) { return name.find(w) != std::string::npos; });
}

/// The folder with files of these extensions: `path` itself, else the only one in it, else the only one with
/// a matching name; "" when there is none or several.
fs::path folderOf(const fs::path& path, const std::vector<std::string>& suffixes,
                  const std::vector<std::string>& words) {
  if (!filesIn(path, suffixes).empty()) return path;
  std::vector<fs::path> folders = foldersIn(path);
  std::erase_if(folders, [&](const fs::path& folder) { return filesIn(folder, suffixes).empty(); });
  if (folders.size() > 1)
    std::erase_if(folders, [&](const fs::path& folder) { return !nameContains(folder, words); });
  return folders.size() == 1 ? folders.front() : fs::path();
}

/// The last number in a file name, "sequence1visual0012.png" → "12"; "" without.
std::string numberInName(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return "";
  const auto before = stem.find_last_not_of("0123456789", last);
  const auto begin = before == std::string::npos ? 0 : before + 1;
  const std::string digits = stem.substr(begin, last + 1 - begin);
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

/// The files by their numbers. Throws Error on a repeated number.
std::unordered_map<std::string, fs::path> byNumber(const std::vector<fs::path>& files) {
  std::unordered_map<std::string, fs::path> numbered;
  for (const fs::path& file : files) {
    const auto [entry, isNew] = numbered.emplace(numberInName(file), file);
    if (!isNew)
      fail(ErrorCode::malformedFile,
           "{} and {} have the same number; keep each sequence in a folder of its own",
           printable(entry->second), printable(file.filename()));
  }
  return numbered;
}

// ---- annotations

/// Splits at commas, semicolons or tabs, else at blanks.
std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  if (line.find_first_of(",;\t") == std::string::npos) {
    for (const auto word : wordsOf(line)) cells.emplace_back(word);
    return cells;
  }
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(",;\t", begin), line.size());
    cells.emplace_back(trimmed(std::string_view(line).substr(begin, end - begin), " \""));
    begin = end + 1;
  }
  return cells;
}

bool isFile(const std::string& cell) {
  return hasSuffix(cell, imageSuffixes()) || hasSuffix(cell, cloudSuffix);
}

struct Columns {
  /// Absent: lines have the order of the images.
  std::optional<std::size_t> frame;
  std::size_t room = 0;
  /// x [m], y [m] and theta of the robot.
  std::optional<std::array<std::size_t, 3>> pose = {};
};

/// The columns of a header, if `cells` is one.
std::optional<Columns> readHeader(const std::vector<std::string>& cells) {
  static const std::set<std::string> rooms = {"room", "class", "category", "label", "scene"},
                                     frames = {"image", "frame", "file", "name", "visual", "rgb", "index"};
  Columns columns;
  bool found = false;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const std::string cell = lowerCase(cells[c]);
    if (!found && rooms.contains(cell)) {
      columns.room = c;
      found = true;
    }
    if (!columns.frame && frames.contains(cell)) columns.frame = c;
  }
  constexpr std::array<std::string_view, 3> names{"x", "y", "theta"};
  std::array<std::size_t, 3> pose{};
  for (std::size_t i = 0; i < 3; ++i)
    pose[i] = static_cast<std::size_t>(
        std::ranges::find(cells, names[i], [](const std::string& cell) { return lowerCase(cell); }) -
        cells.begin());
  if (std::ranges::max(pose) < cells.size()) columns.pose = pose;
  return found ? std::optional(columns) : std::nullopt;
}

/// Without a header: the frame is the first column if all its cells name different frames; the room is the
/// first other column with neither files nor numbers, else the first without files.
Columns guessColumns(const std::vector<std::vector<std::string>>& rows,
                     const std::unordered_map<std::string, std::size_t>& frames) {
  Columns columns;
  std::set<std::size_t> named;
  for (const auto& row : rows)
    if (const auto frame = frames.find(numberInName(row[0])); row.size() > 1 && frame != frames.end())
      named.insert(frame->second);
  if (named.size() == rows.size()) columns.frame = 0;
  const std::size_t first = columns.frame ? 1 : 0;
  columns.room = rows[0].size();  // backwards, so that the first one wins
  for (std::size_t c = rows[0].size(); c-- > first;)
    if (!isFile(rows[0][c])) columns.room = c;
  for (std::size_t c = rows[0].size(); c-- > first;)
    if (!isFile(rows[0][c]) && !toNumber(rows[0][c])) columns.room = c;
  if (columns.room == rows[0].size()) throw Error(ErrorCode::malformedFile, "only file names, no rooms");
  for (const auto& row : rows)
    if (const auto value = toNumber(row[columns.room]); value && *value != std::floor(*value))
      throw Error(ErrorCode::malformedFile, "ambiguous columns; write a header with `room`");
  // index x y theta category, as the thesis author's programs have it
  if (columns.frame && columns.room == 4 && rows[0].size() == 5) columns.pose = {1, 2, 3};
  return columns;
}

/// The robot's pose in a line of the table; none where a value is no number.
std::optional<Pose> poseIn(const std::vector<std::string>& row, const Columns& columns, bool degrees) {
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = toNumber(row[(*columns.pose)[i]]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return Pose::planar(values[0], values[1], degrees ? values[2] * std::numbers::pi / 180 : values[2]);
}

/// Whether angles are degrees: one is beyond a turn in radians.
bool hasDegrees(const std::vector<std::vector<std::string>>& rows, const Columns& columns) {
  return columns.pose && std::ranges::any_of(rows, [&](const std::vector<std::string>& row) {
           return std::abs(toNumber(row[(*columns.pose)[2]]).value_or(0)) > 2 * std::numbers::pi;
         });
}

/// Sets the rooms, and the poses if there are some, from a table: one line per frame, in the order of the
/// images, or with the image's number or file. A title above it and other columns (objects) are ignored.
/// Throws Error when the table does not fit.
void readAnnotations(const fs::path& file, ImageFiles& sequence) {
  std::unordered_map<std::string, std::size_t> frames;
  for (std::size_t i = 0; i < sequence.size(); ++i) frames.emplace(numberInName(sequence.frame(i).name), i);
  std::vector<std::vector<std::string>> rows;
  std::optional<Columns> header;
  bool hasTitle = false;
  const auto lines = readLines(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    auto cells = cellsOf(lines[i]);
    if (cells.empty() || cells[0].starts_with('#')) continue;
    if (rows.empty() && !header)
      if ((header = readHeader(cells))) continue;
    if (rows.size() == 1 && !header && !hasTitle && cells.size() > rows.front().size()) {
      hasTitle = true;
      rows.clear();
      if ((header = readHeader(cells))) continue;
    }
    if (!rows.empty() && cells.size() != rows.front().size())
      fail(ErrorCode::malformedFile, "line {} has {} values instead of {}", i + 1, cells.size(),
           rows.front().size());
    rows.push_back(std::move(cells));
  }
  if (rows.empty()) throw Error(ErrorCode::insufficientData, "empty");
  const Columns columns = header ? *header : guessColumns(rows, frames);
  if (std::max({columns.room, columns.frame.value_or(0),
                columns.pose ? std::ranges::max(*columns.pose) : 0}) >= rows.front().size())
    throw Error(ErrorCode::malformedFile, "the lines have fewer values than the header");
  if (!columns.frame && rows.size() != sequence.size())
    fail(ErrorCode::mismatch, "{} lines for {} images", rows.size(), sequence.size());
  const bool degrees = hasDegrees(rows, columns);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto frame = columns.frame ? frames.find(numberInName(rows[k][*columns.frame])) : frames.end();
    if (columns.frame && frame == frames.end()) continue;  // an image that was left out
    Frame& found = sequence.frames()[columns.frame ? frame->second : k];
    found.room = printable(rows[k][columns.room]);
    if (columns.pose) found.pose = poseIn(rows[k], columns, degrees);
  }
}

/// The table of annotations: the only text file in the folder without another purpose, else the only one with
/// a matching name, else one beside the folder with its name; "" when there is none.
fs::path annotationsIn(const fs::path& path) {
  const std::vector<std::string> suffixes = {".txt", ".csv"};
  auto files = filesIn(path, suffixes);
  std::erase_if(files, [](const fs::path& file) {
    return nameContains(file, {"readme", "licen", "intrinsics", "poses.txt", "rooms.csv"});
  });
  if (files.size() > 1)
    std::erase_if(files, [](const fs::path& f) {
      return !nameContains(f, {"annot", "label", "class", "categor"});
    });
  if (files.size() == 1) return files.front();
  for (const std::string& suffix : suffixes) {
    const fs::path whole = fs::absolute(path).lexically_normal();
    const fs::path folder = whole.has_filename() ? whole : whole.parent_path();
    if (fs::path beside = folder.string() + suffix; fs::is_regular_file(beside)) return beside;
  }
  return {};
}

// ---- the camera

/// Least-squares fit of u = focal · a + center, and its RMS error [pixels].
struct Axis {
  double focal, center, error;
};

Axis fitAxis(const std::vector<std::pair<double, double>>& points) {
  double n = static_cast<double>(points.size()), a = 0, u = 0, aa = 0, au = 0, uu = 0;
  for (const auto& [slope, pixel] : points) {
    a += slope / n;
    u += pixel / n;
  }
  for (const auto& [slope, pixel] : points) {
    aa += (slope - a) * (slope - a);
    au += (slope - a) * (pixel - u);
    uu += (pixel - u) * (pixel - u);
  }
  const double focal = aa > 0 ? au / aa : 0;
  return {focal, u - focal * a, std::sqrt(std::max(0.0, uu - focal * au) / n)};
}

/// The pinhole camera of an organized cloud: a point seen at (u, v) has u = fx x / z + cx. Absent when no
/// camera fits, as for clouds outside of the optical frame.
std::optional<CameraIntrinsics> cameraOf(const PointCloud& cloud) {
  std::vector<std::pair<double, double>> across, down;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z) || !(p.z > 0)) continue;
    across.emplace_back(p.x / p.z, static_cast<double>(i % cloud.width));
    down.emplace_back(p.y / p.z, static_cast<double>(i / cloud.width));
  }
  if (!cloud.organized() || across.size() < 100) return std::nullopt;
  const Axis x = fitAxis(across), y = fitAxis(down);
  if (!(x.focal > 0 && y.focal > 0 && x.error < 1 && y.error < 1)) return std::nullopt;
  return CameraIntrinsics{
      static_cast<int>(cloud.width), static_cast<int>(cloud.height), x.focal, y.focal, x.center, y.center};
}

void fitCamera(ImageFiles& sequence, const std::vector<fs::path>& clouds) {
  constexpr std::size_t tries = 3;  // the first clouds may be empty or damaged
  for (std::size_t i = 0; i < std::min(tries, clouds.size()); ++i) try {
      if (const auto camera = cameraOf(readPcd(clouds[i]))) return sequence.setIntrinsics(*camera);
    } catch (...) {
      frameFailure(clouds[i].string());  // reported when its depth is read
    }
  sequence.warn(
      "the first clouds do not fit a pinhole camera in its optical frame (x right, y down, z forward)");
}

}  // namespace

/// Images and clouds in two folders, or in one with the names of the data set.
static bool isVidrilo(const fs::path& path) {
  if (!fs::is_directory(path)) return false;
  const fs::path clouds = folderOf(path, cloudSuffix, cloudWords);
  if (clouds.empty()) return false;
  const fs::path images = folderOf(path, imageSuffixes(), imageWords);
  if (images.empty()) return false;
  return (images != path && clouds != path) ||
         (nameContains(filesIn(images, imageSuffixes()).front(), {"visual"}) &&
          nameContains(filesIn(clouds, cloudSuffix).front(), {"depth"}));
}

static Opened openVidrilo(const fs::path& path, const SequenceOptions& options) {
  const fs::path imageFolder = folderOf(path, imageSuffixes(), imageWords),
                 cloudFolder = folderOf(path, cloudSuffix, cloudWords);
  if (imageFolder.empty() || cloudFolder.empty())
    fail(ErrorCode::unsupportedFile,
         "{}: no folder, or several, with {}; ViDRILO has one folder per sequence, with one folder of "
         "images (visual) and one of clouds (depth)",
         printable(path), imageFolder.empty() ? "images" : "clouds (.pcd)");
  const auto images = filesIn(imageFolder, imageSuffixes()), clouds = filesIn(cloudFolder, cloudSuffix);
  byNumber(images);
  const auto numbered = byNumber(clouds);
  auto sequence = std::make_unique<ImageFiles>(nameOf(path), options.depthScale);
  std::size_t without = 0;
  for (const fs::path& file : images) {
    const auto cloud = numbered.find(numberInName(file));
    if (cloud == numbered.end()) ++without;
    sequence->add({printable(file.filename()), {}, {}, {}}, file,
                  {cloud == numbered.end() ? fs::path() : cloud->second, {}});
  }
  if (without == images.size())
    fail(ErrorCode::mismatch, "{}: no image has the number of a cloud", printable(path));
  if (without > 0) sequence->warn(fmt::format("{} of {} images have no cloud", without, images.size()));
  fitCamera(*sequence, clouds);

  if (const fs::path table = annotationsIn(path); !table.empty()) try {
      readAnnotations(table, *sequence);
    } catch (const Error& error) {
      sequence->warn(fmt::format("{} is ignored: {}", printable(table.filename()), error.what()));
    }
  return sequence;
}

const SequenceFormat vidriloFormat{
    "vidrilo", "ViDRILO: images and organized PCD clouds with the same numbers, text annotations", isVidrilo,
    openVidrilo};

}  // namespace estancia::io
