// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/embedding.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/distances/distance.hpp"

namespace estancia {
namespace {

// tolerance of probabilities and their sums, in float32 or a file's few digits
constexpr float rounding = 1e-3F;

/// Parameters of one kind of part, measured on NYU's rooms.
struct Treatment {
  /// Whether each column is scaled to variance 1. Labels are not: those that hardly vary are mostly noise.
  bool standardized;
  double weight;  ///< weight of the part's squared distances among all
};

Treatment treatmentOf(PartKind kind) {
  return kind == PartKind::probabilities ? Treatment{false, 1} : Treatment{true, 0.2};
}

/// The labels of a distribution, or some of them, add up to at most 1 (up to rounding), those of a detector
/// (coco-ssd on NYU's training half) to more in all images; a single image may be an outlier. Labels that
/// lack more than 1 % of the whole are a selection, unless zeros have the rest: it is informative.
LabelSums sumsOf(const Features& features, std::size_t first, std::size_t size) {
  const std::size_t n = features.values.size();
  std::size_t above = 0;
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const DescriptorView values = features.values.row(i).subspan(first, size);
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    above += sum > 1.001 ? 1 : 0;
    mean += (missingProbability(values) > 0 ? 1 : sum) / static_cast<double>(n);
  }
  if (static_cast<double>(above) > 0.05 * static_cast<double>(n)) return LabelSums::independent;
  return mean < 0.99 ? LabelSums::selection : LabelSums::whole;
}

/// ln(p / (1 − p)), with p clamped to 1e-7 from 0 and 1.
float logOdds(float p) {
  const double kept = std::clamp(static_cast<double>(p), 1e-7, 1 - 1e-7);
  return static_cast<float>(std::log(kept / (1 - kept)));
}

/// Logarithms centered over the values and the rest to 1, which has no column. `out` may be `values`.
void embedSelection(std::span<const float> values, std::span<float> out) {
  const double rest = 1 - std::accumulate(values.begin(), values.end(), 0.0);
  double sum = std::log(std::max(rest, 0.0) + clrFloor);
  for (std::size_t c = 0; c < values.size(); ++c)
    sum += out[c] = std::log(std::max(values[c], 0.0F) + clrFloor);
  const auto mean = static_cast<float>(sum / static_cast<double>(values.size() + 1));
  for (float& value : out) value -= mean;
}

void embedPart(PartKind kind, LabelSums sums, std::span<const float> values, std::span<float> out) {
  if (kind == PartKind::histogram) return embed(Embedding::squareRoot, values, out);
  if (kind == PartKind::energies)
    std::transform(values.begin(), values.end(), out.begin(),
                   [](float value) { return std::copysign(std::sqrt(std::fabs(value)), value); });
  else if (sums == LabelSums::independent)
    std::transform(values.begin(), values.end(), out.begin(), logOdds);
  else if (sums == LabelSums::selection)
    embedSelection(values, out);
  else
    embed(Embedding::centeredLogRatio, values, out);
}

/// `kind` is that of the training data: the kind of a table is guessed from its numbers.
void requireSound(const DescriptorPart& part, PartKind kind, std::span<const float> values,
                  const std::string& frame) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!std::isfinite(values[c]))
      fail(ErrorCode::invalidInput, "{}: column \"{}\" of {} is {}; describe the frame again or leave it out",
           frame, part.columns[c], part.name, values[c]);
    if (values[c] < 0 && kind != PartKind::energies)
      fail(ErrorCode::invalidInput, "{}: column \"{}\" of {} is {}; give 0 or more", frame, part.columns[c],
           part.name, values[c]);
    if (values[c] > 1 + rounding && kind == PartKind::probabilities)
      fail(ErrorCode::invalidInput,
           "{}: column \"{}\" of {} is {}, above 1; does its network need softmax or sigmoid?", frame,
           part.columns[c], part.name, values[c]);
  }
}

/// The columns of a learned part in the features; none for labels that are missing there.
struct Place {
  const DescriptorPart* part;
  std::size_t first;  ///< column of the features
  std::vector<std::optional<std::size_t>> columns;
};

