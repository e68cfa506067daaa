// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/map_file_view.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/world/edit_areas.hpp"
#include "estancia/world/edit_objects.hpp"

namespace estancia {
namespace {

/// Changes when the file is written: also while its newest part still stands beside it (SQLite's WAL).
std::string stampOf(const std::filesystem::path& path) {
  std::string stamp;
  for (const char* ending : {"", "-wal"}) {
    struct stat file {};
    if (stat((path.string() + ending).c_str(), &file) != 0 || file.st_size == 0) continue;
    stamp +=
        fmt::format("{} {} {}.{};", file.st_ino, file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec);
  }
  return stamp;
}

struct EditOfFile {
  const std::filesystem::path& path;

  void operator()(const NameArea& edit) const { nameArea(path, std::to_string(edit.area), edit.name); }
  void operator()(const MergeAreas& edit) const {
    mergeAreas(path, std::to_string(edit.area), std::to_string(edit.other));
  }
  void operator()(const SplitArea& edit) const { splitArea(path, edit.from, edit.to); }
  void operator()(const NameObject& edit) const { nameObject(path, std::to_string(edit.object), edit.name); }
  void operator()(const DeleteObject& edit) const { deleteObject(path, std::to_string(edit.object)); }
};

}  // namespace

MapFileView::MapFileView(std::filesystem::path path)
    : path_(std::move(path)),
      stamp_(stampOf(path_)),
      world_(std::make_shared<const WorldMap>(readWorld(path_))) {}

void MapFileView::readIfChanged() const {
  const std::lock_guard onlyOne(file_);
  std::string stamp = stampOf(path_);
  if (stamp == stamp_) return;
  stamp_ = std::move(stamp);
  std::shared_ptr<const WorldMap> world;
  std::string trouble;
  try {
    world = std::make_shared<const WorldMap>(readWorld(path_));
  } catch (const Error& e) {
    trouble = e.what();  // what was read before stays
  }
  const std::lock_guard lock(mutex_);
  if (world != nullptr) world_ = std::move(world);
  trouble_ = std::move(trouble);
  ++revision_;
  changed_.notify_all();
}

LiveStatus MapFileView::status() const {
  readIfChanged();
  const std::lock_guard lock(mutex_);
  LiveStatus status;
  status.revision = status.mapRevision = revision_;
  status.state = "ended";
  status.source = path_.filename();
  if (!trouble_.empty()) status.troubles.push_back(trouble_);
  return status;
}

LiveStatus MapFileView::waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds between(250);  // two looks at the file
  const auto until = Clock::now() + patience;
  for (;;) {
    LiveStatus now = status();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (now.revision != revision || left.count() <= 0) return now;
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::min(between, left), [&] { return revision_ != revision; });
  }
}

std::shared_ptr<const WorldMap> MapFileView::world() const {
  const std::lock_guard lock(mutex_);
  return world_;
}

std::vector<unsigned char> MapFileView::objectImage(int object) const {
  return readObjectImage(path_, object);
}

void MapFileView::edit(const MapEdit& edit) {
  {
    const std::lock_guard onlyOne(file_);
    std::visit(EditOfFile{path_}, edit);
  }
  readIfChanged();
}

}  // namespace estancia
