#include "estancia/recognition/recognition_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/grouping.hpp"
#include "estancia/recognition/keypoints.hpp"

namespace estancia {
namespace {

using Names = std::vector<std::pair<std::string, std::string>>;  // and explanations

void requireKnown(const std::string& what, const std::string& name, const Names& known) {
  std::string names;
  for (const auto& [one, explanation] : known) {
    if (one == name) return;
    names += (names.empty() ? "" : ", ") + one;
  }
  throw Error(fmt::format("no {} is called '{}'; known are {}", what, name, names));
}

}  // namespace

void RecognitionOptions::check() const {
  requireKnown("keypoint detector", keypoints, keypointMethods());
  requireKnown("descriptor of a surface", descriptor, descriptorMethods());
  Names groupings = groupingMethods();
  groupings.emplace_back("local-frames", "each match is a pose by its two local frames");
  requireKnown("grouping", grouping, groupings);
  requireKnown("surface", surface, {{"filtered", ""}, {"mean", ""}});
  requireKnown("verification", verification, {{"global", ""}, {"inliers", ""}, {"evidence", ""}});
  requireKnown("side of matching", matchEach, {{"scene", ""}, {"model", ""}});
  for (const double length :
       {normalRadius, keypointSpacing, sceneKeypointSpacing, descriptorRadius, consistency, tolerance})
    if (!(length >= 0) || !std::isfinite(length))
      throw Error(fmt::format(
          "a length of recognition is {} m; give a positive one, or 0 to follow the scene", length));
  if (normalRadius > 0 && normalNeighbors > 0)
    throw Error("normals need the radius or the number of the points around; give one of the two");
  if (!(matchDistance >= 0) || !std::isfinite(matchDistance))
    throw Error(fmt::format("descriptors cannot match within {}; give a positive distance, or 0 for any",
                            matchDistance));
  if (neighbors == 0 || hypotheses == 0)
    throw Error("recognition without any match or hypothesis finds nothing; allow at least one");
  if (!(accept >= 0 && accept <= 1))
    throw Error(fmt::format("no share of a model is {}; give one in [0, 1]", accept));
}

std::vector<std::pair<std::string, std::string>> RecognitionOptions::presets() {
  return {{"default", "for any noise"},
          {"classical", "the thesis' stages, lengths that follow the scene"},
          {"thesis", "the thesis' stages, fixed lengths"},
          {"tight", "fixed lengths, for scenes without noise"},
          {"wide", "fixed lengths, for noise"}};
}

RecognitionOptions RecognitionOptions::preset(const std::string& name) {
  requireKnown("set of recognition options", name, presets());
  RecognitionOptions options;
  if (name == "default") {
    options.surface = "mean";
    options.grouping = "local-frames";
    options.verification = "evidence";
    options.matchEach = "model";
    options.neighbors = 30;
    options.hypotheses = 300;
    options.accept = 0.23;
    options.sceneFilter.gng.signalsPerInsertion = 25;  // neurons are but seeds of the surface
  } else if (name == "classical") {
    options.verification = "inliers";
    options.matchEach = "model";
    options.neighbors = 3;
  } else if (name == "thesis") {
    // The thesis tells no number. It follows the tutorials of PCL: normals of a few nearest points, model and
    // scene keypoints 10 and 30 mm apart, matches within a squared distance of 0.25, five that agree. The
    // rest was chosen on 8 of the scenes so that SHOT with uniform keypoints comes near to its Table 2.2.
    options.normalNeighbors = 15;
    options.keypointSpacing = 0.010;
    options.sceneKeypointSpacing = 0.030;
    options.descriptorRadius = 0.050;
    options.matchDistance = 0.5;
    options.consistency = 0.015;
    options.tolerance = 0.010;
    options.minimalMatches = 5;
  } else if (name == "tight") {
    // Radii of a Kinect cloud without noise, whose points lie 2 mm apart.
    options.normalRadius = 0.015;
    options.keypointSpacing = 0.010;
    options.descriptorRadius = 0.035;
    options.consistency = 0.010;
    options.tolerance = 0.006;
    options.minimalMatches = 4;
    options.accept = 0.65;
    options.verification = "inliers";
  } else if (name == "wide") {
    options.normalRadius = 0.035;
    options.keypointSpacing = 0.010;
    options.descriptorRadius = 0.060;
    options.consistency = 0.020;
    options.tolerance = 0.008;
    options.accept = 0.76;
    options.matchEach = "model";
    options.neighbors = 3;
    options.verification = "inliers";
  }
  return options;
}

}  // namespace estancia
