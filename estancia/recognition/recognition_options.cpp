// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/recognition_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/grouping.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {
namespace {

/// "1,2,3", or "" when it is not set; "none" for no view.
Option::Text viewpointOf(RecognitionOptions& o) {
  return {[&o] {
            const auto& at = o.viewpoint;
            return o.noView ? "none" : at ? fmt::format("{},{},{}", at->x, at->y, at->z) : "";
          },
          [&o](const std::string& given) {
            o.noView = given == "none";
            const std::string text = o.noView ? "" : given;
            std::vector<double> numbers;
            for (std::string_view rest = text; !rest.empty() && numbers.size() < 4;) {
              const std::size_t comma = std::min(rest.find(','), rest.size());
              if (const auto number = io::toNumber(rest.substr(0, comma))) numbers.push_back(*number);
              rest.remove_prefix(std::min(comma + 1, rest.size()));
            }
            if (!text.empty() && (numbers.size() != 3 || std::ranges::count(text, ',') != 2))
              fail(ErrorCode::invalidOption, "viewpoint is \"{}\"; give three numbers: X,Y,Z, or none", text);
            o.viewpoint =
                text.empty() ? std::nullopt : std::optional(cv::Point3d(numbers[0], numbers[1], numbers[2]));
          }};
}

Choices groupings() {
  Choices choices = groupingMethods();
  choices.push_back({"local-frames", "each match is a pose by its two local frames"});
  return choices;
}

void declareStages(RecognitionOptions& o, OptionGroup& group) {
  group.add("surface", &o.surface, "Surface that is described")
      .choices({{"filtered", "the points that the filter leaves, with plane normals"},
                {"mean",
                 "moving least squares over the raw points around them, as wide as the noise requires, with "
                 "the scene's noise added to models"}});
  group.add("keypoints", &o.keypoints, "Keypoint detector").choices(keypointMethods());
  group.add("descriptor", &o.descriptor, "Descriptor of a keypoint").choices(descriptorMethods());
  group.add("grouping", &o.grouping, "How matches become poses").choices(groupings());
  group.add("verification", &o.verification, "Which poses are accepted")
      .choices({{"global", "the set of poses that explains the scene best"},
                {"inliers", "poses with enough inliers"},
                {"evidence", "poses with enough evidence"}});
  group
      .add("accept", &o.accept,
           "Smallest supported share of the visible model, where poses are verified by inliers")
      .range(0, 1)
      .why("Raise it against false detections, lower it for objects that are hidden in part.");
  group
      .add("false-alarm-rate", &o.falseAlarmRate,
           "Largest probability that a model that is not in the scene is found, where poses are verified by "
           "evidence")
      .above(0, 1)
      .why("Lower it when many models are searched, raise it for objects that are hidden in part.");
}

}  // namespace

OptionGroup declare(RecognitionOptions& o) {
  OptionGroup group("recognition", "Recognition of known objects in a point cloud.");
  for (auto [name, filter] :
       {std::pair("model-filter", &o.modelFilter), std::pair("scene-filter", &o.sceneFilter)}) {
    OptionGroup inner = declare(*filter).named(name);
    std::erase_if(inner.options(), [](const Option& option) { return option.name() == "leaf"; });
    inner.groups().clear();  // the details of neural gases
    group.add(std::move(inner));
  }
  declareStages(o, group);
  const auto length = [&group](const char* name, double& member, const char* help) {
    group.add(name, &member, help).range(0).unit("m").automatic("follows the scene");
  };
  length("normal-radius", o.normalRadius, "Radius of the points that a normal is fitted to");
  group.add("normal-neighbors", &o.normalNeighbors,
            "Nearest points that a normal of a filtered surface is fitted to; 0: by radius");
  length("keypoint-spacing", o.keypointSpacing, "Distance of uniform keypoints, or support of a detector");
  length("descriptor-radius", o.descriptorRadius, "Support radius of a descriptor");
  length("consistency", o.consistency, "Tolerance within which matches agree, and bin size of Hough voting");
  length("tolerance", o.tolerance, "Distance between a model point and the scene point that supports it");
  group
      .add("color-tolerance", &o.colorTolerance,
           "Largest color difference between a model point and the scene point that supports it, in CIELAB "
           "with "
           "half the lightness, by which poses are also refined; 0: colors do not count. Only with "
           "local-frames "
           "and evidence, and if both clouds have colors")
      .range(0, 300)
      .why("Tells objects of one shape apart. Raise it where the light differs.");
  group
      .add("viewpoint", viewpointOf(o),
           "Position of the scene's sensor: X,Y,Z; none: several views in one cloud")
      .unit("m")
      .automatic("that of the cloud, else the origin");
  group.add("threads", &o.threads, "Threads; 0: one a usable core. Results do not depend on it").range(0);
  return group;
}

