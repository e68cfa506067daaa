#include "estancia/io/sequence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <unordered_map>

#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/io/camera_file.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/formats.hpp"
#include "estancia/io/frame_selection.hpp"
#include "estancia/io/side_files.hpp"
#include "estancia/io/trajectory.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

struct Format {
  const char* type;
  const char* explanation;
  bool (*recognizes)(const fs::path& path);
  io::Opened (*open)(const fs::path& path, const SequenceOptions& options);
};

/// The frames of a recording; whoever wants their words reads the recording itself.
class RecordedFrames final : public io::ListedSequence {
 public:
  RecordedFrames(const fs::path& file, std::vector<Frame> frames) : ListedSequence(io::nameOf(file)) {
    frames_ = std::move(frames);
  }
  cv::Mat image(std::size_t i) const override {
    throw Error(fmt::format("{}: there is no image of {}, only its words", name_, frames_.at(i).name));
  }
};

bool isWords(const fs::path& path) {
  return fs::is_regular_file(path) && isDescriptorFile(path);
}

io::Opened openWords(const fs::path& path, const SequenceOptions&) {
  return std::make_unique<RecordedFrames>(path, readDescriptors(path).frames);
}

/// In the order in which they are asked: the plain folder of images takes what no data set claims.
constexpr Format kFormats[] = {
    {"recording", "words instead of images: .labels (of `estancia label`), .csv, .jsonl, .npy", isWords,
     openWords},
    {"video", "a video file that OpenCV opens", io::isVideo, io::openVideo},
    {"tum", "TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt", io::isTumRgbd, io::openTumRgbd},
    {"sevenscenes", "7-Scenes: frame-000000.color.png with .pose.txt, or frames/ and poses.csv",
     io::isSevenScenes, io::openSevenScenes},
    {"panorama", "views out of equirectangular panoramas: .exr, .hdr, .exr.js (.jpg, .png only by this type)",
     io::isPanoramas, io::openPanoramas},
    {"idol2", "KTH-IDOL2: t<time>_r<room>_x<x>_y<y>_a<theta>.png", io::isIdol2, io::openIdol2},
    {"nyu", "NYU Depth V2: rgb/0000.jpg, depth/0000.png, scenes.csv (index, scene, split)", io::isNyu,
     io::openNyu},
    {"rgbd", "two folders: rgb/ (or color/, image/) and depth/, files of equal names", io::isRgbdFolders,
     io::openRgbdFolders},
    {"vidrilo", "ViDRILO: images and organized PCD clouds of equal numbers, annotations as text",
     io::isVidrilo, io::openVidrilo},
    {"classes",
     "a folder a room, full of images, perhaps in train/ and test/ (those alone are found by auto)",
     io::isClasses, io::openClasses},
    {"folder", "a folder of images, in the natural order of their names", io::isImageFolder,
     io::openImageFolder},
};

std::string typeNames() {
  std::string names = "auto";
  for (const Format& format : kFormats) names += fmt::format(", {}", format.type);
  return names;
}

/// "; its folders a, b hold some …", or "".
std::string foldersWithImages(const fs::path& path) {
  constexpr std::size_t most = 100;  // entries looked at
  std::vector<std::string> folders;
  std::error_code ignored;
  std::size_t seen = 0;
  for (fs::directory_iterator entry(path, ignored), end; !ignored && entry != end && ++seen <= most;
       entry.increment(ignored))
    if (std::error_code unknown; entry->is_directory(unknown) && io::isImageFolder(entry->path()))
      folders.push_back(io::printable(entry->path().filename().string()));
  if (folders.empty()) return "";
  std::sort(folders.begin(), folders.end());
  if (folders.size() == 1) return fmt::format("; its folder {} holds some", folders[0]);
  return fmt::format("; its folders {} hold some: open one, or all as type \"classes\" if each is a room",
                     fmt::join(folders, ", "));
}

const Format& formatOf(const fs::path& path, const std::string& type) {
  for (const Format& format : kFormats)
    if (type == format.type || (type == "auto" && format.recognizes(path))) return format;
  if (type != "auto")
    throw Error(fmt::format("unknown type of sequence \"{}\"; known are {}", type, typeNames()));
  throw Error(
      fmt::format("{}: no images in this folder (jpg, png, bmp, tif, webp, pgm, ppm) and no known data set{}",
                  io::printable(path.string()), foldersWithImages(path)));
}

/// Files that do not say the size of the images mean the images of this sequence.
void attachIntrinsics(io::ListedSequence& sequence, const fs::path& file) {
  CameraIntrinsics camera = io::readIntrinsics(file);
  constexpr std::size_t tries = 10;
  for (std::size_t i = 0; camera.width == 0 && i < std::min(sequence.size(), tries); ++i) try {
      const cv::Mat image = sequence.image(i);
      camera.width = image.cols;
      camera.height = image.rows;
    } catch (...) {
      frameFailure(sequence.frame(i).name);  // the next may be fine
    }
  if (camera.width == 0)
    throw Error(fmt::format("{}: does not say the size of the images, and none of the first {} can be read",
                            io::printable(file.string()), tries));
  sequence.setIntrinsics(camera);
}

