// Map file view: a map at rest for the page, the API and agents; read again when its file changes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>

#include "estancia/live/live_view.hpp"

namespace estancia {

/// Changes when the file, or its newest part beside it (SQLite's WAL), is written. "" where there is none.
std::string fileStamp(const std::filesystem::path& path);

/// Shows a map file without a camera, so the robot's position is unknown: LiveStatus has no places.
/// Invariant: world_ is the file's content as of stamp_; each question reads the file again if it has
/// changed.
class MapFileView final : public LiveView {
 public:
  /// Throws Error as readWorld() does.
  explicit MapFileView(std::filesystem::path path);

  LiveStatus status() const override;
  LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const override;
  std::shared_ptr<const std::vector<unsigned char>> image() const override { return nullptr; }
  std::shared_ptr<const WorldMap> world() const override;
  std::vector<unsigned char> objectImage(int object) const override;
  /// Map files hold no images of places.
  std::vector<unsigned char> placeImage(int node) const override;
  nlohmann::ordered_json changes(const std::optional<std::size_t>& since) const override;
  using LiveView::edit;
  void edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) override;

 private:
  void readIfChanged() const;

  std::filesystem::path path_;
  /// Locked while the file is read or written.
  mutable std::mutex file_;
  mutable std::string stamp_;  // stamp of the file that was read; under file_
  mutable std::mutex mutex_;   // guards the members below
  mutable std::condition_variable changed_;
  mutable std::shared_ptr<const WorldMap> world_;
  mutable std::uint64_t revision_ = 1;
  mutable std::string trouble_;
};

}  // namespace estancia
