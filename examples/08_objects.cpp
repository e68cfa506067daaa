// Classifies the objects of each frame by image, by shape, and by their late fusion.
//   08_objects MODEL SEQUENCE     (MODEL of `estancia objects train`; a sequence with depth)
// SPDX-License-Identifier: Apache-2.0
#include <estancia/estancia.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 08_objects MODEL SEQUENCE\n", stderr), 2;
  const auto model = estancia::readObjectModel(argv[1]);
  const auto sequence = estancia::openSequence(argv[2]);
  const auto labeler = estancia::loadModel();

  estancia::ObjectPredictor predictor(model, labeler.get());
  for (std::size_t i = 0; i < sequence->size(); ++i)
    for (const auto& object : predictor.predict(sequence->image(i), sequence->depth(i),
                                                sequence->intrinsics().value(), sequence->frame(i).pose)) {
      const int c = object.answer.classIndex;
      std::printf("%s object %zu: %s (%s)\n", sequence->frame(i).name.c_str(), object.instance,
                  c < 0 ? "?" : model.targets().classes[static_cast<std::size_t>(c)].name.c_str(),
                  object.answer.why.c_str());
    }
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
