// Object samples (object_samples.hpp) as object views.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "estancia/core/fail.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/object_samples.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

class SampleViews final : public ListedObjectViews {
 public:
  SampleViews(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.minPoints), folder_(folder) {
    const std::vector<ObjectSample> samples = readObjectSamples(folder);
    LeftOut leftOut;
    for (const ObjectSample& sample : samples) {
      const fs::path files[] = {imageOf(folder, sample.view.name), cloudOf(folder, sample.view.name)};
      const auto* missing =
          std::ranges::find_if(files, [](const fs::path& f) { return !fs::is_regular_file(f); });
      if (missing != std::end(files)) {
        leftOut.add(fmt::format("{} is missing", printable(missing->string())));
        continue;
      }
      boxes_.push_back(sample.box);
      add(sample.view);
    }
    if (!leftOut.none()) warn(leftOut.sentence(samples.size(), "samples"));
  }

  PointCloud cloud(std::size_t i) const override {
    return enough(readCloud(cloudOf(folder_, view(i).name)), view(i).name);
  }

  ObjectImage image(std::size_t i) const override {
    const fs::path file = imageOf(folder_, view(i).name);
    ObjectImage seen{readImage(file), boxes_[i], {}};
    if ((seen.box & cv::Rect({}, seen.image.size())) != seen.box)
      fail(ErrorCode::mismatch, "{}: {} × {} pixels, smaller than the box in samples.csv", printable(file),
           seen.image.cols, seen.image.rows);
    const fs::path mask = maskOf(folder_, view(i).name);
    if (!fs::is_regular_file(mask)) return seen;
    seen.mask = readLabelImage(mask);
    if (seen.mask.size() != seen.image.size())
      fail(ErrorCode::mismatch, "{}: {} × {} pixels, but its image has {} × {}", printable(mask),
           seen.mask.cols, seen.mask.rows, seen.image.cols, seen.image.rows);
    return seen;
  }

 private:
  fs::path folder_;
  std::vector<cv::Rect> boxes_;
};

}  // namespace

/// Also with a malformed list, so that opening reports it.
bool isSampleViews(const fs::path& folder) {
  return fs::exists(folder / "samples.csv") || (fs::is_directory(imageOf(folder, "x").parent_path()) &&
                                                fs::is_directory(cloudOf(folder, "x").parent_path()));
}

OpenedViews openSampleViews(const fs::path& folder, const ObjectViewsOptions& options) {
  return std::make_unique<SampleViews>(folder, options);
}

}  // namespace estancia::io
