// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/object_crops.hpp"

#include <utility>
#include <vector>

namespace estancia {
namespace {

class Crops final : public Sequence {
 public:
  Crops(const ObjectViews& views, const CropOptions& options) : views_(views), options_(options) {
    warnings_ = views.warnings();
    for (std::size_t i = 0; i < views.size(); ++i) {
      Frame frame;
      frame.name = views.view(i).name;
      frame.room = views.view(i).category;
      frames_.push_back(std::move(frame));
    }
  }

  std::string name() const override { return views_.name(); }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }

  cv::Mat image(std::size_t i) const override {
    const ObjectImage view = views_.image(i);
    if (!view.image.empty()) return cropObject(view.image, view.box, view.mask, options_);
    constexpr int size = 299;  // what the larger networks take
    return renderObject(views_.cloud(i), size, options_);
  }

 private:
  const ObjectViews& views_;
  CropOptions options_;
  std::vector<Frame> frames_;
};

}  // namespace

std::unique_ptr<Sequence> cropsOf(const ObjectViews& views, const CropOptions& options) {
  return std::make_unique<Crops>(views, options);
}

}  // namespace estancia
