// Live board: what the loop's thread knows, for all other threads. Private; see LiveView.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

#include "estancia/live/live_view.hpp"

namespace estancia {

/// State of a live view that threads share. Invariant: mutex_ guards status_ and world_, whose revisions grow
/// with each change; imageMutex_ guards image_ and jpeg_, which is empty or the encoded image_.
class LiveBoard {
 public:
  LiveStatus status() const;
  LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const;
  /// Encoded when it is first asked for.
  std::shared_ptr<const std::vector<unsigned char>> image() const;
  std::shared_ptr<const WorldMap> world() const;
  /// The world and its LiveStatus::mapRevision.
  std::pair<std::shared_ptr<const WorldMap>, std::uint64_t> worldAndRevision() const;

  /// Changes the status and notifies waiting threads.
  void change(const std::function<void(LiveStatus&)>& change);
  void setImage(const cv::Mat& bgr);
  void setWorld(std::shared_ptr<const WorldMap> world);

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