/// The n-th column of a name is matched with the n-th of that name: ImageNet has two cranes.
std::vector<std::optional<std::size_t>> matched(const std::vector<std::string>& wanted,
                                                const std::vector<std::string>& available) {
  std::map<std::pair<std::string, int>, std::size_t> places;
  std::map<std::string, int> seen;
  for (std::size_t c = 0; c < available.size(); ++c) places[{available[c], seen[available[c]]++}] = c;
  seen.clear();
  std::vector<std::optional<std::size_t>> columns;
  for (const std::string& name : wanted) {
    const auto found = places.find({name, seen[name]++});
    columns.push_back(found == places.end() ? std::nullopt : std::optional(found->second));
  }
  return columns;
}

Place placeOf(const DescriptorPart& learned, const Features& features) {
  std::vector<std::string> names;
  std::size_t first = 0;
  for (const DescriptorPart& part : features.parts) {
    names.push_back(part.name);
    if (part.name != learned.name) {
      first += part.size();
      continue;
    }
    if (part.identity != learned.identity)
      fail(ErrorCode::mismatch,
           "this classifier was trained on {} of {}, but the images have that of {}; describe them alike, or "
           "train again",
           learned.name, learned.identity, part.identity);
    Place place{&part, first, matched(learned.columns, part.columns)};
    const auto known = static_cast<std::size_t>(std::count_if(place.columns.begin(), place.columns.end(),
                                                              [](const auto& c) { return c.has_value(); }));
    const bool areLabels = learned.kind == PartKind::probabilities;
    if (known == 0 || (!areLabels && part.columns != learned.columns))
      fail(ErrorCode::mismatch,
           "this classifier was trained on {} columns of {} (\"{}\" …), but the images have {} (\"{}\" …); "
           "describe them with that vocabulary, or train again",
           learned.size(), learned.name, learned.columns.front(), part.size(),
           part.columns.empty() ? "" : part.columns.front());
    return place;
  }
  fail(ErrorCode::mismatch,
       "this classifier needs {}, but the images have only {}; describe them with it, too, or train again",
       learned.name, fmt::join(names, ", "));
}

}  // namespace

std::size_t FeatureEmbedding::columns() const {
  std::size_t sum = 0;
  for (const PartEmbedding& part : parts_) sum += part.part.size();
  return sum;
}

bool FeatureEmbedding::isInformative() const {
  return std::ranges::any_of(parts_, [](const PartEmbedding& part) {
    return std::ranges::any_of(part.scale, [](float scale) { return scale != 0; });
  });
}

FeatureEmbedding FeatureEmbedding::learn(const Features& features) {
  if (features.parts.empty() || features.values.size() == 0)
    throw Error(ErrorCode::insufficientData, "there are no described images to learn from; give some");
  FeatureEmbedding embedding;
  const auto n = static_cast<double>(features.values.size());
  double weights = 0;  // sum over the parts that vary
  std::vector<double> variances;
  std::size_t first = 0;
  for (const DescriptorPart& part : features.parts) {
    const std::size_t size = part.size();
    if (size == 0) fail(ErrorCode::invalidInput, "part {} has no columns; leave it out", part.name);
    std::vector<double> sums(size), squares(size);
    std::vector<float> mean(size), scale(size), row(size);
    const LabelSums sum =
        part.kind == PartKind::probabilities ? sumsOf(features, first, size) : LabelSums::whole;
    const auto embedded = [&](std::size_t i) {
      const DescriptorView values = features.values.row(i).subspan(first, size);
      embedPart(part.kind, sum, values, row);
    };
    for (std::size_t i = 0; i < features.values.size(); ++i) {
      requireSound(part, part.kind, features.values.row(i).subspan(first, size), features.frames[i].name);
      embedded(i);
      for (std::size_t c = 0; c < size; ++c) sums[c] += row[c];
    }
    for (std::size_t c = 0; c < size; ++c) mean[c] = static_cast<float>(sums[c] / n);
    for (std::size_t i = 0; i < features.values.size(); ++i) {
      embedded(i);
      for (std::size_t c = 0; c < size; ++c) {
        const double d = static_cast<double>(row[c]) - mean[c];
        squares[c] += d * d;
      }
    }
    const Treatment treatment = treatmentOf(part.kind);
    double all = 0;  // the part's variance after scaling
    for (std::size_t c = 0; c < size; ++c) {
      const double sigma = std::sqrt(squares[c] / n);
      // Values that differ by rounding only count as equal.
      if (sigma <= 1e-6 * std::fabs(mean[c]) || sigma < 1e-12) continue;
      const double inverse = treatment.standardized ? 1 / sigma : 1;
      all += inverse * inverse * sigma * sigma;
      scale[c] = static_cast<float>(inverse);
    }
    if (all > 0) weights += treatment.weight;
    variances.push_back(all);
    embedding.parts_.push_back({part, sum, std::move(mean), std::move(scale)});
    first += size;
  }
  for (std::size_t p = 0; p < variances.size(); ++p) {
    PartEmbedding& part = embedding.parts_[p];
    if (variances[p] == 0) continue;
    const double share = std::sqrt(treatmentOf(part.part.kind).weight / weights / variances[p]);
    for (float& value : part.scale) value = static_cast<float>(value * share);
  }
  return embedding;
}

