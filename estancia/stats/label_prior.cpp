// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_prior.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "estancia/core/ascii.hpp"
#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr std::size_t quantiles = 101;

/// "/c/coffee_shop, cafe" → "coffee shop": what lists of the same classes have in common.
std::string keyOf(const std::string& label) {
  std::string key = label.substr(0, label.find(','));
  if (key.size() > 3 && key[0] == '/' && key[2] == '/') key.erase(0, 3);
  for (char& c : key) c = c == '_' ? ' ' : lowerCase(c);
  return key;
}

const std::vector<NamedLabelPrior>& knownPriors() {
  static const std::vector<NamedLabelPrior> known{parseLabelPrior(imagenetPrior, "imagenet.prior"),
                                                  parseLabelPrior(cocoPrior, "coco.prior"),
                                                  parseLabelPrior(places365Prior, "places365.prior")};
  return known;
}

/// `known` for the labels [first, first + count) of a vocabulary; nothing where too few are the same. Single
/// unknown labels get the mean 0 and the variance of the others.
std::optional<LabelPrior> inOrderOf(const Vocabulary& vocabulary, std::size_t first, std::size_t count,
                                    const NamedLabelPrior& known) {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < known.labels.size(); ++i) places.try_emplace(keyOf(known.labels[i]), i);
  double mean = 0;
  for (const float v : known.prior.variance) mean += v / static_cast<double>(known.labels.size());
  LabelPrior prior = known.prior;
  prior.center.assign(count, 0.0F);
  prior.variance.assign(count, static_cast<float>(mean));
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto place = places.find(keyOf(vocabulary[first + i]));
    if (place == places.end()) continue;
    prior.center[i] = known.prior.center[place->second];
    prior.variance[i] = known.prior.variance[place->second];
    ++found;
  }
  // Lists differ in their backgrounds and spellings.
  if (static_cast<double>(found) < 0.9 * static_cast<double>(count)) return std::nullopt;
  return prior;
}

/// One after the other: the distance is the parts' weighted mean. So deviations from 1 (unrelated places) and
/// the products of two images, whose mean square is 1/dimensions, add up as errors do that are correlated.
LabelPrior joined(const std::vector<LabelPrior>& priors, const std::vector<LabelPart>& parts) {
  LabelPrior result;
  double total = 0;
  for (const LabelPart& part : parts) total += part.weight;
  const auto sumOf = [&](const auto& deviationOf) {
    double squares = 0, sum = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const double deviation = parts[p].weight / total * deviationOf(priors[p]);
      squares += deviation * deviation;
      sum += deviation;
    }
    // The products of two networks have correlations of .34 to .40 on NYU Depth V2, .6 on one vocabulary.
    return std::copysign(std::sqrt(std::lerp(squares, sum * sum, 0.4)), sum);
  };
  for (std::size_t q = 0; q < quantiles; ++q)
    result.distances.push_back(1 + sumOf([q](const LabelPrior& prior) { return prior.distances[q] - 1; }));
  result.dimensions =
      std::pow(sumOf([](const LabelPrior& prior) { return 1 / std::sqrt(prior.dimensions); }), -2);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    result.center.insert(result.center.end(), priors[p].center.begin(), priors[p].center.end());
    result.variance.insert(result.variance.end(), priors[p].variance.begin(), priors[p].variance.end());
  }
  return result;
}

}  // namespace

double LabelPrior::distanceAt(double share) const {
  const double at = share * static_cast<double>(distances.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), distances.size() - 2);
  return std::lerp(distances[below], distances[below + 1], at - static_cast<double>(below));
}

std::string LabelPrior::toBytes() const {
  ByteWriter out;
  out.numbers(center);
  out.numbers(variance);
  out.numbers(distances);
  out.number(dimensions);
  return out.bytes();
}

