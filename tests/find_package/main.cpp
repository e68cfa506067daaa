// Uses an installed Estancia: one class that reaches into a library Estancia links, and every error as
// Estancia's.
// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <opencv2/core/mat.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/vocabulary.hpp"

int main() {
  const estancia::Vocabulary vocabulary({"cup", "mug"});
  std::cout << vocabulary.size() << " labels, digest " << vocabulary.digest() << ", "
            << cv::Mat(1, 2, CV_32F).total() << " values\n";
  try {
    estancia::Vocabulary({});
  } catch (const estancia::Error& error) {
    std::cout << "refused: " << error.what() << '\n';
    return 0;
  }
  return 1;
}
