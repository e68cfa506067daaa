#include "estancia/label/labeler.hpp"

namespace estancia {

std::vector<LabelResult> Labeler::inferBatch(std::span<const Prepared> batch) {
  std::vector<LabelResult> results;
  for (const Prepared& prepared : batch) try {
      results.push_back({infer(prepared), ""});
    } catch (const FrameError& e) {
      results.push_back({{}, e.what()});
    }
  return results;
}

}  // namespace estancia
