// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/live_board.hpp"

#include <exception>
#include <utility>

#include "estancia/files/image_writer.hpp"

namespace estancia {
namespace {

constexpr int widthOfImages = 480;  // [pixels]

}  // namespace

LiveStatus LiveBoard::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

LiveStatus LiveBoard::waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience, [&] { return status_.revision != revision; });
  return status_;
}

void LiveBoard::change(const std::function<void(LiveStatus&)>& change) {
  const std::lock_guard lock(mutex_);
  change(status_);
  ++status_.revision;
  changed_.notify_all();
}

void LiveBoard::setImage(const cv::Mat& bgr) {
  const std::lock_guard lock(imageMutex_);
  image_ = bgr;
  jpeg_.reset();
}

std::shared_ptr<const std::vector<unsigned char>> LiveBoard::image() const {
  const std::lock_guard lock(imageMutex_);
  if (!jpeg_ && !image_.empty()) {
    try {
      jpeg_ = std::make_shared<const std::vector<unsigned char>>(encodeImage(image_, widthOfImages));
    } catch (const std::exception&) {  // no image is better than no page
    }
  }
  return jpeg_;
}

void LiveBoard::setWorld(std::shared_ptr<const WorldMap> world) {
  change([&](LiveStatus& status) {
    world_ = std::move(world);
    ++status.mapRevision;
  });
}

std::shared_ptr<const WorldMap> LiveBoard::world() const {
  const std::lock_guard lock(mutex_);
  return world_;
}

std::pair<std::shared_ptr<const WorldMap>, std::uint64_t> LiveBoard::worldAndRevision() const {
  const std::lock_guard lock(mutex_);
  return {world_, status_.mapRevision};
}

}  // namespace estancia
