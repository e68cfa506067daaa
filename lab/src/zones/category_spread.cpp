// SPDX-License-Identifier: Apache-2.0
#include "zones/category_spread.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/zones/image_tree.hpp"

namespace estancia::experiments {
namespace {

/// The share of a class' images in each zone.
using Distribution = std::map<int, double>;

double l2(const Distribution& a, const Distribution& b) {
  Distribution difference = a;
  for (const auto& [zone, share] : b) difference[zone] -= share;
  double sum = 0;
  for (const auto& [zone, share] : difference) sum += share * share;
  return std::sqrt(sum);
}

Distribution distributionOf(const std::vector<int>& zones) {
  Distribution shares;
  for (const int zone : zones) shares[zone] += 1 / static_cast<double>(zones.size());
  return shares;
}

void requireOneEach(std::size_t zones, std::size_t classes) {
  if (zones != classes)
    throw Error(ErrorCode::mismatch,
                fmt::format("{} zone numbers do not belong to {} classes; give one of each an image", zones,
                            classes));
}

/// The mean descriptor of each class; `classOf` has one a frame, `count` and more where it is not known.
DescriptorSequence meansOf(const DescriptorSequence& sequence, const std::vector<std::size_t>& classOf,
                           std::size_t count) {
  std::vector<Moments> means(count, Moments(sequence.vocabulary.size(), false));
  for (std::size_t i = 0; i < classOf.size(); ++i)
    if (classOf[i] < count) means[classOf[i]].add(sequence.descriptors.row(i));
  DescriptorSequence result{sequence.vocabulary, sequence.model, std::vector<Frame>(count),
                            DescriptorMatrix(sequence.vocabulary.size())};
  for (const Moments& mean : means) result.descriptors.append(mean.mean());
  return result;
}

}  // namespace

CategorySpread measureCategories(std::span<const int> zoneOf, std::span<const ImageClass> classes) {
  requireOneEach(zoneOf.size(), classes.size());
  std::map<std::string, std::string> categoryOf;
  std::map<std::string, std::map<std::string, std::vector<int>>> zonesOf;  // by category and class
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const auto& [category, name] = classes[i];
    if (name.empty()) continue;
    const std::string& known = categoryOf.emplace(name, category).first->second;
    if (known != category)
      throw Error(ErrorCode::mismatch,
                  fmt::format("the class \"{}\" has the categories \"{}\" and \"{}\"; give it one", name,
                              known, category));
    zonesOf[category][name].push_back(zoneOf[i]);
  }
  CategorySpread spread;
  for (const auto& [category, members] : zonesOf) {
    std::vector<std::pair<std::string, Distribution>> distributions;
    for (const auto& [name, zones] : members) distributions.emplace_back(name, distributionOf(zones));
    for (std::size_t i = 0; i < distributions.size(); ++i)
      for (std::size_t j = i + 1; j < distributions.size(); ++j)
        spread.pairs.push_back({category, distributions[i].first, distributions[j].first,
                                l2(distributions[i].second, distributions[j].second) / std::numbers::sqrt2});
  }
  spread.m = meanDistance(spread.pairs);
  return spread;
}

std::optional<double> meanDistance(std::span<const ClassPair> pairs) {
  if (pairs.empty()) return std::nullopt;
  double sum = 0;
  for (const ClassPair& pair : pairs) sum += pair.distance;
  return sum / static_cast<double>(pairs.size());
}

ResultTable classHistograms(std::span<const int> zoneOf, std::span<const std::string> classes,
                            ResultTable head) {
  requireOneEach(zoneOf.size(), classes.size());
  std::map<int, std::size_t> sizes;
  for (const int zone : zoneOf) ++sizes[zone];
  std::vector<std::pair<int, std::size_t>> zones(sizes.begin(), sizes.end());
  std::ranges::stable_sort(zones, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::map<int, std::size_t> columnOf;
  for (const auto& [zone, size] : zones) columnOf.emplace(zone, std::min<std::size_t>(columnOf.size(), 20));
  std::map<std::string, std::vector<double>> counts;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i].empty()) continue;
    auto& row = counts[classes[i]];
    row.resize(std::min<std::size_t>(zones.size(), 21));
    ++row[columnOf[zoneOf[i]]];
  }
  for (std::size_t c = 0; c < std::min<std::size_t>(zones.size(), 21); ++c)
    head.columns.push_back({c < 20 ? std::to_string(c + 1) : "others", 0});
  for (const auto& [name, row] : counts) {
    const double images = std::accumulate(row.begin(), row.end(), 0.0);
    auto& values = head.rows.emplace_back(ResultTable::Row{name, {}}).values;
    for (const double count : row) values.emplace_back(100 * count / images);
  }
  head.hottest = 100;
  return head;
}

ClassDistances classDistances(const DescriptorSequence& sequence, std::span<const std::string> classes,
                              const ZoneOptions& options, Progress& progress) {
  if (classes.size() != sequence.frames.size())
    throw Error(ErrorCode::mismatch, fmt::format("{} classes do not belong to {} frames; give one a frame",
                                                 classes.size(), sequence.frames.size()));
  std::map<std::string, std::size_t> numbers;
  for (const std::string& name : classes)
    if (!name.empty()) numbers.emplace(name, 0);
  if (numbers.empty())
    throw Error(ErrorCode::insufficientData, "no frame has a class; give a class to some frames");
  ClassDistances result;
  for (auto& [name, number] : numbers) {
    number = result.classes.size();
    result.classes.push_back(name);
  }
  const std::size_t count = numbers.size();
  std::vector<std::size_t> classOf;
  for (const std::string& name : classes) classOf.push_back(name.empty() ? count : numbers[name]);
  const CondensedDistances distances = compareImages(sequence, options, progress);
  std::vector<double> sums(count * count), pairs(count * count);
  for (std::size_t i = 0; i < classes.size(); ++i)
    for (std::size_t j = i + 1; j < classes.size(); ++j) {
      const auto [a, b] = std::minmax(classOf[i], classOf[j]);
      if (b == count) continue;
      sums[a * count + b] += distances(i, j);
      ++pairs[a * count + b];
    }
  result.mean.resize(count * count);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a; b < count; ++b)
      result.mean[a * count + b] = result.mean[b * count + a] = sums[a * count + b] / pairs[a * count + b];
  if (getDistance(options.distance).standardized) return result;
  result.ofMeans.resize(count * count);
  if (count == 1) return result;
  const CondensedDistances ofMeans = compareImages(meansOf(sequence, classOf, count), options, progress);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a + 1; b < count; ++b)
      result.ofMeans[a * count + b] = result.ofMeans[b * count + a] = ofMeans(a, b);
  return result;
}

}  // namespace estancia::experiments
