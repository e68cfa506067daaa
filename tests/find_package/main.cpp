// Uses an installed Estancia: one class that reaches into a library Estancia links, the modules with image
// codecs and video input, and every error as Estancia's. SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iostream>
#include <opencv2/core/mat.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/readers/open_sequence.hpp"

int main() {
  const estancia::Vocabulary vocabulary({"cup", "mug"});
  std::cout << vocabulary.size() << " labels, digest " << vocabulary.digest() << ", "
            << cv::Mat(1, 2, CV_32F).total() << " values\n";
  std::ofstream("pixel.ppm") << "P6 1 1 255 abc";
  std::cout << "an image of " << estancia::readImage("pixel.ppm").total() << " pixel\n";
  std::ofstream("no.mp4") << '\1';
  try {
    estancia::openSequence("no.mp4");
    return 1;
  } catch (const estancia::Error& error) {
    std::cout << "refused: " << error.what() << '\n';
    if (error.code() != estancia::ErrorCode::unsupportedFile) return 1;
  }
  try {
    estancia::Vocabulary({});
  } catch (const estancia::Error& error) {
    std::cout << "refused: " << error.what() << '\n';
    return 0;
  }
  return 1;
}
