// Scene findings: tables and figures of the comparison of scene classifiers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "scenes/scene_answers.hpp"

namespace estancia::experiments {

struct ScenesResults {
  struct Pair {
    std::string train, test;
    /// Images of the test.
    SceneTest images;
    /// Names of the images, and of the run of each number.
    std::vector<std::string> names, runs;
    /// Images.
    std::size_t learned = 0;
    /// The very images it was trained with.
    bool same = false;
  };
  struct Descriptor {
    std::string name;
    /// Labels alone, of one model or several.
    bool isLexical = false;
    /// More than one: a conjunction.
    std::size_t parts = 1;
  };
  /// A rule of selecting labels.
  struct Curve {
    std::string rule;
    /// [count][pair].
    std::vector<std::vector<SceneAnswers>> answers;
  };
  /// Name of the study.
  std::string name;
  std::vector<std::string> rooms;
  std::vector<Pair> pairs;
  std::vector<Descriptor> descriptors;
  std::vector<std::string> classifiers;
  /// cells[(pair · descriptors + d) · classifiers + c]
  std::vector<SceneAnswers> cells;

  std::string curveDescriptor, curveClassifier;
  /// Numbers of labels, rising.
  std::vector<std::size_t> counts;
  /// All that the curve's descriptor has, whether asked about or not.
  std::size_t labels = 0;
  std::vector<Curve> curves;
  /// The thesis' Table 3.2 beside.
  bool thesisTables = false;
  /// A sequence whose pairs are also shown alone; "": none.
  std::string focus;

  /// Only the pairs of `focus` with others.
  ScenesResults withFocus() const;

  /// Whether the pair measures a classifier's value elsewhere: the test was not learned. If there are no such
  /// pairs, all of them are used.
  bool tells(const Pair& pair) const;

  const SceneAnswers& cell(std::size_t pair, std::size_t descriptor, std::size_t classifier) const {
    return cells[(pair * descriptors.size() + descriptor) * classifiers.size() + classifier];
  }
};

Findings findingsOf(const ScenesResults& results);

/// CSV `descriptor,classifier,train,test,room,answer,images`: all confusions.
std::string confusionsCsv(const ScenesResults& results);

/// CSV `train,test,image,room,wrong,cells,taken_for`: how many cells were wrong about each image, and for
/// what most of them took it; the most difficult one first.
std::string imagesCsv(const ScenesResults& results);

}  // namespace estancia::experiments
