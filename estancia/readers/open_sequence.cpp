// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/open_sequence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <set>
#include <unordered_map>

#include "estancia/core/digest.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/similar_names.hpp"
#include "estancia/files/camera_file.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/path_option.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// The frames of a descriptor file, without images; readDescriptors() gives their labels.
class DescriptorFrames final : public io::ListedSequence {
 public:
  DescriptorFrames(const fs::path& file, const SequenceOptions&) : ListedSequence(io::nameOf(file)) {
    DescriptorSequence labeled = readDescriptors(file);
    if (labeled.descriptors.size() > 0) {
      const DescriptorView first = labeled.descriptors.row(0);
      first_ = sha256({reinterpret_cast<const char*>(first.data()), first.size_bytes()});
    }
    entries_ = std::move(labeled.frames);
  }
  /// Distinguishes drives that have the same names; only the first frame has one.
  std::string fingerprint(std::size_t i) const override { return i == 0 ? first_ : ""; }
  cv::Mat image(std::size_t i) const override {
    fail(ErrorCode::invalidState, "{}: {} has labels only, no image; open the sequence of images", name_,
         frame(i).name);
  }

 private:
  std::string first_;
};

const io::SequenceFormat descriptorFormat{
    "descriptors", "labels instead of images: .labels (of `estancia label`), .csv, .jsonl, .npy",
    [](const fs::path& path) { return fs::is_regular_file(path) && isDescriptorFile(path); },
    io::openAs<DescriptorFrames>};

/// In order of detection.
std::vector<io::SequenceFormat> formats() {
  std::vector<io::SequenceFormat> all = io::imageFormats();
  all.insert(all.begin(), descriptorFormat);
  return all;
}

/// "; its folders a, b hold some …", or "". Folders of images in train/, test/ … are named as train/a.
std::string foldersWithImages(const fs::path& path) {
  constexpr std::size_t maxEntries = 100;
  std::vector<std::string> folders;
  std::error_code ignored;
  std::size_t seen = 0;
  for (fs::directory_iterator entry(path, ignored), end; !ignored && entry != end && ++seen <= maxEntries;
       entry.increment(ignored))
    if (std::error_code unknown; entry->is_directory(unknown) && io::isImageFolder(entry->path()))
      folders.push_back(io::printable(entry->path().filename()));
  for (const std::string& folder : io::nestedClasses(path)) folders.push_back(folder);
  if (folders.empty()) return "";
  std::sort(folders.begin(), folders.end());
  if (folders.size() == 1) return fmt::format("; its folder {} holds some", folders[0]);
  return fmt::format("; its folders {} hold some: open one, or all (--type classes) if each is a room",
                     fmt::join(folders, ", "));
}

/// An intrinsics file without image size is meant for the images of this sequence.
void attachIntrinsics(io::ListedSequence& sequence, const fs::path& file) {
  CameraIntrinsics camera = io::readIntrinsics(file);
  constexpr std::size_t tries = 10;
  for (std::size_t i = 0; camera.width == 0 && i < std::min(sequence.size(), tries); ++i) try {
      const cv::Mat image = sequence.image(i);
      camera.width = image.cols;
      camera.height = image.rows;
    } catch (...) {
      frameFailure(sequence.frame(i).name);  // the next may be readable
    }
  if (camera.width == 0)
    fail(ErrorCode::insufficientData, "{}: lacks the image size, and none of the first {} images can be read",
         io::printable(file), tries);
  sequence.setIntrinsics(camera);
}

/// Files named in the options must fit. Files found in the folder are used if they fit.
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
      sequence.warn(fmt::format("{} is ignored: {}", found.filename().string(), error.what()));
    }
  };
  attach(options.poses, beside("poses.txt"), [&](const fs::path& file) {
    io::attachPoses(sequence, readTrajectory(file), file, options.maxPoseGap);
  });
  attach(options.rooms, beside("rooms.csv"), [&](const fs::path& file) { io::attachRooms(sequence, file); });
  attach(options.intrinsics, io::findIntrinsics(path),
         [&](const fs::path& file) { attachIntrinsics(sequence, file); });
}

