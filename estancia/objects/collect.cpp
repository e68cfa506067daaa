#include "estancia/objects/collect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>
#include <set>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/object_samples.hpp"
#include "estancia/io/picture.hpp"
#include "estancia/objects/clustered_frame.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

void requireOptions(const CollectOptions& options) {
  if (options.every == 0 || options.views == 0)
    throw Error("collect: at least every frame and one view of each thing are to be taken, not 0");
}

void makeFolder(const fs::path& folder) {
  std::error_code failed;
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder)))
    throw Error(
        fmt::format("{} is there already; give another name, or replace the samples in it by "
                    "--overwrite",
                    io::printable(folder.string())));
  for (const auto& part : {pictureOf(folder, "x").parent_path(), cloudOf(folder, "x").parent_path()})
    if (fs::create_directories(part, failed); failed)
      throw Error(
          fmt::format("{}: the folder cannot be made ({})", io::printable(part.string()), failed.message()));
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
    inParallel(kept.size(), static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
               [&](std::size_t k) { write(frame, kept[k], samples_[first + k]); });
  }

  /// The list of what was gathered so far.
  void close() { writeObjectSamples(folder_, samples_); }

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
    const cv::Mat patch = patchOf(frame, i, options_.patches);
    const cv::Size size = boxOf(frame, i).size();
    sample.box =
        cv::Rect((patch.cols - size.width) / 2, (patch.rows - size.height) / 2, size.width, size.height);
    writePng(pictureOf(folder_, sample.view.name), patch);
    writeCloud(cloudOf(folder_, sample.view.name), cloudOf(frame, i));
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
  makeFolder(folder);
  Collector collector(folder, options);
  Collected& counts = collector.collected();
  const std::size_t left = sequence.size() - options.first;
  std::size_t total = (left + options.every - 1) / options.every;
  if (options.frames > 0) total = std::min(total, options.frames);
  progress.begin("collecting", total);
  for (std::size_t i = options.first; counts.frames < total; i += options.every) {
    if (interrupted()) {
      collector.close();
      throw Interrupted(fmt::format(
          "stopped after {} of {} frames; the {} samples of {} things so far are in {}", counts.frames, total,
          collector.collected().samples, collector.collected().instances, io::printable(folder.string())));
    }
    ++counts.frames;
    ImageAndDepth read;
    try {
      read = readImageAndDepth(sequence, i);
    } catch (const Error& error) {
      if (options.strict) {
        collector.close();
        throw;
      }
      ++counts.unread;
      if (problems != nullptr)
        problems->push_back(fmt::format("{}: {}", sequence.frame(i).name, error.what()));
    }
    if (!read.depth.empty())
      collector.add(clusteredFrame(read.image, read.depth, *sequence.intrinsics(), options.clusters),
                    sequence.frame(i));
    progress.advance();
  }
  progress.end();
  if (counts.unread == counts.frames)
    throw Error(fmt::format("{}: none of the {} frames can be read with its depth", sequence.name(), total));
  collector.close();
  return collector.collected();
}

void clearObjectSamples(const fs::path& folder) {
  std::set<fs::path> ours{folder / "samples.csv", wordsOf(folder)};
  for (const ObjectSample& sample : readObjectSamples(folder)) {
    ours.insert(pictureOf(folder, sample.view.name));
    ours.insert(cloudOf(folder, sample.view.name));
  }
  const std::set<fs::path> folders{pictureOf(folder, "x").parent_path(), cloudOf(folder, "x").parent_path()};
  for (const auto& there : fs::recursive_directory_iterator(folder))
    if (!ours.contains(there.path()) && !(there.is_directory() && folders.contains(there.path())))
      throw Error(fmt::format("{} is none of the samples there, so nothing is replaced; move it away first",
                              io::printable(there.path().string())));
  for (const fs::path& file : ours) fs::remove(file);
  for (const fs::path& part : folders) fs::remove(part);
}

}  // namespace estancia