void validate(const RecognitionOptions& options) {
  RecognitionOptions copy = options;
  declare(copy).validate();
  validate(options.modelFilter);
  validate(options.sceneFilter);
  if (options.matchEach != "scene" && options.matchEach != "model")
    fail(ErrorCode::unknownName, "the matches of a recognition are for each scene or model, not \"{}\"",
         options.matchEach);
  if (!(options.matchDistance >= 0) || !(options.sceneKeypointSpacing >= 0) || options.neighbors == 0 ||
      options.maxHypotheses == 0)
    fail(ErrorCode::invalidOption,
         "match-distance is {}, scene-keypoint-spacing {}, neighbors {} and max-hypotheses {} in a "
         "recognition; give no negative lengths, and numbers above 0",
         options.matchDistance, options.sceneKeypointSpacing, options.neighbors, options.maxHypotheses);
  if (options.normalRadius > 0 && options.normalNeighbors > 0)
    fail(ErrorCode::invalidOption,
         "recognition.normal-radius is {} m and recognition.normal-neighbors is {}; give one",
         options.normalRadius, options.normalNeighbors);
}

Choices RecognitionOptions::presets() {
  return {{"default", "for any noise"},
          {"classical", "the thesis' stages, lengths that follow the scene"},
          {"thesis", "the thesis' stages, fixed lengths"},
          {"author-2014", "the thesis' stages, lengths of its author's first program"},
          {"tight", "fixed lengths, for scenes without noise"},
          {"wide", "fixed lengths, for noise"}};
}

RecognitionOptions RecognitionOptions::preset(const std::string& name) {
  requireChoice("recognition preset", name, presets());
  RecognitionOptions options;
  if (name == "default") return options;
  options.sceneFilter = {};
  options.surface = "filtered";
  options.grouping = "geometric-consistency";
  options.verification = name == "thesis" || name == "author-2014" ? "global" : "inliers";
  options.matchEach = name == "classical" || name == "wide" ? "model" : "scene";
  options.neighbors = name == "classical" || name == "wide" ? 3 : 1;
  options.maxHypotheses = 100;
  if (name == "thesis") {
    // The thesis prints no lengths; those of its author's first program are the preset author-2014.
    // These follow the tutorials of PCL: normals of a few nearest points, model and scene
    // keypoints 10 and 30 mm apart, matches within a squared distance of 0.25, five that agree. The rest was
    // chosen on 8 of the scenes so that SHOT with uniform keypoints comes near to its Table 2.2.
    options.normalNeighbors = 15;
    options.keypointSpacing = 0.010;
    options.sceneKeypointSpacing = 0.030;
    options.descriptorRadius = 0.050;
    options.matchDistance = 0.5;
    options.consistency = 0.015;
    options.tolerance = 0.010;
    options.minMatches = 5;
  } else if (name == "author-2014") {
    // Recognition.cpp of November 2014 in the thesis author's public sources, which accepts every pose that
    // is grouped; the thesis, and this, verify them.
    options.normalNeighbors = 10;
    options.keypointSpacing = 0.008;
    options.sceneKeypointSpacing = 0.010;
    options.descriptorRadius = 0.010;
    options.matchDistance = 0.5;
    options.consistency = 0.020;
    options.tolerance = 0.005;
  } else if (name == "tight") {  // for a Kinect cloud without noise, whose points lie 2 mm apart
    options.normalRadius = 0.015;
    options.keypointSpacing = 0.010;
    options.descriptorRadius = 0.035;
    options.consistency = 0.010;
    options.tolerance = 0.006;
    options.minMatches = 4;
    options.accept = 0.65;
  } else if (name == "wide") {
    options.normalRadius = 0.035;
    options.keypointSpacing = 0.010;
    options.descriptorRadius = 0.060;
    options.consistency = 0.020;
    options.tolerance = 0.008;
    options.accept = 0.76;
  }
  return options;
}

}  // namespace estancia
