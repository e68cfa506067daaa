// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/map_file_view.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/live/edits.hpp"
#include "estancia/world_query/changes.hpp"

namespace estancia {

MapFileView::MapFileView(std::filesystem::path path)
    : path_(std::move(path)),
      stamp_(fileStamp(path_)),
      world_(std::make_shared<const WorldMap>(readWorld(path_))) {}

void MapFileView::readIfChanged() const {
  const std::lock_guard onlyOne(file_);
  std::string stamp = fileStamp(path_);
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
  readIfChanged();
  const std::lock_guard lock(mutex_);
  return world_;
}

std::vector<unsigned char> MapFileView::objectImage(int object) const {
  return readObjectImage(path_, object);
}

std::vector<unsigned char> MapFileView::placeImage(int node) const {
  return readPlaceImage(path_, *world(), node);
}

nlohmann::ordered_json MapFileView::changes(const std::optional<std::size_t>& since) const {
  return toJson(findChanges(path_, since));
}

void MapFileView::edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) {
  readIfChanged();
  {
    const std::lock_guard onlyOne(file_);
    {
      const std::lock_guard lock(mutex_);
      requireRevision(mapRevision, revision_);
    }
    editMapFile(path_, edit);
  }
  readIfChanged();
}

std::string fileStamp(const std::filesystem::path& path) {
  std::string stamp;
  for (const char* ending : {"", "-wal"}) {
    struct stat file {};
    if (stat((path.string() + ending).c_str(), &file) != 0 || file.st_size == 0) continue;
    stamp +=
        fmt::format("{} {} {}.{};", file.st_ino, file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec);
  }
  return stamp;
}

}  // namespace estancia
