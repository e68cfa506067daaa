#include "estancia/topology/localizer.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/topology/places.hpp"

namespace estancia {
namespace {

PlaceFilter makeBelief(const LocalizerMap& source, const PlaceFilterOptions& options) {
  const TopologicalMap& map = *source.map;
  if (map.nodes.empty() || source.images.size() == 0) throw Error("the map is empty: there is nowhere to be");
  std::vector<std::size_t> nodeOfImage;
  for (std::size_t i = 0; i < source.images.size(); ++i)
    nodeOfImage.push_back(indexOf(map, map.frames.at(i * source.stride).node));
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  for (const Transition& transition : map.transitions)
    edges.emplace_back(indexOf(map, transition.from), indexOf(map, transition.to));
  return PlaceFilter(std::move(nodeOfImage), map.nodes.size(), edges, options);
}

std::size_t largest(const std::vector<float>& values) {
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

}  // namespace

Localizer::Localizer(const LocalizerMap& map, LocalizerOptions options)
    : map_(*map.map),
      bank_(*map.bank),
      stride_(map.stride),
      options_(options),
      distance_(getDistance(map_.distance, map_.vocabulary.layout().parts)),
      belief_(makeBelief(map, options.belief)),
      state_(belief_.start()) {
  std::vector<float> embedded(map.images.labels());
  images_.reserve(map.images.values().size());
  for (std::size_t i = 0; i < map.images.size(); ++i) {
    embed(distance_.embedding, map.images.row(i), embedded, distance_.parts);
    const std::vector<float> row = bank_.makeQuery(embedded);
    images_.insert(images_.end(), row.begin(), row.end());
  }
}

std::vector<Localization> Localizer::add(DescriptorView probabilities) {
  const std::size_t labels = map_.vocabulary.size();
  requireProbabilities(probabilities, labels, "the labeler");
  std::vector<float> embedded(labels);
  embed(distance_.embedding, probabilities, embedded, distance_.parts);
  const std::vector<float> query = bank_.makeQuery(embedded);

  std::vector<float> distances(belief_.images());
  for (std::size_t i = 0; i < distances.size(); ++i)
    distances[i] =
        static_cast<float>(compare(distance_.comparison, {images_.data() + i * labels, labels}, query));
  const auto nearest =
      static_cast<std::size_t>(std::min_element(distances.begin(), distances.end()) - distances.begin());

  Waiting frame;
  frame.answer.node = bank_[bank_.nearest(query, bank_.size())->slot].id;
  frame.answer.nearestImage = nearest * stride_;
  frame.answer.distance = distances[nearest];
  frame.likelihood = belief_.likelihood(distances);
  std::vector<float> predicted(state_.size());
  belief_.predict(state_, predicted);
  state_ = std::move(predicted);
  belief_.observe(frame.likelihood, state_);
  if (options_.lookahead == 0) {
    setBelief(frame.answer, state_);
    return {frame.answer};
  }
  frame.filtered = state_;
  waiting_.push_back(std::move(frame));
  // Settling a block at a time costs two passes a frame instead of `lookahead`.
  return waiting_.size() < 2 * options_.lookahead ? std::vector<Localization>{} : settle(options_.lookahead);
}

std::vector<Localization> Localizer::finish() {
  return settle(waiting_.size());
}

/// Backward pass from the newest waiting frame; the first `count` frames are answered by filtered × backward.
std::vector<Localization> Localizer::settle(std::size_t count) {
  std::vector<Localization> answers(count);
  std::vector<float> ahead(state_.size(), 1.0F), before(state_.size());
  for (std::size_t t = waiting_.size(); t-- > 0;) {
    Waiting& frame = waiting_[t];
    if (t < count) {
      std::vector<float> both(state_.size());
      for (std::size_t s = 0; s < both.size(); ++s) both[s] = frame.filtered[s] * ahead[s];
      setBelief(frame.answer, both);
      answers[t] = frame.answer;
    }
    belief_.observe(frame.likelihood, ahead);
    belief_.backward(ahead, before);
    std::swap(ahead, before);
    const float scale = 1 / *std::max_element(ahead.begin(), ahead.end());
    for (float& value : ahead) value *= scale;
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return answers;
}

void Localizer::setBelief(Localization& answer, const std::vector<float>& state) const {
  std::vector<float> images = belief_.marginal(state);
  const std::vector<float> nodes = belief_.nodeMarginal(images);
  double total = 0;
  for (const float p : nodes) total += p;
  const std::size_t node = largest(nodes);
  answer.beliefNode = map_.nodes[node].id;
  answer.confidence = nodes[node] / total;
  for (std::size_t i = 0; i < images.size(); ++i)
    if (map_.frames[i * stride_].node != answer.beliefNode) images[i] = 0;
  answer.beliefImage = largest(images) * stride_;
}

}  // namespace estancia
