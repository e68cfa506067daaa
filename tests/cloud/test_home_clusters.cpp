// The things of a furnished home, rendered with their true masks: how many are found, and how much else.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>

#include "estancia/cloud/clusters.hpp"
#include "estancia/io/home_truth.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

enum class ThingClass { small, furniture, fixture };

/// Fixture: part of the building, fastened to it, or flat on it. Furniture: stands on the floor. Small: what
/// stands on other things.
ThingClass classOf(const std::string& category) {
  static const std::set<std::string> fixtures{
      "rug",       "painting",       "curtain",        "kitchen_cabinet", "wall_cabinet", "radiator",
      "mirror",    "worktop_splash", "sink",           "range_hood",      "stove",        "door",
      "washbasin", "towel_radiator", "shower_curtain", "bath_mat",        "coat_hooks",   "kitchen_tools",
      "towels",    "toilet_paper",   "bathtub",        "toilet",          "toilet_brush", "cuckoo_clock",
      "screen"};
  static const std::set<std::string> furniture{"sofa",          "coffee_table", "armchair",
                                               "bookcase",      "piano",        "piano_bench",
                                               "tv_stand",      "floor_lamp",   "plant",
                                               "refrigerator",  "chair",        "dining_table",
                                               "trash_can",     "shelves",      "clothes_rack",
                                               "coats",         "bed",          "washing_machine",
                                               "wardrobe",      "desk",         "chest_of_drawers",
                                               "bedside_table", "suitcase",     "laundry_basket",
                                               "office_chair",  "umbrella",     "filing_cabinet",
                                               "waste_basket",  "guitar",       "television",
                                               "speaker"};
  if (fixtures.count(category) > 0) return ThingClass::fixture;
  return furniture.count(category) > 0 ? ThingClass::furniture : ThingClass::small;
}

struct HomeScore {
  std::map<ThingClass, double> things, found;  ///< of 300 pixels or more
  double clusters = 0, right = 0;
  double recall(ThingClass which) { return found[which] / things[which]; }
  double precision() const { return right / clusters; }
};

/// Over pixels with depth; a cluster is right, and its thing found, where their intersection over union is
/// 0.5 or more.
void scoreFrame(const Clusters& clusters, const cv::Mat& depth, const cv::Mat& mask,
                const std::map<int, ThingClass>& classes, HomeScore& score) {
  constexpr double least = 300;
  const auto* id = mask.ptr<std::uint16_t>();
  std::map<int, double> sizes, best;
  for (std::size_t p = 0; p < mask.total(); ++p)
    if (depth.ptr<float>()[p] > 0 && id[p] >= io::kFirstInstance) ++sizes[id[p]];
  for (const Cluster& cluster : clusters.clusters) {
    std::map<int, double> common;
    for (const std::uint32_t p : cluster.points)
      if (id[p] >= io::kFirstInstance) ++common[id[p]];
    double overlap = 0;
    for (const auto& [thing, both] : common) {
      const double iou = both / (sizes[thing] + static_cast<double>(cluster.points.size()) - both);
      best[thing] = std::max(best[thing], iou);
      overlap = std::max(overlap, iou);
    }
    ++score.clusters;
    score.right += overlap >= 0.5 ? 1 : 0;
  }
  for (const auto& [thing, size] : sizes) {
    if (size < least) continue;
    ++score.things[classes.at(thing)];
    score.found[classes.at(thing)] += best[thing] >= 0.5 ? 1 : 0;
  }
}

/// Every 16th frame of the day, with noise of so many meters at 1 m.
HomeScore scoreOf(const std::filesystem::path& drive, double noise) {
  std::map<int, ThingClass> classes;
  for (const io::HomeInstance& thing : io::readHomeInstances(drive / "instances.csv"))
    classes[thing.id] = classOf(thing.category);
  HomeScore score;
  cv::RNG random(5);
  for (int frame = 0; frame < 320; frame += 16) {
    const std::string name = fmt::format("{:06}.png", frame);
    cv::Mat depth;
    cv::imread(drive / "depth" / name, cv::IMREAD_UNCHANGED).convertTo(depth, CV_32F, 0.001);
    for (float& z : cv::Mat_<float>(depth))
      z += z > 0 ? static_cast<float>(random.gaussian(noise) * z * z) : 0;
    const Clusters clusters = findClusters(depth, {320, 240, 262.5, 262.5, 159.5, 119.5});
    scoreFrame(clusters, depth, io::readInstanceMask(drive / "instance" / name), classes, score);
  }
  return score;
}

TEST(HomeClusters, FindMostThingsAndFewOthers) {
  const auto data = test::findData("home_a");
  ESTANCIA_NEEDS(data, "needs home_a");
  for (const double noise : {0., 0.0012}) {
    HomeScore score = scoreOf(*data / "day", noise);
    RecordProperty(fmt::format("precision_{}", noise), fmt::format("{:.3f}", score.precision()));
    EXPECT_GE(score.recall(ThingClass::small), 0.7) << noise;
    EXPECT_GE(score.recall(ThingClass::furniture), 0.5) << noise;
    EXPECT_GE(score.recall(ThingClass::fixture), 0.25) << noise;
    EXPECT_GE(score.precision(), 0.42) << noise;
  }
}

}  // namespace
}  // namespace estancia
