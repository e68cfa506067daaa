// An image becomes words: the ten most probable labels of an image.
//   01_label_an_image IMAGE [MODEL]
// SPDX-License-Identifier: Apache-2.0
#include <estancia/files/image_file.hpp>
#include <estancia/labelers/model.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <numeric>
#include <vector>

int main(int argc, char** argv) try {
  if (argc < 2) return std::fputs("usage: 01_label_an_image IMAGE [MODEL]\n", stderr), 2;
  const auto labeler = estancia::loadModel(argc > 2 ? argv[2] : estancia::defaultModel);
  const estancia::LexicalDescriptor p = labeler->label(estancia::readImage(argv[1]));

  std::vector<std::size_t> best(p.size());
  std::iota(best.begin(), best.end(), std::size_t{0});
  std::partial_sort(best.begin(), best.begin() + std::min<std::ptrdiff_t>(10, std::ssize(best)), best.end(),
                    [&](std::size_t a, std::size_t b) { return p[a] > p[b]; });
  best.resize(std::min<std::size_t>(10, best.size()));
  for (const std::size_t label : best)
    std::printf("%5.1f %%  %s\n", 100 * static_cast<double>(p[label]), labeler->vocabulary()[label].c_str());
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
