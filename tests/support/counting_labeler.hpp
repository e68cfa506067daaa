// A labeler that counts the images that it is shown.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estancia/labelers/labeler.hpp"

namespace estancia::test {

/// Gives every image the same words.
class CountingLabeler : public Labeler {
 public:
  CountingLabeler(const std::vector<std::string>& labels, LexicalDescriptor words)
      : vocabulary_(labels), words_(std::move(words)) {}
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "test"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& /*frame*/) const override { return {bgr, "", {}}; }
  LexicalDescriptor infer(const Prepared& /*image*/) override {
    ++asked;
    return words_;
  }
  std::size_t asked = 0;

 private:
  Vocabulary vocabulary_;
  LexicalDescriptor words_;
};

}  // namespace estancia::test
