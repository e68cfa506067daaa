// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/zero_shot_rooms.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/words/room_words.hpp"

namespace estancia {
namespace {

// Chosen on the training half of NYU Depth V2, five rooms (docs/measured/words.md).
constexpr double meanShare = 0.5;
/// Minimum support of a room by a model's labels, as a share of the best room's. Below it hardly any label is
/// related to the room, and the little evidence must not count in full.
constexpr double minSupport = 0.1;
/// Standard deviations of evidence to log odds: the maximum of the training half's likelihood.
constexpr double temperature = 0.7;
/// Evidence that deviates less is no evidence and is not blown up: half of the least deviation of a real run
/// (NYU's training half, the home's drives: 0.10 to 0.22); equal labels have 0.01.
constexpr double minDeviation = 0.05;
/// Lower bound of one room's deviation, as a share of the deviation over all rooms.
constexpr double minRoomDeviation = 0.3;
/// Fewer images do not show what is usual for a room.
constexpr std::size_t minStandardized = 20;
constexpr int priorSteps = 20;
/// How many labels of an image are kept as evidence: with more of them the same places are sure.
constexpr std::size_t labelsKept = 8;

/// Images × rooms, row-major.
struct Evidence {
  std::size_t rooms = 0;
  std::vector<double> values;

  double& at(std::size_t image, std::size_t room) { return values[image * rooms + room]; }
  std::size_t images() const { return values.size() / rooms; }

  /// Divides all by their common deviation, or by `least` where that is less. Returns the factor.
  double scale(double least) {
    const double n = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    const double factor = 1 / std::max(least, std::sqrt(squares / n));
    for (double& value : values) value *= factor;
    return factor;
  }
};

/// How labels become evidence: each adds its weight times the square root of its probability, less `usual`.
struct LabelShares {
  /// L numbers.
  std::vector<double> usual;
  /// R × L.
  std::vector<std::vector<double>> weights;
};

/// Adds the labels [from, from + size).
void addPart(const DescriptorMatrix& images, const std::vector<std::vector<float>>& weights, std::size_t from,
             std::size_t size, Evidence& sum, LabelShares& shares) {
  std::vector<double> usual(size, 0);
  for (std::size_t i = 0; i < images.size(); ++i)
    for (std::size_t l = 0; l < size; ++l)
      usual[l] +=
          std::sqrt(static_cast<double>(images.row(i)[from + l])) / static_cast<double>(images.size());
  std::vector<double> norms;
  for (const std::vector<float>& row : weights) {
    double squares = 0;
    for (std::size_t l = from; l < from + size; ++l)
      squares += static_cast<double>(row[l]) * static_cast<double>(row[l]);
    norms.push_back(std::sqrt(squares));
  }
  const double minNorm = minSupport * *std::max_element(norms.begin(), norms.end());
  Evidence part{sum.rooms, std::vector<double>(sum.values.size(), 0)};
  for (std::size_t r = 0; r < weights.size(); ++r)
    for (std::size_t l = 0; l < size; ++l) {
      const double weight = static_cast<double>(weights[r][from + l]) / std::max({norms[r], minNorm, 1e-9});
      if (weight <= 0) continue;
      for (std::size_t i = 0; i < images.size(); ++i)
        part.at(i, r) +=
            weight * (std::sqrt(static_cast<double>(images.row(i)[from + l])) - meanShare * usual[l]);
    }
  const double factor = part.scale(minDeviation);
  for (std::size_t l = 0; l < size; ++l) {
    shares.usual.push_back(meanShare * usual[l]);
    for (std::size_t r = 0; r < weights.size(); ++r)
      shares.weights[r].push_back(factor * static_cast<double>(weights[r][from + l]) /
                                  std::max({norms[r], minNorm, 1e-9}));
  }
  for (std::size_t k = 0; k < sum.values.size(); ++k) sum.values[k] += part.values[k];
}

/// The labels of an image with most evidence for some room, best first, in log odds.
void addTelling(DescriptorView image, std::size_t number, const LabelShares& shares, double factor,
                std::vector<RoomEvidence>& evidence) {
  std::vector<std::pair<double, std::size_t>> telling;
  for (std::size_t l = 0; l < image.size(); ++l) {
    double most = 0;
    const double seen = std::sqrt(static_cast<double>(image[l])) - shares.usual[l];
    for (const std::vector<double>& weights : shares.weights) most = std::max(most, seen * weights[l]);
    if (most > 0) telling.emplace_back(-most, l);
  }
  const std::size_t kept = std::min(labelsKept, telling.size());
  std::partial_sort(telling.begin(), telling.begin() + static_cast<std::ptrdiff_t>(kept), telling.end());
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t label = telling[k].second;
    const double seen = std::sqrt(static_cast<double>(image[label])) - shares.usual[label];
    RoomEvidence& told = evidence.emplace_back(RoomEvidence{number, label, {}});
    for (const std::vector<double>& weights : shares.weights)
      told.logOdds.push_back(static_cast<float>(factor * seen * weights[label]));
  }
}

/// Each room's evidence to mean 0 and deviation 1 over the run.
void standardize(Evidence& evidence) {
  const double n = static_cast<double>(evidence.images());
  for (std::size_t r = 0; r < evidence.rooms; ++r) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < evidence.images(); ++i) {
      sum += evidence.at(i, r);
      squares += evidence.at(i, r) * evidence.at(i, r);
    }
    const double mean = sum / n, deviation = std::sqrt(std::max(0.0, squares / n - mean * mean));
    for (std::size_t i = 0; i < evidence.images(); ++i)
      evidence.at(i, r) = (evidence.at(i, r) - mean) / std::max(deviation, minRoomDeviation);
  }
}

