// Finds known objects and their poses in a point cloud.
//   07_find_objects MODEL SCENE     (PCD or PLY)
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 07_find_objects MODEL SCENE\n", stderr), 2;
  estancia::Recognizer recognizer;
  recognizer.addModel("object", estancia::readCloud(argv[1]));
  for (const auto& found : recognizer.detect(estancia::readCloud(argv[2]))) {
    const cv::Point3d at = found.pose * found.center;  // in the frame of the scene [m]
    std::printf("%s at (%.3f, %.3f, %.3f), confidence %.2f\n", found.model.c_str(), at.x, at.y, at.z,
                found.confidence);
  }
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
