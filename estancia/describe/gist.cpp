#include "estancia/describe/gist.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/describe/gist_filters.hpp"
#include "estancia/describe/local_contrast.hpp"

namespace estancia {
namespace {

using namespace describe;

/// The image's central square, the mean of its channels, 0 to 255.
cv::Mat square(const cv::Mat& image) {
  if (image.empty()) throw Error(ErrorCode::invalidInput, "gist: the view has no image; give one");
  if (image.type() != CV_8UC3 && image.type() != CV_8UC1)
    throw Error(ErrorCode::invalidInput, "gist: the image is neither BGR nor gray with 8 bits; convert it");
  const int side = std::min(image.cols, image.rows);
  const cv::Mat part = image({(image.cols - side) / 2, (image.rows - side) / 2, side, side});
  cv::Mat gray, sized;
  part.convertTo(gray, CV_32F);
  if (gray.channels() == 3) cv::transform(gray, gray, cv::Matx13f(1, 1, 1));
  cv::resize(gray, sized, {kGistSide, kGistSide}, 0, 0, side > kGistSide ? cv::INTER_AREA : cv::INTER_LINEAR);
  double darkest = 0, brightest = 0;
  cv::minMaxLoc(sized, &darkest, &brightest);
  if (!(brightest > darkest)) return cv::Mat::zeros(sized.size(), CV_32F);
  sized.convertTo(sized, CV_32F, 255 / (brightest - darkest), -255 * darkest / (brightest - darkest));
  return sized;
}

}  // namespace

std::vector<float> gist(const cv::Mat& image) {
  return meanAnswers(withEqualContrast(square(image)));
}

std::vector<DescriptorPart> Gist::parts() const {
  DescriptorPart part{
      "gist", PartKind::energies, {}, "gist 1, 256 pixels, 4 scales, 8 orientations, 4 blocks"};
  for (int scale = 0; scale < kGistScales; ++scale)
    for (int orientation = 0; orientation < kGistOrientations; ++orientation)
      for (int block = 0; block < kGistBlocks * kGistBlocks; ++block)
        part.columns.push_back(fmt::format("gist {}.{}.{}", scale, orientation, block));
  return {std::move(part)};
}

}  // namespace estancia
