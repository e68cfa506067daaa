// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/label_selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string_view>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

using Scores = std::vector<double>;

/// The rooms of the frames as numbers from 0 on; −1 where unknown.
struct Rooms {
  std::vector<int> of;
  std::vector<double> counts;
  double total = 0;
};

Rooms roomsOf(const std::vector<Frame>& frames) {
  std::map<std::string, int> numbers;
  Rooms rooms;
  for (const Frame& frame : frames) {
    rooms.of.push_back(frame.room.empty()
                           ? -1
                           : numbers.try_emplace(frame.room, static_cast<int>(numbers.size())).first->second);
    if (frame.room.empty()) continue;
    rooms.counts.resize(numbers.size());
    ++rooms.counts[static_cast<std::size_t>(rooms.of.back())];
    ++rooms.total;
  }
  if (rooms.counts.empty())
    throw Error(ErrorCode::insufficientData, "no frame has a known room; give a table of rooms (--rooms)");
  return rooms;
}

Scores means(const Features& training) {
  Scores sums(training.values.labels());
  for (std::size_t i = 0; i < training.values.size(); ++i)
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += training.values.row(i)[c];
  for (double& sum : sums) sum /= static_cast<double>(training.values.size());
  return sums;
}

Scores mutualInformation(const Features& training) {
  const Rooms rooms = roomsOf(training.frames);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rooms.of.size(); ++i)
    if (rooms.of[i] >= 0) order.push_back(i);
  Scores scores(training.values.labels());
  for (std::size_t c = 0; c < scores.size(); ++c) {
    const auto value = [&](std::size_t i) { return training.values.row(i)[c]; };
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
    // Equal values share the bin of the first of them.
    std::vector<std::vector<double>> joint(valueBins, std::vector<double>(rooms.counts.size()));
    std::vector<double> ofBin(valueBins);
    for (std::size_t k = 0, bin = 0; k < order.size(); ++k) {
      if (k == 0 || value(order[k]) != value(order[k - 1])) bin = k * valueBins / order.size();
      ++joint[bin][static_cast<std::size_t>(rooms.of[order[k]])];
      ++ofBin[bin];
    }
    for (std::size_t b = 0; b < valueBins; ++b)
      for (std::size_t r = 0; r < rooms.counts.size(); ++r)
        if (joint[b][r] > 0)
          scores[c] +=
              joint[b][r] / rooms.total * std::log(joint[b][r] * rooms.total / ofBin[b] / rooms.counts[r]);
  }
  return scores;
}

Scores chiSquared(const Features& training) {
  const Rooms rooms = roomsOf(training.frames);
  const std::size_t columns = training.values.labels();
  std::vector<Scores> observed(rooms.counts.size(), Scores(columns));
  for (std::size_t i = 0; i < rooms.of.size(); ++i) {
    if (rooms.of[i] < 0) continue;
    for (std::size_t c = 0; c < columns; ++c) {
      const float value = training.values.row(i)[c];
      if (value < 0)
        fail(ErrorCode::invalidInput,
             "{}: column {} is {}, and chi2 needs 0 or more; select by mutual-information",
             training.frames[i].name, c, value);
      observed[static_cast<std::size_t>(rooms.of[i])][c] += value;
    }
  }
  Scores scores(columns);
  for (std::size_t c = 0; c < columns; ++c) {
    double sum = 0;
    for (const Scores& room : observed) sum += room[c];
    for (std::size_t r = 0; sum > 0 && r < observed.size(); ++r) {
      const double expected = rooms.counts[r] / rooms.total * sum, difference = observed[r][c] - expected;
      scores[c] += difference * difference / expected;
    }
  }
  return scores;
}

struct Criterion {
  std::string_view name;
  const char* explanation;
  Scores (*scores)(const Features&);
};

constexpr Criterion criteria[] = {
    {"mean", "labels with the largest mean, as in the thesis", means},
    {"mutual-information", "labels with the largest mutual information with the room", mutualInformation},
    {"chi2", "labels whose sums differ most between rooms", chiSquared},
};

}  // namespace

Choices selectionCriteria() {
  Choices all;
  for (const Criterion& criterion : criteria)
    all.push_back({std::string(criterion.name), criterion.explanation});
  return all;
}

std::vector<double> columnScores(const Features& training, const std::string& criterion) {
  requireChoice("criterion", criterion, selectionCriteria());
  if (training.values.size() == 0)
    throw Error(ErrorCode::insufficientData, "there are no frames to select labels by; give some");
  for (std::size_t i = 0; i < training.values.size(); ++i)
    for (const float value : training.values.row(i))
      if (!std::isfinite(value))
        fail(ErrorCode::invalidInput, "{}: a value is {}; describe the frame again or leave it out",
             training.frames[i].name, value);
  return std::ranges::find(criteria, criterion, &Criterion::name)->scores(training);
}

std::vector<std::size_t> selectColumns(const Features& training, const std::string& criterion,
                                       std::size_t count) {
  const Scores scores = columnScores(training, criterion);
  if (count == 0 || count > scores.size())
    fail(ErrorCode::invalidInput, "cannot select {} of the {} columns of {}; choose 1 to {}", count,
         scores.size(), training.name(), scores.size());
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  order.resize(count);
  return order;
}

Features withColumns(const Features& features, std::vector<std::size_t> columns) {
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  if (columns.empty() || columns.back() >= features.values.labels())
    fail(ErrorCode::invalidInput, "the selected columns end with {}; choose from 0 to {}",
         columns.empty() ? "none" : fmt::format("{}", columns.back()), features.values.labels() - 1);
  Features result{{}, features.frames, DescriptorMatrix(columns.size())};
  std::size_t first = 0;
  for (const DescriptorPart& whole : features.parts) {
    DescriptorPart part{whole.name, whole.kind, {}, whole.identity};
    for (const std::size_t column : columns)
      if (column >= first && column < first + whole.size())
        part.columns.push_back(whole.columns[column - first]);
    if (!part.columns.empty()) result.parts.push_back(std::move(part));
    first += whole.size();
  }
  result.values.reserve(features.values.size());
  std::vector<float> row(columns.size());
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c) row[c] = features.values.row(i)[columns[c]];
    result.values.append(row);
  }
  return result;
}

}  // namespace estancia