/// Turns log odds into probabilities, and returns how often each room occurs.
std::vector<double> adjustToRun(Evidence& evidence) {
  const std::size_t rooms = evidence.rooms, images = evidence.images();
  for (std::size_t i = 0; i < images; ++i) {
    double* row = &evidence.at(i, 0);
    const double most = *std::max_element(row, row + rooms);
    for (std::size_t r = 0; r < rooms; ++r) row[r] = std::exp((row[r] - most) / temperature);
  }
  std::vector<double> prior(rooms, 1 / static_cast<double>(rooms));
  for (int step = 0; step <= priorSteps; ++step) {
    std::vector<double> counts(rooms, 1);  // Laplace: no room is out of the question
    for (std::size_t i = 0; i < images; ++i) {
      double* row = &evidence.at(i, 0);
      double sum = 0;
      for (std::size_t r = 0; r < rooms; ++r) sum += row[r] * prior[r];
      for (std::size_t r = 0; r < rooms; ++r) {
        const double posterior = row[r] * prior[r] / sum;
        counts[r] += posterior;
        if (step == priorSteps) row[r] = posterior;
      }
    }
    if (step < priorSteps)
      for (std::size_t r = 0; r < rooms; ++r) prior[r] = counts[r] / static_cast<double>(images + rooms);
  }
  return prior;
}

/// From so many images a room on, a trained classifier needs no names.
constexpr double enoughImages = 40;
/// A probability below this is not believed: few examples make few distinctions.
constexpr double minRoomProbability = 1e-3;

}  // namespace

RoomsByNames::RoomsByNames(const WordGraph& graph, const Vocabulary& vocabulary,
                           const std::vector<std::string>& rooms)
    : areListed_(!rooms.empty()), rooms_(areListed_ ? rooms : commonRooms()), layout_(vocabulary.layout()) {
  if (rooms_.size() < 2)
    throw Error(ErrorCode::insufficientData, "one room alone needs no telling; name at least two");
  weights_ = roomLabelWeights(graph, vocabulary, rooms_);
}

RoomPredictions RoomsByNames::predict(const DescriptorMatrix& images) const {
  RoomPredictions predictions{"WordNet, no example", rooms_, DescriptorMatrix(rooms_.size())};
  predictions.areByName = true;
  predictions.areListed = areListed_;
  if (images.labels() != weights_.front().size())
    throw Error(ErrorCode::mismatch, "the images have other labels than the vocabulary");
  Evidence evidence{predictions.rooms.size(),
                    std::vector<double>(images.size() * predictions.rooms.size(), 0)};
  predictions.prior.assign(evidence.rooms, 1 / static_cast<double>(evidence.rooms));
  if (images.size() == 0) return predictions;
  LabelShares shares{{}, std::vector<std::vector<double>>(evidence.rooms)};
  std::size_t from = 0;
  for (const LabelPart& part : layout_.parts) {
    addPart(images, weights_, from, part.size, evidence, shares);
    from += part.size;
  }
  const double factor = evidence.scale(1) / temperature;
  for (std::size_t i = 0; i < images.size() && !areListed_; ++i)
    addTelling(images.row(i), i, shares, factor, predictions.evidence);
  if (areListed_ && images.size() >= minStandardized) standardize(evidence);
  predictions.prior = adjustToRun(evidence);
  std::vector<float> row(evidence.rooms);
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (std::size_t r = 0; r < row.size(); ++r) row[r] = static_cast<float>(evidence.at(i, r));
    predictions.probabilities.append(row);
  }
  return predictions;
}

RoomPredictions predictRoomsByNames(const WordGraph& graph, const Vocabulary& vocabulary,
                                    const DescriptorMatrix& images, const std::vector<std::string>& rooms) {
  return RoomsByNames(graph, vocabulary, rooms).predict(images);
}

double shareOfNames(double imagesPerRoom) {
  return std::clamp(1 - imagesPerRoom / enoughImages, 0.0, 1.0);
}

RoomPredictions withNames(RoomPredictions trained, const RoomPredictions& byNames, double share) {
  const std::size_t rooms = trained.rooms.size();
  if (byNames.rooms != trained.rooms || byNames.probabilities.size() != trained.probabilities.size())
    throw Error(ErrorCode::mismatch, "predictions of other images or rooms cannot be joined");
  DescriptorMatrix both(rooms);
  both.reserve(trained.probabilities.size());
  std::vector<float> row(rooms);
  for (std::size_t i = 0; i < trained.probabilities.size(); ++i) {
    const DescriptorView learned = trained.probabilities.row(i), named = byNames.probabilities.row(i);
    double sum = 0;
    std::vector<double> products(rooms, 0);
    if (std::accumulate(learned.begin(), learned.end(), 0.0F) > 0)
      for (std::size_t r = 0; r < rooms; ++r) {
        products[r] = std::max(minRoomProbability, static_cast<double>(learned[r])) *
                      std::pow(std::max(minRoomProbability, static_cast<double>(named[r])), share);
        sum += products[r];
      }
    for (std::size_t r = 0; r < rooms; ++r) row[r] = sum > 0 ? static_cast<float>(products[r] / sum) : 0;
    both.append(row);
  }
  trained.probabilities = std::move(both);
  trained.classifier += ", with rooms' names";
  return trained;
}

}  // namespace estancia
