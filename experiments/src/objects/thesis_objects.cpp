#include "experiments/src/objects/thesis_objects.hpp"

namespace estancia::experiments {

ResultTable thesisObjectsTable() {
  const ThesisObjects thesis;
  return {
      "The thesis, other data",
      "8 objects × 3 instances, 500 samples an object as printed; AlexNet's words, ESF, SVM (Table 6.2; "
      "6.4.3, 6.4.4, Tables 6.7 and 6.8). Its data was never published: compare the form, not the numbers.",
      "split",
      {{"labeler [%]", 1}, {"classifier [%]", 2}},
      {{"baseline", {thesis.labeler, thesis.baseline}},
       {"mean of 30", {std::nullopt, thesis.mean}},
       {"best (29)", {std::nullopt, thesis.best}},
       {"14", {std::nullopt, 78.2}},
       {"1", {std::nullopt, 77.6}},
       {"22", {std::nullopt, 76.9}},
       {"11", {std::nullopt, 76.3}},
       {"worst (26)", {std::nullopt, thesis.worst}}}};
}

}  // namespace estancia::experiments
