// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/listed_sequence.hpp"

#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_file.hpp"

namespace estancia::io {
namespace fs = std::filesystem;

/// Digits, a point, three digits or more.
std::optional<double> timestampOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto point = stem.find('.');
  const bool plain = stem.find_first_not_of("0123456789.") == std::string::npos;
  if (!plain || point == 0 || point == std::string::npos || stem.size() - point < 4) return std::nullopt;
  return toNumber(stem);
}

void ImageFiles::add(Frame frame, fs::path file, DepthFile depth) {
  entries_.push_back(std::move(frame));
  files_.push_back(std::move(file));
  hasDepth_ = hasDepth_ || !depth.file.empty();
  depths_.push_back(std::move(depth));
}

cv::Mat ImageFiles::image(std::size_t i) const {
  return readImage(files_.at(i));
}

cv::Mat ImageFiles::reducedImage(std::size_t i, int side) const {
  return readReducedImage(files_.at(i), side);
}

std::string ImageFiles::fingerprint(std::size_t i) const {
  return sha256OfFile(files_.at(i));
}

cv::Mat ImageFiles::depth(std::size_t i) const {
  const fs::path& file = depths_.at(i).file;
  if (file.empty())
    fail(ErrorCode::insufficientData, "{}: {} has no depth image; leave it out or add its depth", name_,
         frame(i).name);
  return readDepth(file, depthScale_);
}

std::string nameOf(const fs::path& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  return printable((whole.has_filename() ? whole : whole.parent_path()).filename().string());
}

}  // namespace estancia::io
