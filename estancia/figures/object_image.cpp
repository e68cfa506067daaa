// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/object_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/figures/text.hpp"

namespace estancia::report {
namespace {

/// Colors that people distinguish, by Wong, Nature Methods 8 (2011), BGR.
cv::Scalar colorOf(FusedAnswer::Source source) {
  switch (source) {
    case FusedAnswer::Source::both:
      return {115, 158, 0};
    case FusedAnswer::Source::shape:
      return {178, 114, 0};
    case FusedAnswer::Source::image:
      return {0, 159, 230};
    case FusedAnswer::Source::none:
      break;
  }
  return {128, 128, 128};
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

}  // namespace estancia::report
