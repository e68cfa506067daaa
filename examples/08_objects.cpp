// Things that name themselves: what stands about in each frame is told by its image and by its shape, and
// which of the two to believe.
//   08_objects MODEL SEQUENCE     (MODEL of `estancia objects train`; a sequence with depth)
#include <estancia/label/model.hpp>
#include <estancia/objects/predict.hpp>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fputs("usage: 08_objects MODEL SEQUENCE\n", stderr), 2;
  const auto model = estancia::ObjectModel::load(argv[1]);
  const auto sequence = estancia::openSequence(argv[2]);
  estancia::requireClusterable(*sequence);
  const auto labeler = estancia::loadModel();

  estancia::ObjectPredictor predictor(model, labeler.get());
  for (std::size_t i = 0; i < sequence->size(); ++i) {
    const auto [image, depth] = estancia::readImageAndDepth(*sequence, i);
    const auto frame = estancia::clusteredFrame(image, depth, *sequence->intrinsics());
    for (const auto& object : predictor.predict(frame, sequence->frame(i).pose)) {
      const int word = object.belief.word;
      std::printf("%s thing %zu: %s (%s)\n", sequence->frame(i).name.c_str(), object.thing,
                  word < 0 ? "?" : model.study().words[static_cast<std::size_t>(word)].name.c_str(),
                  object.belief.why.c_str());
    }
  }
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
