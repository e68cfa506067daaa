#include "estancia/experiment/thesis_scenes.hpp"

#include <optional>

namespace estancia {

ResultTable thesisScenes() {
  constexpr auto none = std::nullopt;
  return {
      "Table 3.2 of the thesis: another data set",
      "ViDRILO, 25 pairs of sequences; Friedman's test with Holm's correction against the best "
      "combination. Win, tie, loss: pairs in which the best one did better, as well, worse. To be compared "
      "in its course only.",
      "classifier, descriptor",
      {{"rank", 2}, {"p (Holm)", 6}, {"win", 0}, {"tie", 0}, {"loss", 0}},
      {{"RFs, ESF", {2.70, none, none, none, none}},
       {"SVM, GIST", {4.22, 2.2433e-01, 19, 0, 6}},
       {"RFs, Clarifai", {4.32, 2.2433e-01, 14, 0, 11}},
       {"SVM, ESF", {6.24, 1.5541e-03, 23, 0, 2}},
       {"RFs, PHOG", {6.54, 7.6841e-04, 20, 5, 0}},
       {"RFs, GIST", {6.56, 7.6841e-04, 20, 4, 1}},
       {"kNN, GIST", {6.64, 6.7068e-04, 19, 0, 6}},
       {"SVM, Clarifai", {7.30, 4.5236e-05, 21, 0, 4}},
       {"SVM, PHOG", {7.46, 2.4383e-05, 22, 0, 3}},
       {"kNN, Clarifai", {7.68, 9.3896e-06, 20, 0, 5}},
       {"kNN, ESF", {7.94, 2.7732e-06, 25, 0, 0}},
       {"kNN, PHOG", {10.40, 4.7705e-13, 25, 0, 0}}}};
}

}  // namespace estancia
