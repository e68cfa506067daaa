// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/annotated_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/figures/color.hpp"

namespace estancia::report {
namespace {

/// Colors that people distinguish, by Wong, Nature Methods 8 (2011), BGR.
cv::Scalar colorOf(FusedAnswer::Source source) {
  using enum FusedAnswer::Source;
  return source == both    ? cv::Scalar(115, 158, 0)
         : source == shape ? cv::Scalar(178, 114, 0)
         : source == image ? cv::Scalar(0, 159, 230)
                           : cv::Scalar(128, 128, 128);
}

std::string captionOf(const PredictedObject& object, const std::vector<std::string>& words) {
  const auto word = static_cast<std::size_t>(object.answer.classIndex);
  if (object.answer.classIndex < 0) return fmt::format("{}", object.instance);
  if (word >= words.size())
    fail(ErrorCode::mismatch, "object {} has class {} of {}; give the classes of its model", object.instance,
         word + 1, words.size());
  // OpenCV's font knows ASCII only.
  std::string name = cleanText(words[word]);
  for (char& c : name)
    if (c < ' ' || c > '~') c = '?';
  return fmt::format("{} {} {:.0f}%", object.instance, name, 100 * object.answer.probability);
}

}  // namespace

cv::Mat drawObjects(const cv::Mat& image, std::span<const PredictedObject> objects,
                    const std::vector<std::string>& words) {
  if (image.empty() || image.type() != CV_8UC3)
    throw Error(ErrorCode::invalidInput, "objects are drawn into a BGR image of 8 bits; convert the image");
  cv::Mat drawn = image.clone();
  const int font = cv::FONT_HERSHEY_SIMPLEX;
  const double size = 0.4 * std::max(1., image.cols / 640.);
  for (const PredictedObject& object : objects)
    cv::rectangle(drawn, object.box, colorOf(object.answer.source), 2);
  for (const PredictedObject& object : objects) {
    const std::string caption = captionOf(object, words);
    int below = 0;
    const cv::Size text = cv::getTextSize(caption, font, size, 1, &below);
    const cv::Point corner(std::clamp(object.box.x, 0, std::max(0, image.cols - text.width)),
                           std::max(object.box.y, text.height + below));
    cv::rectangle(drawn, corner + cv::Point(0, below), corner + cv::Point(text.width, -text.height),
                  colorOf(object.answer.source), cv::FILLED);
    cv::putText(drawn, caption, corner, font, size, cv::Scalar::all(255), 1, cv::LINE_AA);
  }
  return drawn;
}

namespace {

const cv::Scalar paper(255, 255, 255), dark(50, 50, 50);

/// Half paper, half color: names and paths read well on it.
cv::Scalar tint(Color color) {
  return {(255.0 + color.blue) / 2, (255.0 + color.green) / 2, (255.0 + color.red) / 2};
}

/// The part of the plan in which anything is, with a margin.
cv::Rect usedPart(const Areas& areas) {
  cv::Mat used = areas.areaOf >= 0;
  used |= areas.walls;
  const cv::Rect box = cv::boundingRect(used);
  constexpr int margin = 4;
  return (box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin)) &
         cv::Rect(0, 0, used.cols, used.rows);
}

class Drawing {
 public:
  Drawing(const Areas& areas, int width)
      : areas_(areas),
        part_(usedPart(areas)),
        scale_(std::max(1, width / std::max(1, part_.width))),
        image_(part_.height * scale_, part_.width * scale_, CV_8UC3, paper) {}

  template <class ColorOf>
  void paintCells(ColorOf colorAt) {
    for (int row = 0; row < part_.height; ++row)
      for (int column = 0; column < part_.width; ++column) {
        const cv::Point cell = part_.tl() + cv::Point(column, row);
        const int area = areas_.areaOf.at<int>(cell);
        if (areas_.walls.at<unsigned char>(cell) != 0)
          fill(column, row, dark);
        else if (area >= 0)
          fill(column, row, colorAt(cell, area));
      }
  }

  void drawPath() {
    for (const Frame& frame : areas_.zones.frames)
      if (frame.pose && frame.pose->isPlausible()) {
        const PlanarPose at = areas_.floor.project(*frame.pose);
        cv::circle(image_, pixelOf({at.x, at.y}), std::max(1, scale_ / 3), dark, cv::FILLED, cv::LINE_AA);
      }
  }

  void drawNames() {
    for (const Area& area : areas_.areas) {
      const std::string first = area.name.substr(0, area.name.find(','));
      const std::string text = std::to_string(area.id) + " " + first;
      int below = 0;
      const double size = 0.5;
      const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below);
      cv::Point at = pixelOf(area.center) - cv::Point(box.width / 2, -box.height / 2);
      at.x = std::clamp(at.x, 2, std::max(2, image_.cols - box.width - 2));
      cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, size, paper, 3, cv::LINE_AA);
      cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, size, dark, 1, cv::LINE_AA);
    }
  }

  /// A bar of a meter.
  void drawScale() {
    const int meter = static_cast<int>(scale_ / areas_.cells.cell());
    const cv::Point at(8, image_.rows - 10);
    cv::line(image_, at, at + cv::Point(meter, 0), dark, 2);
    cv::putText(image_, "1 m", at + cv::Point(4, -5), cv::FONT_HERSHEY_SIMPLEX, 0.45, dark, 1, cv::LINE_AA);
  }

  cv::Mat image() const { return image_; }

 private:
  void fill(int column, int row, const cv::Scalar& color) {
    const int up = part_.height - 1 - row;  // the second axis goes up
    cv::rectangle(image_, cv::Rect(column * scale_, up * scale_, scale_, scale_), color, cv::FILLED);
  }

  cv::Point pixelOf(const cv::Point2d& at) const {
    const cv::Point cell = areas_.cells.at(at.x, at.y) - part_.tl();
    return {cell.x * scale_ + scale_ / 2, (part_.height - 1 - cell.y) * scale_ + scale_ / 2};
  }

  const Areas& areas_;
  cv::Rect part_;
  int scale_;
  cv::Mat image_;
};

}  // namespace

cv::Mat drawFloorPlan(const Areas& areas, const FloorHeat* heat, int width) {
  Drawing drawing(areas, width);
  double most = 0;
  if (heat != nullptr && !heat->values.empty()) cv::minMaxLoc(heat->values, nullptr, &most);
  drawing.paintCells([&](cv::Point cell, int area) {
    if (heat == nullptr) return tint(classStyle(static_cast<std::size_t>(area)).fill);
    const cv::Point2d at = areas.cells.centerOf(cell);
    const cv::Point place = heat->cells.at(at.x, at.y);
    const float value = heat->cells.holds(place) ? heat->values.at<float>(place) : 0;
    const Color color = viridis(most > 0 ? value / most : 0);
    return cv::Scalar(color.blue, color.green, color.red);
  });
  drawing.drawPath();
  drawing.drawNames();
  drawing.drawScale();
  return drawing.image();
}

}  // namespace estancia::report