DescriptorMatrix FeatureEmbedding::apply(const Features& features) const {
  std::vector<Place> places;
  for (const PartEmbedding& part : parts_) places.push_back(placeOf(part.part, features));
  DescriptorMatrix result(columns());
  result.reserve(features.values.size());
  std::vector<float> row(columns());
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::size_t first = 0;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const PartEmbedding& learned = parts_[p];
      const DescriptorView values = features.values.row(i).subspan(places[p].first, places[p].part->size());
      requireSound(*places[p].part, learned.part.kind, values, features.frames[i].name);
      const std::span<float> out = std::span(row).subspan(first, learned.part.size());
      for (std::size_t c = 0; c < out.size(); ++c)
        out[c] = places[p].columns[c] ? values[*places[p].columns[c]] : 0;
      embedPart(learned.part.kind, learned.sums, out, out);
      for (std::size_t c = 0; c < out.size(); ++c) out[c] = (out[c] - learned.mean[c]) * learned.scale[c];
      first += out.size();
    }
    result.append(row);
  }
  return result;
}

void FeatureEmbedding::write(ByteWriter& out) const {
  out.number(static_cast<std::uint64_t>(parts_.size()));
  for (const PartEmbedding& part : parts_) {
    out.text(part.part.name);
    out.number(static_cast<std::uint8_t>(part.part.kind));
    out.number(static_cast<std::uint8_t>(part.sums));
    out.text(part.part.identity);
    out.number(static_cast<std::uint64_t>(part.part.size()));
    for (const std::string& column : part.part.columns) out.text(column);
    out.numbers(part.mean);
    out.numbers(part.scale);
  }
}

FeatureEmbedding FeatureEmbedding::read(ByteReader& in) {
  FeatureEmbedding embedding;
  const std::size_t parts = in.count(1);
  if (parts == 0) in.fail("it is damaged (it has no parts)");
  for (std::size_t p = 0; p < parts; ++p) {
    PartEmbedding part;
    part.part.name = in.text();
    const auto kind = in.number<std::uint8_t>();
    if (kind > static_cast<std::uint8_t>(PartKind::energies))
      in.fail("it is damaged (a part of an unknown kind)");
    part.part.kind = static_cast<PartKind>(kind);
    const auto sums = in.number<std::uint8_t>();
    if (sums > static_cast<std::uint8_t>(LabelSums::selection)) in.fail("it is damaged (unknown label sums)");
    part.sums = static_cast<LabelSums>(sums);
    part.part.identity = in.text();
    const std::size_t columns = in.count(sizeof(std::uint32_t));
    for (std::size_t c = 0; c < columns; ++c) part.part.columns.push_back(in.text());
    part.mean = in.numbers<float>();
    part.scale = in.numbers<float>();
    const auto finite = [](float v) { return std::isfinite(v); };
    if (columns == 0 || part.mean.size() != columns || part.scale.size() != columns ||
        !std::ranges::all_of(part.mean, finite) || !std::all_of(part.scale.begin(), part.scale.end(), finite))
      in.fail(fmt::format("it is damaged (the numbers of {} are invalid)", part.part.name));
    embedding.parts_.push_back(std::move(part));
  }
  return embedding;
}

}  // namespace estancia
