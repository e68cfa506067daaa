// Live board: what the loop's thread knows, for all other threads. Private; see LiveView.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <opencv2/core/mat.hpp>

#include "estancia/files/image_writer.hpp"
#include "estancia/live/live_view.hpp"

namespace estancia {

/// State of a live view that threads share. Invariant: mutex_ guards status_ and world_, whose revisions grow
/// with each change; imageMutex_ guards image_ and jpeg_, which is empty or the encoded image_.
class LiveBoard {
 public:
  LiveStatus status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }

  LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return status_.revision != revision; });
    return status_;
  }

  /// Encoded when it is first asked for.
  std::shared_ptr<const std::vector<unsigned char>> image() const {
    const std::lock_guard lock(imageMutex_);
    if (!jpeg_ && !image_.empty()) {
      try {
        jpeg_ = std::make_shared<const std::vector<unsigned char>>(encodeImage(image_, /*width=*/480));
      } catch (const std::exception&) {  // no image is better than no page
      }
    }
    return jpeg_;
  }

  std::shared_ptr<const WorldMap> world() const {
    const std::lock_guard lock(mutex_);
    return world_;
  }

  /// The world and its LiveStatus::mapRevision.
  std::pair<std::shared_ptr<const WorldMap>, std::uint64_t> worldAndRevision() const {
    const std::lock_guard lock(mutex_);
    return {world_, status_.mapRevision};
  }

  /// Changes the status and notifies waiting threads.
  void change(const std::function<void(LiveStatus&)>& change) {
    const std::lock_guard lock(mutex_);
    change(status_);
    ++status_.revision;
    changed_.notify_all();
  }

  void setImage(const cv::Mat& bgr) {
    const std::lock_guard lock(imageMutex_);
    image_ = bgr;
    jpeg_.reset();
  }

  void setWorld(std::shared_ptr<const WorldMap> world) {
    change([&](LiveStatus& status) {
      world_ = std::move(world);
      ++status.mapRevision;
    });
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  LiveStatus status_;
  std::shared_ptr<const WorldMap> world_;

  mutable std::mutex imageMutex_;
  mutable cv::Mat image_;
  mutable std::shared_ptr<const std::vector<unsigned char>> jpeg_;
};

}  // namespace estancia
