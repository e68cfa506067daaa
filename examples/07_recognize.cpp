// Where is my mug? A scene is cleaned by Growing Neural Gas where it is noisy, then a known object is looked
// for in it.
//   07_recognize MODEL SCENE     (PCD or PLY)
#include <estancia/io/cloud_file.hpp>
#include <estancia/recognition/recognizer.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 07_recognize MODEL SCENE\n", stderr), 2;
  estancia::Progress silent;
  const estancia::Recognizer recognizer(estancia::RecognitionOptions::preset("default"));
  const auto model = recognizer.prepareModel("object", estancia::readCloud(argv[1]));  // once, for all scenes
  const auto scene = recognizer.prepareScene("scene", estancia::readCloud(argv[2]), silent);
  for (const auto& found : recognizer.find(*model, *scene)) {
    std::printf("confidence %.2f, T_scene_object:\n", found.confidence);
    for (int row = 0; row < 4; ++row)
      std::printf("%9.4f %9.4f %9.4f %9.4f\n", found.pose.matrix(row, 0), found.pose.matrix(row, 1),
                  found.pose.matrix(row, 2), found.pose.matrix(row, 3));
  }
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
