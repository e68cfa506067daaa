#include "estancia/objects/collect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/io/object_samples.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/new_samples.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

void requireOptions(const CollectOptions& options) {
  if (options.every == 0 || options.views == 0)
    throw Error("collect: at least every frame and one view of each thing are to be taken, not 0");
}

/// What a patch with the largest margin that can be chosen later shows.
cv::Rect surroundings(const cv::Rect& box) {
  const CropOptions standard;
  const auto reach = static_cast<int>(
      std::ceil(std::max(box.width, box.height) * (0.5 + mostCollectedMargin) / standard.crop));
  const cv::Point middle = (box.tl() + box.br()) / 2;
  return {middle.x - reach - 1, middle.y - reach - 1, 2 * reach + 2, 2 * reach + 2};
}

/// The samples of one sequence, as they come.
class Collector {
 public:
  Collector(const fs::path& folder, const CollectOptions& options)
      : folder_(folder), options_(options), tracks_(options.tracks) {}

  void add(const ClusteredFrame& frame, const Frame& about) {
    const auto& clusters = frame.clusters.clusters;
    const auto things = tracks_.follow(frame.clusters, frame.camera, about.pose);
    count(frame);
    std::vector<std::size_t> kept;
    const std::size_t first = samples_.size();
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      std::size_t& views = viewsOf_[things[i]];
      if (views == options_.views) {
        ++collected_.full;
        continue;
      }
      ObjectSample sample;
      sample.view.instance = fmt::format("thing-{:04}", things[i]);
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
  void count(const ClusteredFrame& frame) {
    const auto& clusters = frame.clusters.clusters;
    collected_.withoutPlane += frame.clusters.planes.empty() ? 1 : 0;
    collected_.withoutCluster += clusters.empty() ? 1 : 0;
    collected_.huge += !clusters.empty() && 2 * clusters.front().points.size() > frame.depth.total() ? 1 : 0;
  }

  void write(const ClusteredFrame& frame, std::size_t i, ObjectSample& sample) const {
    // More than labelers see by default, and which of it is the thing: margin and background are theirs to
    // choose.
    const cv::Rect box = boxOf(frame, i), there = surroundings(box) & cv::Rect({}, frame.image.size());
    sample.box = box - there.tl();
    writePng(frame.image(there), imageOf(folder_, sample.view.name));
    writePng(maskOf(frame, i)(there), maskOf(folder_, sample.view.name));
    writeCloud(cloudOf(frame, i), cloudOf(folder_, sample.view.name));
  }

  const fs::path& folder_;
  const CollectOptions& options_;
  Tracks tracks_;
  std::map<std::size_t, std::size_t> viewsOf_;
  std::vector<ObjectSample> samples_;
  Collected collected_;
};

}  // namespace

Collected collectObjects(const Sequence& sequence, const fs::path& folder, const CollectOptions& options,
                         Progress& progress, std::vector<std::string>* problems) {
  requireOptions(options);
  requireClusterable(sequence);
  if (options.first >= sequence.size())
    throw Error(fmt::format("{} has {} frames; frame {} is behind the last", sequence.name(), sequence.size(),
                            options.first));
  NewSamples made(folder, options.replace);
  Collector collector(made.folder(), options);
  Collected& counts = collector.collected();
  std::size_t total = 1 + (sequence.size() - options.first - 1) / options.every;
  if (options.frames > 0) total = std::min(total, options.frames);
  const auto keep = [&] {
    if (!collector.samples().empty()) made.finish(collector.samples());
  };
  progress.begin("collecting", total);
  try {
    for (std::size_t i = options.first; counts.frames < total; i += options.every) {
      if (interrupted()) {
        keep();
        const bool any = !collector.samples().empty();
        throw Interrupted(fmt::format(
            "stopped after {} of {} frames; {}", counts.frames, total,
            any ? fmt::format("the {} samples of {} things so far are in {}", collector.collected().samples,
                              collector.collected().instances, io::printable(folder.string()))
                : std::string("there were no things by then")));
      }
      ++counts.frames;
      ImageAndDepth read;
      try {
        read = readImageAndDepth(sequence, i);
      } catch (...) {
        const std::string& name = sequence.frame(i).name;
        const Error failure = frameFailure(name);
        if (options.strict) throw failure;
        ++counts.unread;
        if (problems != nullptr) problems->push_back(fmt::format("{}: {}", name, failure.what()));
      }
      if (!read.depth.empty())
        collector.add(clusteredFrame(read.image, read.depth, *sequence.intrinsics(), options.clusters),
                      sequence.frame(i));
      progress.advance();
    }
  } catch (const Interrupted&) {
    throw;
  } catch (...) {
    try {
      keep();
    } catch (const Error&) {  // as when the disk is full: the first error is the one to tell
    }
    throw;
  }
  progress.end();
  if (counts.unread == counts.frames)
    throw Error(fmt::format("{}: none of the {} frames can be read with its depth", sequence.name(), total));
  keep();
  return collector.collected();
}

}  // namespace estancia
