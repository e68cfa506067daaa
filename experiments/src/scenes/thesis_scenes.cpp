#include "experiments/src/scenes/thesis_scenes.hpp"

#include <optional>

namespace estancia::experiments {

ResultTable thesisScenes() {
  constexpr auto none = std::nullopt;
  return {
      "Table 3.2 of the thesis: another data set",
      "ViDRILO, 25 pairs of sequences; Friedman's test with Holm's correction against the best combination. "
      "Win, tie, loss: pairs in which the best one did better, as well, worse. To be compared in its course "
      "only.",
      "classifier, descriptor",
      {{"p-value", 4, ResultTable::Best::none, ResultTable::Form::scientific},
       {"rejected", 0, ResultTable::Best::none, ResultTable::Form::yesNo},
       {"rank", 2},
       {"win", 0},
       {"tie", 0},
       {"loss", 0}},
      {{"RFs, ESF", {none, 0, 2.70, none, none, none}},
       {"SVM, GIST", {2.2433e-01, 0, 4.22, 19, 0, 6}},
       {"RFs, Clarifai", {2.2433e-01, 0, 4.32, 14, 0, 11}},
       {"SVM, ESF", {1.5541e-03, 1, 6.24, 23, 0, 2}},
       {"RFs, PHOG", {7.6841e-04, 1, 6.54, 20, 5, 0}},
       {"RFs, GIST", {7.6841e-04, 1, 6.56, 20, 4, 1}},
       {"kNN, GIST", {6.7068e-04, 1, 6.64, 19, 0, 6}},
       {"SVM, Clarifai", {4.5236e-05, 1, 7.30, 21, 0, 4}},
       {"SVM, PHOG", {2.4383e-05, 1, 7.46, 22, 0, 3}},
       {"kNN, Clarifai", {9.3896e-06, 1, 7.68, 20, 0, 5}},
       {"kNN, ESF", {2.7732e-06, 1, 7.94, 25, 0, 0}},
       {"kNN, PHOG", {4.7705e-13, 1, 10.40, 25, 0, 0}}}};
}

}  // namespace estancia::experiments
