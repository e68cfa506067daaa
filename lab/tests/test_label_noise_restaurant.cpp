// Real shapes: 20 restaurant objects, a simulated depth camera around each.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "estancia/objects/object_model.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/readers/object_views.hpp"
#include "objects/label_noise.hpp"
#include "objects/made_up.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

struct Views {
  Features shapes;
  std::vector<int> classes;  ///< each object is one instance of its own word
};

Views some(const Views& all, const std::vector<std::size_t>& rows) {
  Views views{withRows(all.shapes, rows), {}};
  for (const std::size_t i : rows) views.classes.push_back(all.classes[i]);
  return views;
}

/// A third of the neighboring views of each object is asked about; how many are right, by naming and noise.
TEST(Restaurant, TheVoteWithstandsNoiseThatTopDoesNot) {
  const auto data = test::findData("restaurant20_sim");
  ESTANCIA_NEEDS(data, "restaurant20_sim is not unpacked");
  const auto opened = openObjectViews(*data);
  Views all{describeShapes(*opened, {}), {}};
  std::vector<std::string> categories;
  for (const Frame& frame : all.shapes.frames) categories.push_back(frame.room);
  const TargetClasses targets = targetClassesOf(categories);
  ASSERT_EQ(targets.classes.size(), 20U);
  std::map<int, std::size_t> seen;
  std::vector<std::size_t> train, asked;
  for (std::size_t i = 0; i < categories.size(); ++i) {
    all.classes.push_back(targets.classOf(categories[i]));
    (seen[all.classes[i]]++ / 5 == 1 ? asked : train).push_back(i);
  }
  const Views known = some(all, train), unseen = some(all, asked);
  const auto accuracy = [&](PseudoLabeling naming, double rate, std::uint64_t seed) {
    ClassifierOptions options;
    options.c = 10;
    options.gamma = 1;
    const ClassProbabilities said =
        withNoise(test::saying(known.classes, 20), NoiseKind::view, rate, known.classes, seed);
    const ObjectTraining training{targets,
                                  {},
                                  known.shapes,
                                  assignPseudoLabels(naming, said, known.classes, known.shapes, options),
                                  known.classes,
                                  "",
                                  {}};
    return test::shareRight(trainObjectModel(training, options).predict(unseen.shapes), unseen.classes);
  };
  const double clean = accuracy(PseudoLabeling::top, 0, 1);
  EXPECT_GT(clean, 0.7);
  double topLoses = 0, votedLoses = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    topLoses += (clean - accuracy(PseudoLabeling::top, 0.2, seed)) / 3;
    votedLoses += (clean - accuracy(PseudoLabeling::voted, 0.2, seed)) / 3;
  }
  EXPECT_LE(votedLoses, 0.05);
  EXPECT_GT(topLoses, 0.05);
}

}  // namespace
}  // namespace estancia::experiments