LabelPrior LabelPrior::fromBytes(const std::string& bytes, std::size_t labels) {
  ByteReader in(bytes, "the saved label prior is damaged", "map the sequence again");
  LabelPrior prior{in.numbers<float>(), in.numbers<float>(), in.numbers<double>(), in.number<double>()};
  const bool fits = prior.center.empty() || prior.center.size() == labels;
  if (!fits || prior.variance.size() != prior.center.size() || prior.distances.size() != quantiles ||
      !(prior.dimensions >= 1) || in.remaining() > 0)
    in.fail("its numbers do not fit", ErrorCode::corruptFile);
  return prior;
}

LabelPrior unknownLabelsPrior(std::size_t labels) {
  const std::vector<NamedLabelPrior>& known = knownPriors();
  const auto count = static_cast<double>(known.size());
  LabelPrior prior{{}, {}, std::vector<double>(quantiles, 0.0)};
  for (const NamedLabelPrior& one : known) {
    for (std::size_t q = 0; q < quantiles; ++q) prior.distances[q] += one.prior.distances[q] / count;
    prior.dimensions += one.prior.dimensions / count;
  }
  // The products of unrelated unit vectors have a variance of 1/dimensions.
  const double dimensions = std::clamp(static_cast<double>(labels) / 3, 1.0, prior.dimensions);
  for (double& d : prior.distances) d = std::max(0.0, 1 + (d - 1) * std::sqrt(prior.dimensions / dimensions));
  prior.dimensions = dimensions;
  return prior;
}

LabelPrior labelPriorOf(const Vocabulary& vocabulary) {
  const std::vector<LabelPart>& parts = vocabulary.layout().parts;
  std::vector<LabelPrior> priors;
  std::size_t first = 0;
  for (const LabelPart& part : parts) {
    std::optional<LabelPrior> prior;
    for (const NamedLabelPrior& known : knownPriors())
      if (!prior) prior = inOrderOf(vocabulary, first, part.size, known);
    if (!prior) return unknownLabelsPrior(vocabulary.size());
    priors.push_back(std::move(*prior));
    first += part.size;
  }
  return priors.size() == 1 ? priors.front() : joined(priors, parts);
}

NamedLabelPrior parseLabelPrior(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  std::string line;
  std::size_t number = 0;
  const auto refuse = [&](const std::string& what) {
    fail(ErrorCode::malformedFile, "{}:{}: {}; make it again by models/priors/make_prior.py", name, number,
         what);
  };
  const auto next = [&](const std::string& key) {
    do {
      ++number;
      if (!std::getline(in, line)) refuse(fmt::format("no line \"{}\"", key));
    } while (line.starts_with('#'));
    if (!line.starts_with(key + " ")) refuse(fmt::format("\"{}\" expected", key));
    std::istringstream rest(line.substr(key.size() + 1));
    rest.imbue(std::locale::classic());
    return rest;
  };
  int version = 0;
  next("estancia-label-prior") >> version;
  if (version != 1)
    fail(ErrorCode::unsupportedFile, "{}: label prior of version {}, but this Estancia reads version 1", name,
         version);
  NamedLabelPrior result;
  next("images");
  std::istringstream distances = next("distances");
  for (double value = 0; distances >> value;) result.prior.distances.push_back(value);
  if (result.prior.distances.size() != quantiles || !std::ranges::is_sorted(result.prior.distances))
    refuse("101 increasing quantiles expected");
  if (!(next("dimensions") >> result.prior.dimensions) || result.prior.dimensions < 1)
    refuse("a number of at least 1 expected");
  while (std::getline(in, line)) {
    ++number;
    std::istringstream fields(line);
    fields.imbue(std::locale::classic());
    float center = 0, deviation = 0;
    if (!(fields >> center >> deviation) || deviation < 0 || fields.get() != '\t')
      refuse("mean, deviation and label expected");
    std::string label;
    std::getline(fields, label);
    if (label.empty()) refuse("the label is missing");
    result.labels.push_back(label);
    result.prior.center.push_back(center);
    result.prior.variance.push_back(deviation * deviation);
  }
  if (result.labels.empty()) refuse("no labels");
  return result;
}

}  // namespace estancia
