// Folders of point clouds: CATEGORY/VIEW.pcd (one instance) or CATEGORY/INSTANCE/VIEW.pcd.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "estancia/core/cores.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

const std::vector<std::string>& suffixes() {
  static const std::vector<std::string> known = {".pcd", ".ply"};
  return known;
}

struct CloudView {
  fs::path file;
  ObjectView view;
};

/// The clouds of a folder: views of one instance, named by its path from the top.
void list(std::vector<CloudView>& found, const fs::path& folder, const std::string& instance,
          const std::string& category) {
  for (const fs::path& file : filesIn(folder, suffixes())) {
    const std::string name = printable(file.filename());
    found.push_back(
        {file, {.name = fmt::format("{}/{}", instance, name), .instance = instance, .category = category}});
  }
}

class CloudViews final : public ListedObjectViews {
 public:
  CloudViews(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.minPoints) {
    std::vector<CloudView> found;
    for (const fs::path& category : foldersIn(folder)) {
      const std::string name = printable(category.filename());
      list(found, category, name, name);
      for (const fs::path& instance : foldersIn(category))
        list(found, instance, fmt::format("{}/{}", name, printable(instance.filename())), name);
    }
    // The number of points is known after reading.
    std::vector<std::optional<std::string>> problems(found.size());
    inParallel(found.size(), static_cast<std::size_t>(usableCores()), [&](std::size_t i) {
      try {
        enough(readCloud(found[i].file), found[i].view.name);
      } catch (...) {
        problems[i] = frameFailure(found[i].view.name).what();
      }
    });
    LeftOut leftOut;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (problems[i]) {
        leftOut.add(*problems[i]);
        continue;
      }
      files_.push_back(std::move(found[i].file));
      add(std::move(found[i].view));
    }
    if (!leftOut.none()) warn(leftOut.sentence(found.size(), "clouds"));
  }

  PointCloud cloud(std::size_t i) const override { return enough(readCloud(files_.at(i)), view(i).name); }
  ObjectImage image(std::size_t i) const override {
    view(i);
    return {};
  }

 private:
  std::vector<fs::path> files_;
};

bool holdsClouds(const fs::path& folder) {
  return !filesIn(folder, suffixes()).empty();
}

bool isCloudViews(const fs::path& folder) {
  for (const fs::path& category : foldersIn(folder)) {
    if (holdsClouds(category)) return true;
    for (const fs::path& instance : foldersIn(category))
      if (holdsClouds(instance)) return true;
  }
  return false;
}

}  // namespace

const ViewFormat cloudViews{
    "clouds", "one folder per category: CATEGORY/VIEW.pcd (.ply), or CATEGORY/INSTANCE/VIEW.pcd",
    isCloudViews, openViewsAs<CloudViews>};

}  // namespace estancia::io
