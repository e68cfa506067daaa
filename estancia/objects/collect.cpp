// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/collect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/tracks.hpp"
#include "estancia/readers/object_samples.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

/// The folders in a folder of samples.
std::set<fs::path> partsOf(const fs::path& folder) {
  return {imageOf(folder, "x").parent_path(), maskOf(folder, "x").parent_path(),
          cloudOf(folder, "x").parent_path()};
}

/// The files of the samples that the list names.
std::set<fs::path> filesOf(const fs::path& folder) {
  std::set<fs::path> files{folder / "samples.csv", labelFileOf(folder)};
  for (const ObjectSample& sample : readObjectSamples(folder)) {
    files.insert(imageOf(folder, sample.view.name));
    files.insert(maskOf(folder, sample.view.name));
    files.insert(cloudOf(folder, sample.view.name));
  }
  return files;
}

void requireOnlySamples(const fs::path& folder) {
  if (!isObjectSamples(folder))
    fail(ErrorCode::fileExists, "{} is not a folder of samples and is not replaced; give another name",
         io::printable(folder.string()));
  const std::set<fs::path> files = filesOf(folder), parts = partsOf(folder);
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!files.contains(entry.path()) && !(entry.is_directory() && parts.contains(entry.path())))
      fail(ErrorCode::fileExists,
           "{} is not one of the samples, so that nothing is replaced; move it away first",
           io::printable(entry.path().string()));
}

void requirePlace(const fs::path& folder, bool replace) {
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder))) return;
  if (!fs::is_directory(folder) || !replace)
    fail(ErrorCode::fileExists, "{} exists; give another name, or replace its samples by --overwrite",
         io::printable(folder.string()));
  requireOnlySamples(folder);
}

/// Runs `work` and turns errors of the file system into an Error about `folder`.
template <class Work>
void onDisk(const fs::path& folder, const char* what, const Work& work) {
  try {
    work();
  } catch (const fs::filesystem_error& e) {
    fail(ErrorCode::fileUnwritable, "{}: the folder cannot be {} ({}); check its parent folder",
         io::printable(folder.string()), what, e.code().message());
  }
}

/// Fills FOLDER.part, which replaces FOLDER when it is finished.
class NewSamples {
 public:
  /// Throws Error without a name (invalidOption); when FOLDER exists and is not empty, unless it is to be
  /// replaced and has samples only (fileExists); and when FOLDER.part cannot be made (fileUnwritable), or
  /// exists and is not that of a killed run (fileExists).
  // Built upon another constructor, so that what was made is removed when the rest fails.
  NewSamples(const fs::path& folder, bool replace) : NewSamples() {
    if (folder.empty()) throw Error(ErrorCode::invalidOption, "the folder of samples has no name; give one");
    onDisk(folder, "made", [&] {
      folder_ = fs::weakly_canonical(fs::absolute(folder / "x"))
                    .parent_path();  // without dots and slashes at its end
      requirePlace(folder_, replace);
      const fs::path part = folder_.string() + ".part";
      if (fs::exists(part)) {
        if (!isObjectSamples(part))
          fail(ErrorCode::fileExists, "{} exists, where samples are collected first; move it away",
               io::printable(part.string()));
        fs::remove_all(part);  // left by a run that was killed
      }
      part_ = part;
      for (const fs::path& inside : partsOf(part_)) fs::create_directories(inside);
    });
    writeObjectSamples({}, part_);
  }

  /// Removes FOLDER.part unless it was finished.
  ~NewSamples() {
    std::error_code ignored;
    if (!part_.empty()) fs::remove_all(part_, ignored);
  }
  NewSamples(const NewSamples&) = delete;
  NewSamples& operator=(const NewSamples&) = delete;

  /// The folder of images, masks and clouds until finish().
  const fs::path& folder() const { return part_; }

  /// Writes the list and renames the folder. Throws Error (fileUnwritable).
  void finish(const std::vector<ObjectSample>& samples) {
    writeObjectSamples(samples, part_);
    onDisk(folder_, "replaced", [&] {
      if (fs::exists(folder_) && !fs::is_empty(folder_)) {
        requireOnlySamples(folder_);  // again: others may have written there
        fs::remove_all(folder_);
      }
      fs::rename(part_, folder_);
    });
    part_.clear();
  }

 private:
  NewSamples() = default;

  fs::path folder_, part_;
};

/// The region of a crop with the largest margin.
cv::Rect surroundings(const cv::Rect& box) {
  const CropOptions standard;
  const auto reach = static_cast<int>(
      std::ceil(std::max(box.width, box.height) * (0.5 + maxCollectedMargin) / standard.crop));
  const cv::Point middle = (box.tl() + box.br()) / 2;
  return {middle.x - reach - 1, middle.y - reach - 1, 2 * reach + 2, 2 * reach + 2};
}

/// The samples of one sequence, as they come. Life cycle: add() for each frame in order; samples() and
/// collected() may be asked at any time. Invariant: a sample is listed only when its image, mask and cloud
/// were written.
class Collector {
 public:
  Collector(const fs::path& folder, const CollectOptions& options) : folder_(folder), options_(options) {}