/// What the user named must fit. What merely lies in the folder under a usual name is used if it fits.
void attachSideFiles(io::ListedSequence& sequence, const fs::path& path, const SequenceOptions& options) {
  const auto beside = [&](const char* name) {
    const fs::path file = path / name;
    return fs::is_regular_file(file) ? file : fs::path();
  };
  const auto attach = [&](const fs::path& named, const fs::path& found, const auto& attachFile) {
    if (!named.empty()) return attachFile(named);
    if (found.empty()) return;
    try {
      attachFile(found);
    } catch (const Error& error) {
      sequence.warn(fmt::format("{} is left aside: {}", found.filename().string(), error.what()));
    }
  };
  attach(options.poses, beside("poses.txt"), [&](const fs::path& file) {
    io::attachPoses(sequence, readTrajectory(file), file, options.maxPoseGap);
  });
  attach(options.rooms, beside("rooms.csv"), [&](const fs::path& file) { io::attachRooms(sequence, file); });
  attach(options.intrinsics, io::findIntrinsics(path),
         [&](const fs::path& file) { attachIntrinsics(sequence, file); });
}

void requireUniqueNames(io::ListedSequence& sequence) {
  std::unordered_map<std::string, std::size_t> uses;
  std::size_t repeated = 0;
  for (Frame& frame : sequence.frames()) {
    const std::string name = frame.name;
    while (++uses[frame.name] > 1) frame.name = fmt::format("{} ({})", name, uses[frame.name]);
    if (frame.name != name) ++repeated;
  }
  if (repeated > 0)
    sequence.warn(fmt::format("{} frames are listed more than once; a number tells them apart", repeated));
}

void warnOfOddTimes(io::ListedSequence& sequence) {
  std::size_t odd = 0, missing = 0;
  std::string first;
  std::optional<double> latest;
  for (const Frame& frame : sequence.frames()) {
    if (!frame.timestamp) {
      ++missing;
      continue;
    }
    if (latest && *frame.timestamp <= *latest && odd++ == 0) first = frame.name;
    latest = std::max(latest.value_or(*frame.timestamp), *frame.timestamp);
  }
  if (odd > 0)
    sequence.warn(
        fmt::format("{} of {} frames have a time stamp not later than those before (first: {}); the order of "
                    "the list is kept",
                    odd, sequence.size(), first));
  if (missing > 0 && missing < sequence.size())
    sequence.warn(fmt::format("{} of {} frames have no time stamp", missing, sequence.size()));
}

}  // namespace

namespace io {

std::string nameOf(const fs::path& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  return printable((whole.has_filename() ? whole : whole.parent_path()).filename().string());
}

}  // namespace io

cv::Mat Sequence::depth(std::size_t i) const {
  throw Error(fmt::format("{}: there is no depth with {}", name(), frame(i).name));
}

std::unique_ptr<Sequence> openSequence(const fs::path& path, const SequenceOptions& options) {
  const std::string name = io::printable(path.string());
  if (!(options.maxPoseGap >= 0))
    throw Error(fmt::format("maxPoseGap = {}: give the seconds that may lie between a frame and its pose",
                            options.maxPoseGap));
  if (!(options.depthScale >= 0 && options.depthScale <= 1e9) ||
      (options.depthScale > 0 && options.depthScale < 1e-6))
    throw Error(
        fmt::format("depthScale = {}: give what a meter is in the numbers of the depth images "
                    "(1000 for millimeters)",
                    options.depthScale));
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found)
    throw Error(fmt::format("{}: there is no such file or folder", name));
  if (error) throw Error(fmt::format("{}: cannot be read ({})", name, error.message()));
  if (!fs::is_regular_file(status) && !fs::is_directory(status))
    throw Error(fmt::format("{}: neither a file nor a folder", name));

  io::Opened sequence;
  try {
    sequence = formatOf(path, options.type).open(path, options);
    attachSideFiles(*sequence, path, options);
  } catch (const fs::filesystem_error& e) {
    throw Error(fmt::format("{}: cannot be read ({})", name, e.code().message()));
  } catch (const cv::Exception& e) {
    throw Error(fmt::format("{}: OpenCV cannot read it ({})", name, io::printable(e.err)));
  }
  requireUniqueNames(*sequence);
  warnOfOddTimes(*sequence);
  if (sequence->size() == 1) sequence->warn("there is only one image");
  return io::selectFrames(std::move(sequence), options);
}

std::vector<std::pair<std::string, std::string>> sequenceTypes() {
  std::vector<std::pair<std::string, std::string>> types;
  for (const Format& format : kFormats) types.emplace_back(format.type, format.explanation);
  return types;
}

}  // namespace estancia
