#include "experiments/src/zones/thesis_zones.hpp"

namespace estancia::experiments {

const std::vector<std::string>& thesisCuts() {
  static const std::vector<std::string> cuts{"0.2", "0.35", "0.5", "0.65", "0.8"};
  return cuts;
}

const std::vector<ThesisZoneCounts>& thesisZoneCounts() {
  static const std::vector<ThesisZoneCounts> counts{
      {"(thesis, ViDRILO 1: ImageNet-AlexNet)", {110, 30, 13, 6, 2}},
      {"(thesis, ViDRILO 2: ImageNet-AlexNet)", {109, 32, 12, 4, 1}},
      {"(thesis, ViDRILO 1: ImageNet-GoogLeNet)", {134, 40, 19, 12, 3}},
      {"(thesis, ViDRILO 2: ImageNet-GoogLeNet)", {175, 43, 20, 10, 4}},
      {"(thesis, ViDRILO 1: Places-AlexNet)", {95, 23, 12, 4, 1}},
      {"(thesis, ViDRILO 2: Places-AlexNet)", {105, 26, 13, 5, 2}},
      {"(thesis, ViDRILO 1: Places-GoogLeNet)", {79, 22, 9, 4, 2}},
      {"(thesis, ViDRILO 2: Places-GoogLeNet)", {102, 26, 14, 4, 2}},
  };
  return counts;
}

ResultTable thesisWithin() {
  return {"The thesis: distances within categories, Eq. 5.1, τ_d 0.5 (Table 5.3)",
          "Another data set: the sequences 1 and 2 of ViDRILO, averaged. CR corridor, EA elevator area, PO "
          "professor "
          "office.",
          "classes",
          {{"ImageNet-AlexNet"}, {"ImageNet-GoogLeNet"}, {"Places-AlexNet"}, {"Places-GoogLeNet"}},
          {{"CR-1 · CR-2", {0.56, 0.32, 0.06, 0.11}},
           {"CR-1 · CR-3", {0.13, 0.16, 0.21, 0.13}},
           {"CR-1 · CR-4", {0.15, 0.37, 0.41, 0.40}},
           {"CR-1 · CR-5", {0.15, 0.17, 0.08, 0.11}},
           {"CR-1 · CR-6", {0.10, 0.17, 0.20, 0.14}},
           {"CR-2 · CR-3", {0.64, 0.22, 0.18, 0.07}},
           {"CR-2 · CR-4", {0.49, 0.30, 0.38, 0.37}},
           {"CR-2 · CR-5", {0.54, 0.38, 0.04, 0.09}},
           {"CR-2 · CR-6", {0.61, 0.35, 0.16, 0.10}},
           {"CR-3 · CR-4", {0.22, 0.33, 0.28, 0.42}},
           {"CR-3 · CR-5", {0.16, 0.19, 0.16, 0.05}},
           {"CR-3 · CR-6", {0.12, 0.15, 0.10, 0.12}},
           {"CR-4 · CR-5", {0.25, 0.39, 0.42, 0.44}},
           {"CR-4 · CR-6", {0.19, 0.33, 0.30, 0.33}},
           {"CR-5 · CR-6", {0.09, 0.15, 0.16, 0.13}},
           {"EA-1 · EA-2", {0.42, 0.77, 0.79, 0.44}},
           {"PO-1 · PO-2", {0.38, 0.43, 0.32, 0.45}},
           {"M", {0.31, 0.31, 0.25, 0.23}}}};
}

}  // namespace estancia::experiments