  void add(const ClusteredFrame& frame, const Frame& about) {
    const auto& clusters = frame.clusters.clusters;
    const auto instances = tracks_.follow(frame.clusters, frame.camera, about.pose);
    collected_.withoutPlane += frame.clusters.planes.empty() ? 1 : 0;
    collected_.withoutCluster += clusters.empty() ? 1 : 0;
    collected_.huge += !clusters.empty() && 2 * clusters.front().points.size() > frame.depth.total() ? 1 : 0;
    std::vector<std::size_t> kept;
    const std::size_t first = samples_.size();
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      std::size_t& views = viewsOf_[instances[i]];
      if (views == options_.maxViews) {
        ++collected_.full;
        continue;
      }
      ObjectSample sample;
      sample.view.instance = fmt::format("object-{:04}", instances[i]);
      sample.view.name = fmt::format("{}-{:04}", sample.view.instance, views++);
      sample.view.frame = io::printable(about.name);
      sample.view.flat = clusters[i].flat;
      sample.view.atBorder = clusters[i].atBorder;
      collected_.flat += clusters[i].flat ? 1 : 0;
      collected_.atBorder += clusters[i].atBorder ? 1 : 0;
      samples_.push_back(std::move(sample));
      kept.push_back(i);
    }
    const int threads = options_.clusters.threads;
    try {
      inParallel(kept.size(), static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
                 [&](std::size_t k) { write(frame, kept[k], samples_[first + k]); });
    } catch (...) {
      samples_.resize(first);
      throw;
    }
  }

  const std::vector<ObjectSample>& samples() const { return samples_; }

  Collected& collected() {
    collected_.samples = samples_.size();
    collected_.instances = viewsOf_.size();
    return collected_;
  }

 private:
  void write(const ClusteredFrame& frame, std::size_t i, ObjectSample& sample) const {
    // More than the default crop, and the mask of the object: margin and background are chosen when labeling.
    const cv::Rect box = boxOf(frame, i), region = surroundings(box) & cv::Rect({}, frame.image.size());
    sample.box = box - region.tl();
    writePng(frame.image(region), imageOf(folder_, sample.view.name));
    writePng(maskOf(frame, i)(region), maskOf(folder_, sample.view.name));
    writeCloud(cloudOf(frame, i), cloudOf(folder_, sample.view.name));
  }

  const fs::path& folder_;
  const CollectOptions& options_;
  Tracks tracks_;
  std::map<std::size_t, std::size_t> viewsOf_;
  std::vector<ObjectSample> samples_;
  Collected collected_;
};

std::string interruptionOf(const Collected& c, std::size_t total, const fs::path& folder) {
  return fmt::format("stopped after {} of {} frames; {}", c.frames, total,
                     c.samples > 0 ? fmt::format("the {} samples of {} objects so far are in {}", c.samples,
                                                 c.instances, io::printable(folder.string()))
                                   : "there were no objects so far");
}

}  // namespace

OptionGroup declare(CollectOptions& options) {
  OptionGroup group("collect", "Collection of object samples from a sequence.");
  group.add("first", &options.first, "First frame.").range(0);
  group.add("every", &options.every, "Use every N-th frame.").range(1);
  group.add("max-frames", &options.maxFrames, "Number of frames; 0: all.").range(0);
  group.add("max-views", &options.maxViews, "Largest number of views of one object (thesis Table 6.2).")
      .range(1);
  using Method = ClusterOptions::Method;
  group
      .add("clusters", options.clusters.method,
           {{{"convexity", "convex parts, joined where they are one thing"}, Method::convexity},
            {{"euclidean", "what is 15 mm apart, as in the thesis"}, Method::euclidean}},
           "What an object is.")
      .why("euclidean to repeat the thesis; things that touch are one then");
  group.add("replace", &options.replace, "Replace the samples in an existing folder.");
  group.add("strict", &options.strict, "Fail at a frame that cannot be read instead of skipping it.");
  return group;
}

Collected collectObjects(const Sequence& sequence, const fs::path& folder, const CollectOptions& options,
                         Progress& progress, std::vector<std::string>* problems) {
  validate(options);
  requireClusterable(sequence);
  if (options.first >= sequence.size())
    fail(ErrorCode::invalidOption, "the first frame is {}, but {} has {}; give a smaller number",
         options.first, sequence.name(), sequence.size());
  NewSamples made(folder, options.replace);
  Collector collector(made.folder(), options);
  Collected& counts = collector.collected();
  std::string first;  // problem
  std::size_t total = 1 + (sequence.size() - options.first - 1) / options.every;
  if (options.maxFrames > 0) total = std::min(total, options.maxFrames);
  const auto keep = [&] {
    if (!collector.samples().empty()) made.finish(collector.samples());
  };
  progress.begin("collecting", total);
  try {
    for (std::size_t i = options.first; counts.frames < total; i += options.every) {
      if (interrupted()) {
        keep();
        throw Interrupted(interruptionOf(collector.collected(), total, folder));
      }
      ++counts.frames;
      std::optional<ClusteredFrame> frame;
      try {
        const ImageAndDepth read = readImageAndDepth(sequence, i);
        frame = clusteredFrame(read.image, read.depth, *sequence.intrinsics(), options.clusters);
      } catch (...) {
        const std::string& name = sequence.frame(i).name;
        const Error failure = frameFailure(name);
        if (options.strict) throw failure;
        ++counts.unread;
        if (first.empty()) first = fmt::format("{}: {}", name, failure.what());
        if (problems != nullptr) problems->push_back(fmt::format("{}: {}", name, failure.what()));
      }
      if (frame) collector.add(*frame, sequence.frame(i));
      progress.advance();
    }
  } catch (const Interrupted&) {
    throw;
  } catch (...) {
    try {
      keep();
    } catch (const Error&) {  // the disk may be full: the first error is reported
    }
    throw;
  }
  progress.end();
  if (counts.unread == counts.frames)
    fail(ErrorCode::fileUnreadable, "{}: none of the {} frames can be read with its depth; the first: {}",
         sequence.name(), total, first);
  keep();
  return collector.collected();
}

}  // namespace estancia