/// Rejects topics for a format that has none.
void requireNoTopics(const fs::path& path, std::string_view format, const SequenceOptions& options) {
  const char* given = !options.imageTopic.empty()   ? "--image"
                      : !options.depthTopic.empty() ? "--depth"
                      : !options.odomTopic.empty()  ? "--odom"
                                                    : nullptr;
  if (given != nullptr)
    fail(ErrorCode::invalidOption, "{} names a topic of a bag, but {} is read as {}; leave it out", given,
         io::printable(path), format);
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
    sequence.warn(fmt::format("{} frames are listed more than once; their names got numbers", repeated));
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

void warnOfSimilarRooms(io::ListedSequence& sequence) {
  std::set<std::string> rooms;
  for (const Frame& frame : sequence.frames())
    if (!frame.room.empty()) rooms.insert(frame.room);
  for (const std::string& warning : warningsOfSimilarRooms(rooms)) sequence.warn(warning);
}

void requireExistingPath(const fs::path& path) {
  const std::string name = io::printable(path);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found)
    fail(ErrorCode::fileNotFound, "{}: no such file or folder", name);
  if (error) fail(ErrorCode::fileUnreadable, "{}: cannot be read ({})", name, error.message());
  if (!fs::is_regular_file(status) && !fs::is_directory(status))
    fail(ErrorCode::unsupportedFile, "{}: neither a file nor a folder", name);
}

}  // namespace

OptionGroup declare(SequenceOptions& o) {
  OptionGroup group("sequence", "How to open a sequence of images.");
  group.add("type", &o.type, "Format of the sequence").choices(io::typesWithAuto(formats()));
  group.add("poses", io::asText(o.poses), "Trajectory (TUM or KITTI)").automatic("poses.txt in the folder");
  group.add("rooms", io::asText(o.rooms), "CSV image,room or image,room,split")
      .automatic("rooms.csv in the folder");
  group.add("split", &o.split, "Only the frames of this split").automatic("all frames");
  group.add("only", io::asText(o.only), "Only the frames in these rooms, separated by commas")
      .automatic("all rooms");
  group.add("max-pose-gap", &o.maxPoseGap, "Largest time difference between a frame and its pose")
      .range(0)
      .unit("s")
      .why("raise it for slow or badly synchronized trajectories");
  group.add("depth-scale", &o.depthScale, "Depth units per meter; 0: that of the data set or image type")
      .range(0, 1e9)
      .why("set it when depth images are not in millimeters");
  group.add("intrinsics", io::asText(o.intrinsics), "Camera intrinsics: fx fy cx cy, 3×3 matrix, or YAML")
      .automatic("camera-intrinsics.txt, intrinsics.txt or camera.yaml in the folder");
  group.add("image-topic", &o.imageTopic, "Bags: topic of images, raw or compressed")
      .automatic("the only camera, or the only one with color");
  group.add("depth-topic", &o.depthTopic, "Bags: topic of depth images; none: without depth")
      .automatic("the only one, or the only one in the frame of the images");
  group.add("odom-topic", &o.odomTopic, "Bags: topic of odometry, poses or transforms; none: without poses")
      .automatic("tf, else the only one");
  group.add("views", &o.views, "Panoramas: views per place, evenly spaced").range(1, 360);
  group.add("field-of-view", &o.fieldOfView, "Panoramas: horizontal field of view")
      .range(10, 150)
      .unit("degrees");
  group.add("turn", &o.turn, "Panoramas: offset of all headings")
      .unit("degrees")
      .why("gives another tour of the same places");
  group.add("exposure", &o.exposure, "Panoramas: change of exposure")
      .range(-20, 20)
      .unit("EV")
      .why("simulates another illumination");
  group.add("rounds", &o.rounds, "Panoramas: how often the tour visits all places").range(1, 1000);
  return group;
}

void validate(const SequenceOptions& options) {
  SequenceOptions copy = options;
  declare(copy).validate();
  if (options.depthScale > 0 && options.depthScale < 1e-6)
    fail(ErrorCode::invalidOption, "sequence.depth-scale is {}; give 0 or at least 1e-6", options.depthScale);
}

std::unique_ptr<Sequence> openSequence(const fs::path& path, const SequenceOptions& options) {
  validate(options);
  requireExistingPath(path);
  io::Opened sequence = io::opened(path, [&] {
    const auto known = formats();
    const auto* format = io::findFormat(known, path, options.type);
    if (format == nullptr) {
      const std::string others = io::otherImages(path);
      fail(ErrorCode::unsupportedFile, "{}: no known data set, and no images in this folder ({}){}{}",
           io::printable(path), io::readFormats, foldersWithImages(path),
           others.empty() ? "" : "; " + others);
    }
    if (format->open != io::bagFormat.open) requireNoTopics(path, format->type, options);
    io::Opened listed = format->open(path, options);
    attachSideFiles(*listed, path, options);
    return listed;
  });
  requireUniqueNames(*sequence);
  warnOfOddTimes(*sequence);
  warnOfSimilarRooms(*sequence);
  if (sequence->size() == 1 && !isImageFile(path)) sequence->warn("there is only one image");
  return io::selectFrames(std::move(sequence), options);
}

Choices sequenceTypes() {
  return io::typesOf(formats());
}

}  // namespace estancia
